//! From events to poses, on three threads.
//!
//! * The feeder waits for the source, checks its events and fills the queue.
//! * The eye, on the caller's thread, follows events and makes poses between those of the network.
//! * The network looks at the newest image whenever it is free.

mod clock;
mod feeder;
mod looker;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use evpose_core::{EventStream, Micros, TimeWindow};

use crate::queue::Popped;
use crate::sink::Sinks;
use crate::source::Source;
use crate::{Eye, LiveError, LivePose, Meter, Network, Origin, Packet, PacketQueue, Report, Task};
use clock::Clock;
use feeder::Feeder;
use looker::{Job, Looker};

/// How a pipeline runs.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveOptions {
    /// Poses a second between those of the network, of the events' clock; 0 for none.
    pub between_hz: f64,
    /// Least time between two images of the network, of the events' clock.
    pub stride: Micros,
    /// Packets that wait at most.
    pub most_packets: usize,
    /// Events that wait at most.
    pub most_events: usize,
    /// A source that gives nothing for so long has stalled.
    pub stall: Duration,
    /// The pipeline ends when the source has stalled for so long.
    pub give_up: Option<Duration>,
}

impl Default for LiveOptions {
    fn default() -> Self {
        Self {
            between_hz: 500.0,
            stride: Micros(1_000),
            most_packets: 16,
            most_events: 1 << 20,
            stall: Duration::from_millis(500),
            give_up: None,
        }
    }
}

/// Is shown the events of every packet, on the thread that follows them: it must be quick.
pub type Observer = Arc<dyn Fn(&EventStream) + Send + Sync>;

/// How a pipeline is watched and ended from outside.
#[derive(Clone, Default)]
pub struct Control {
    stop: Arc<AtomicBool>,
    /// What the pipeline did so far.
    pub meter: Arc<Meter>,
    /// Who is shown the events.
    pub observer: Option<Observer>,
}

impl Control {
    /// Has the pipeline end with what it has.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether it was told to.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// How often somebody who waits looks whether to stop.
const LOOK_UP: Duration = Duration::from_millis(50);

/// Turns the events of `source` into poses for `sinks`, until it ends, `control` says so, or no sink is left
/// that takes them: what they failed of is told by [`Sinks::finish`].
///
/// # Errors
/// If the source or the task fail; every pose before that has been given to the sinks.
pub fn run<E: Eye, N: Network<Image = E::Image, Found = E::Found>>(
    source: impl Source,
    task: Task<E, N>,
    sinks: &mut Sinks,
    options: &LiveOptions,
    control: &Control,
) -> Result<Report, LiveError> {
    let queue = Arc::new(PacketQueue::new(options.most_packets, options.most_events));
    let clock = Clock::new(source.pace(), options.stall);
    let feeder = Feeder::start(source, queue.clone(), control.meter.clone());
    let Task { eye, mut network } = task;
    let ended = std::thread::scope(|scope| {
        let (looker, desk) = Looker::new(queue.clone());
        scope.spawn(move || desk.work(&mut network));
        let mut watch = Watch::new(eye, looker, clock, sinks, options, control);
        watch.until_the_end(&queue)
    });
    // Whoever still waits for a source that was left need not be waited for.
    queue.leave();
    let fed = feeder.end(control.is_stopped() || sinks.are_gone() || ended.is_err());
    let report = control.meter.report();
    ended?;
    fed?;
    Ok(report)
}

/// The eye at work.
struct Watch<'a, E: Eye> {
    eye: E,
    looker: Looker<E::Image, E::Found>,
    clock: Clock,
    sinks: &'a mut Sinks,
    options: &'a LiveOptions,
    control: &'a Control,
    /// From one pose between those of the network to the next.
    step: Option<Micros>,
    next_between: Option<Micros>,
    next_image: Option<Micros>,
    /// Memory of the image before.
    memory: Option<E::Image>,
    /// Jobs of an earlier recording are of no use.
    recording: u64,
    now: Micros,
    has_stalled: bool,
}

impl<'a, E: Eye> Watch<'a, E> {
    fn new(
        eye: E,
        looker: Looker<E::Image, E::Found>,
        clock: Clock,
        sinks: &'a mut Sinks,
        options: &'a LiveOptions,
        control: &'a Control,
    ) -> Self {
        let step = (options.between_hz > 0.0)
            .then(|| Micros(((1e6 / options.between_hz).round() as i64).max(1)));
        Self {
            eye,
            looker,
            clock,
            sinks,
            options,
            control,
            step,
            next_between: None,
            next_image: None,
            memory: None,
            recording: 0,
            now: Micros(i64::MIN),
            has_stalled: false,
        }
    }

