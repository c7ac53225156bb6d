//! The thread that renders frames and accepts clients.

use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::client::{Client, Frame};
use super::event_image::EventImage;
use super::message::{Figures, FrameMessage, PoseMessage, to_json};
use super::rates::{INTERVAL, Point, RateWindow, State};
use super::{HandMesh, Shared, lock};
use crate::Meter;

/// Frame interval: 30 frames per second.
const FRAME: Duration = Duration::from_micros(33_333);

/// Upper bound of connections, watchers and others.
const MAX_CLIENTS: usize = 24;

pub(super) struct Painter {
    shared: Arc<Shared>,
    listener: TcpListener,
    meter: Arc<Meter>,
    mesh: Option<HandMesh>,
    event_image: EventImage,
    /// Counts of events, zero outside of [`Self::paint`].
    counts: Vec<u8>,
    recent: RateWindow,
    clients: Vec<Client>,
}

impl Painter {
    pub(super) fn new(
        shared: Arc<Shared>,
        listener: TcpListener,
        meter: Arc<Meter>,
        mesh: Option<HandMesh>,
    ) -> Self {
        let sensor = shared.about.sensor();
        let counts = vec![0; 2 * super::event_counts::Cells::for_sensor(sensor).len()];
        Self {
            shared,
            listener,
            meter,
            mesh,
            event_image: EventImage::new(sensor),
            counts,
            recent: RateWindow::new(),
            clients: Vec::new(),
        }
    }

    /// Works until the page is dropped.
    pub(super) fn work(mut self) {
        let mut next = Instant::now();
        let (mut measured, mut painted) = (next, next);
        let mut figures = self.measure(next);
        while !self.shared.is_over.load(Ordering::Relaxed) {
            let now = Instant::now();
            self.update_clients();
            if now >= measured + INTERVAL {
                measured = now.max(measured + INTERVAL);
                figures = self.measure(now);
            }
            // Frames are painted only for somebody.
            if self.shared.watchers.load(Ordering::Relaxed) > 0 {
                let passed = now.saturating_duration_since(std::mem::replace(&mut painted, now));
                let frame = self.paint(&figures, now, passed);
                self.clients.iter().for_each(|client| client.send(frame.clone()));
            }
            // A late frame is not made up for: a burst of frames would be late as well.
            next = (next + FRAME).max(now);
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
        }
        self.clients.into_iter().for_each(Client::end);
    }

    /// Removes finished clients, and accepts new ones.
    fn update_clients(&mut self) {
        let (finished, open) = self.clients.drain(..).partition(|client| client.is_finished());
        self.clients = open;
        Vec::into_iter(finished).for_each(Client::end);
        // Failed accepts are retried with the next frame.
        while let Some(room) = self.room()
            && let Ok((stream, _)) = self.listener.accept()
        {
            // The oldest of those that send their requests slowly leaves for it.
            if let Some(slow) = room {
                self.clients.remove(slow).end();
            }
            // A connection without a thread is closed.
            self.clients.extend(Client::start(stream, self.shared.clone()));
        }
    }

    /// Whether another client may come, and which has to leave for it.
    fn room(&self) -> Option<Option<usize>> {
        if self.clients.len() < MAX_CLIENTS {
            return Some(None);
        }
        self.clients.iter().position(Client::gives_way).map(Some)
    }

    fn measure(&mut self, now: Instant) -> Figures {
        let report = self.meter.report();
        let (network, propagated) = {
            let mut newest = lock(&self.shared.newest);
            (newest.network.rotate(), newest.propagated.rotate())
        };
        let rates = self.recent.push(report, now);
        let point = Point::new(report.seconds, &rates, network, propagated);
        point.join(&mut lock(&self.shared.history));
        Figures { point, rates, report }
    }

    fn paint(&mut self, figures: &Figures, now: Instant, passed: Duration) -> Frame {
        let t = lock(&self.shared.event_counts).swap(&mut self.counts);
        // Poses are copied under the lock and serialised without it, since the sink waits for it.
        let (is_over, network, propagated) = {
            let newest = lock(&self.shared.newest);
            (
                newest.is_over,
                PoseMessage::newest(&newest.network),
                PoseMessage::newest(&newest.propagated),
            )
        };
        let state = self.recent.state(is_over, now);
        // The last event image of a recording stays.
        let passed_s = if state == State::Ended { 0.0 } else { passed.as_secs_f64() };
        self.event_image.add(&mut self.counts, passed_s);
        // Only the newest hand is drawn as a mesh.
        let mesh_of_network = self.mesh.as_mut().filter(|_| propagated.is_none());
        let network = network.map(|(pose, estimate)| pose.drawn(&estimate, mesh_of_network));
        let propagated =
            propagated.map(|(pose, estimate)| pose.drawn(&estimate, self.mesh.as_mut()));
        let t_us = t.map(|t| t.0);
        let message = FrameMessage { kind: "frame", state, t_us, network, propagated, figures };
        Frame { event_image: self.event_image.message().into(), text: to_json(&message).into() }
    }
}
