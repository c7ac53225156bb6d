//! The thread that makes frames, and that lets clients in.

use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::client::{Client, Frame};
use super::message::{Figures, Shown, Words, text};
use super::picture::Picture;
use super::rates::{EVERY, Point, Recent, State};
use super::{HandMesh, Shared, lock};
use crate::Meter;

/// From one frame to the next.
const FRAME: Duration = Duration::from_micros(33_333);

/// Connections, watching or not, at most.
const MOST_CLIENTS: usize = 24;

pub(super) struct Painter {
    shared: Arc<Shared>,
    listener: TcpListener,
    meter: Arc<Meter>,
    mesh: Option<HandMesh>,
    picture: Picture,
    /// Counts of events, all 0 between two frames.
    counts: Vec<u8>,
    recent: Recent,
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
        let counts = vec![0; 2 * super::plane::Cells::of(sensor).len()];
        Self {
            shared,
            listener,
            meter,
            mesh,
            picture: Picture::new(sensor),
            counts,
            recent: Recent::new(),
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
            self.greet();
            if now >= measured + EVERY {
                measured = now.max(measured + EVERY);
                figures = self.measure(now);
            }
            if self.shared.watchers.load(Ordering::Relaxed) > 0 {
                let passed = now.saturating_duration_since(std::mem::replace(&mut painted, now));
                let frame = self.paint(&figures, now, passed);
                self.clients.iter().for_each(|client| client.give(frame.clone()));
            }
            next = (next + FRAME).max(now);
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
        }
        self.clients.into_iter().for_each(Client::end);
    }

    /// Forgets who is gone, and lets others in.
    fn greet(&mut self) {
        let (gone, here) = self.clients.drain(..).partition(|client| client.is_gone());
        self.clients = here;
        Vec::into_iter(gone).for_each(Client::end);
        // What cannot be accepted now may be so later.
        while self.clients.len() < MOST_CLIENTS
            && let Ok((stream, _)) = self.listener.accept()
        {
            // One who cannot be served is closed.
            self.clients.extend(Client::start(stream, self.shared.clone()));
        }
    }

    fn measure(&mut self, now: Instant) -> Figures {
        let report = self.meter.report();
        let (network, between) = {
            let mut newest = lock(&self.shared.newest);
            (newest.network.turn(), newest.between.turn())
        };
        let rates = self.recent.take(report, now);
        let point = Point::new(report.seconds, &rates, network, between);
        point.join(&mut lock(&self.shared.history));
        Figures { point, rates, report }
    }

    fn paint(&mut self, figures: &Figures, now: Instant, passed: Duration) -> Frame {
        let t = lock(&self.shared.plane).take(&mut self.counts);
        let (is_over, network, between) = {
            let newest = lock(&self.shared.newest);
            (newest.is_over, Shown::newest(&newest.network), Shown::newest(&newest.between))
        };
        let state = self.recent.state(is_over, now);
        // The last picture of a recording stays.
        let passed_s = if state == State::Ended { 0.0 } else { passed.as_secs_f64() };
        self.picture.add(&mut self.counts, passed_s);
        // Of two hands at once only one has a surface.
        let mesh_of_network = self.mesh.as_mut().filter(|_| between.is_none());
        let network = network.map(|(shown, answer)| shown.drawn(&answer, mesh_of_network));
        let between = between.map(|(shown, answer)| shown.drawn(&answer, self.mesh.as_mut()));
        let t_us = t.map(|t| t.0);
        let words = Words { kind: "frame", state, t_us, network, between, figures };
        Frame { picture: self.picture.message().into(), words: text(&words).into() }
    }
}