    fn until_the_end(&mut self, queue: &PacketQueue) -> Result<(), LiveError> {
        loop {
            let next = self.clock.until(self.next_between);
            match queue.pop(next.map_or(LOOK_UP, |next| next.min(LOOK_UP))) {
                Popped::Packet(packet) => {
                    self.has_stalled = false;
                    self.take(&packet)?;
                    if let Some(observer) = &self.control.observer {
                        observer(&packet.events);
                    }
                    queue.give_back(packet.events);
                }
                Popped::Nothing => self.wait()?,
                Popped::Closed => break,
            }
            while let Some(seen) = self.looker.seen()? {
                self.found(seen);
            }
            if self.control.is_stopped() || self.sinks.are_gone() {
                return Ok(());
            }
        }
        // What the network is looking at belongs to the recording, too.
        if let Some(seen) = self.looker.last()? {
            self.found(seen);
        }
        Ok(())
    }

    /// Nothing came.
    fn wait(&mut self) -> Result<(), LiveError> {
        // Nothing that happens is news, too: poses go on by the clock.
        while let Some((step, tick)) = self.step.zip(self.next_between)
            && self.clock.until(Some(tick)) == Some(Duration::ZERO)
        {
            self.now = self.now.max(tick);
            self.between(tick);
            self.next_between = Some(tick + step);
        }
        let silent = self.clock.silent();
        if silent >= self.options.stall && !self.has_stalled {
            self.has_stalled = true;
            self.control.meter.stalls.add(1);
        }
        match self.options.give_up.filter(|most| silent >= *most) {
            None => Ok(()),
            Some(most) => Err(LiveError::Source {
                what: "the source".to_owned(),
                reason: format!("no events for {:.1} s", most.as_secs_f64()),
            }),
        }
    }

    fn take(&mut self, packet: &Packet) -> Result<(), LiveError> {
        let events = &packet.events;
        let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
            return Ok(());
        };
        if packet.restarts {
            self.eye.reset();
            self.recording += 1;
            (self.next_between, self.next_image, self.now) = (None, None, first);
        }
        let newest = self.clock.newest().filter(|_| !packet.restarts).unwrap_or(first);
        self.clock.take(last, packet.happened);
        let stall = i64::try_from(self.options.stall.as_micros()).unwrap_or(i64::MAX);
        let mut pushed = first;
        while let Some((step, tick)) = self.step.zip(self.next_between).filter(|(_, t)| *t <= last)
        {
            // Behind a stall there is no use in the poses of all the time that nobody knows of.
            let index = events.t().partition_point(|t| *t < tick);
            let (next, before) = (events.t()[index], index.checked_sub(1));
            if (next - before.map_or(newest, |before| events.t()[before])).0 > stall && tick < next
            {
                let late = Micros(next.0 - (next.0 - tick.0).rem_euclid(step.0));
                self.next_between = Some(if late < next { late + step } else { late });
                continue;
            }
            if tick > pushed {
                self.eye.push(&events.slice(TimeWindow { start: pushed, end: tick }))?;
                pushed = tick;
            }
            self.between(tick);
            self.next_between = Some(tick + step);
        }
        let end = last + Micros(1);
        if pushed <= first {
            self.eye.push(events)?;
        } else if pushed < end {
            self.eye.push(&events.slice(TimeWindow { start: pushed, end }))?;
        }
        self.control.meter.followed.add(events.len() as u64);
        self.now = self.now.max(last);
        if self.next_between.is_none() {
            self.next_between = self.step.map(|step| last + step);
        }
        self.show(last);
        Ok(())
    }

    /// Has the network look, if it is free and it is time.
    fn show(&mut self, t: Micros) {
        if self.next_image.is_some_and(|next| t < next) {
            return;
        }
        self.eye.stride(t);
        let stride = self.options.stride;
        if self.looker.is_busy() {
            // One for every stride that passes, not for every packet.
            if let Some(next) = self.next_image {
                let missed = (t.0 - next.0) / stride.0.max(1) + 1;
                self.control.meter.skipped_strides.add(missed.unsigned_abs());
                self.next_image = Some(Micros(next.0 + missed * stride.0));
            }
            return;
        }
        self.next_image = Some(t + stride);
        match self.eye.image(t, self.memory.take()) {
            Some(image) => {
                self.control.meter.images.add(1);
                self.looker.show(Job { image, t, recording: self.recording, clock: self.clock });
            }
            None => self.control.meter.repeated.add(1),
        }
    }

    fn found(&mut self, seen: looker::Seen<E::Image, E::Found>) {
        let looker::Seen { job, found } = seen;
        if job.recording == self.recording {
            for (t, answer) in self.eye.found(job.t, &job.image, found, self.now) {
                let latency = job.clock.since(t);
                self.emit(LivePose { t, latency, origin: Origin::Network, answer });
            }
        }
        self.memory = Some(job.image);
    }

    fn between(&mut self, t: Micros) {
        if let Some(answer) = self.eye.between(t) {
            let latency = self.clock.since(t);
            self.emit(LivePose { t, latency, origin: Origin::Between, answer });
        }
    }

    fn emit(&mut self, pose: LivePose) {
        self.control.meter.pose(&pose);
        let dropped = self.sinks.give(&Arc::new(pose));
        self.control.meter.dropped_poses.add(dropped);
    }
}

#[cfg(test)]
mod tests;
