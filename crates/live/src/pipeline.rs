//! From events to poses, on three threads.
//!
//! * The feeder waits for the source, checks its events and fills the queue.
//! * The eye, on the caller's thread, follows events and makes poses between those of the network.
//! * The network looks at the newest image whenever it is free.

mod clock;
mod feeder;
mod inference;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use evpose_core::{EventStream, Micros, TimeWindow};

use crate::queue::Popped;
use crate::sink::Sinks;
use crate::source::Source;
use crate::{LiveError, LivePose, Meter, Origin, Packet, PacketQueue, Report};
use clock::Clock;
use evpose_pose::stream::InferenceWorker;
use evpose_pose::stream::PoseStream;
use evpose_pose::stream::StreamFrontend;
use feeder::Feeder;
use inference::{InferenceHandle, InferenceJob, Inferred};

/// How a pipeline runs.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveOptions {
    /// Poses a second between those of the network, of the events' clock; 0 for none.
    pub propagate_hz: f64,
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
            propagate_hz: 500.0,
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
pub fn run<F, W>(
    source: impl Source,
    stream: PoseStream<F, W>,
    sinks: &mut Sinks,
    options: &LiveOptions,
    control: &Control,
) -> Result<Report, LiveError>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    let queue = Arc::new(PacketQueue::new(options.most_packets, options.most_events));
    let clock = Clock::new(source.pace(), options.stall);
    let feeder = Feeder::start(source, queue.clone(), control.meter.clone());
    let PoseStream { frontend, mut worker, .. } = stream;
    let ended = std::thread::scope(|scope| {
        let (inference, thread) = InferenceHandle::new(queue.clone());
        scope.spawn(move || thread.run(&mut worker));
        let mut follower = Follower::new(frontend, inference, clock, sinks, options, control);
        follower.run(&queue)
    });
    // Whoever still waits for a source that was left need not be waited for.
    queue.leave();
    let fed = feeder.end(control.is_stopped() || sinks.are_gone() || ended.is_err());
    let report = control.meter.report();
    ended?;
    fed?;
    Ok(report)
}

/// The front end's loop.
struct Follower<'a, F: StreamFrontend> {
    frontend: F,
    inference: InferenceHandle<F::Input, F::Output>,
    clock: Clock,
    sinks: &'a mut Sinks,
    options: &'a LiveOptions,
    control: &'a Control,
    /// Interval of propagated poses.
    step: Option<Micros>,
    next_propagated: Option<Micros>,
    next_image: Option<Micros>,
    /// Memory of an earlier input.
    memory: Option<F::Input>,
    /// Index of the recording: outputs for an earlier one are dropped.
    recording: u64,
    now: Micros,
    has_stalled: bool,
}

impl<'a, F: StreamFrontend> Follower<'a, F> {
    fn new(
        frontend: F,
        inference: InferenceHandle<F::Input, F::Output>,
        clock: Clock,
        sinks: &'a mut Sinks,
        options: &'a LiveOptions,
        control: &'a Control,
    ) -> Self {
        let step = (options.propagate_hz > 0.0)
            .then(|| Micros(((1e6 / options.propagate_hz).round() as i64).max(1)));
        Self {
            frontend,
            inference,
            clock,
            sinks,
            options,
            control,
            step,
            next_propagated: None,
            next_image: None,
            memory: None,
            recording: 0,
            now: Micros(i64::MIN),
            has_stalled: false,
        }
    }

    fn run(&mut self, queue: &PacketQueue) -> Result<(), LiveError> {
        loop {
            let next = self.clock.until(self.next_propagated);
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
            while let Some(inferred) = self.inference.try_finished()? {
                self.accept(inferred);
            }
            if self.control.is_stopped() || self.sinks.are_gone() {
                return Ok(());
            }
        }
        // The running inference belongs to the recording, too.
        if let Some(inferred) = self.inference.wait_for_last()? {
            self.accept(inferred);
        }
        Ok(())
    }

    /// Nothing came.
    fn wait(&mut self) -> Result<(), LiveError> {
        // Nothing that happens is news, too: poses go on by the clock.
        while let Some((step, tick)) = self.step.zip(self.next_propagated)
            && self.clock.until(Some(tick)) == Some(Duration::ZERO)
        {
            self.now = self.now.max(tick);
            self.propagate(tick);
            self.next_propagated = Some(tick + step);
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
            self.frontend.reset();
            self.recording += 1;
            (self.next_propagated, self.next_image, self.now) = (None, None, first);
        }
        let newest = self.clock.newest().filter(|_| !packet.restarts).unwrap_or(first);
        self.clock.take(last, packet.happened);
        let stall = i64::try_from(self.options.stall.as_micros()).unwrap_or(i64::MAX);
        let mut pushed = first;
        while let Some((step, tick)) =
            self.step.zip(self.next_propagated).filter(|(_, t)| *t <= last)
        {
            // Behind a stall there is no use in the poses of all the time that nobody knows of.
            let index = events.t().partition_point(|t| *t < tick);
            let (next, before) = (events.t()[index], index.checked_sub(1));
            if (next - before.map_or(newest, |before| events.t()[before])).0 > stall && tick < next
            {
                let late = Micros(next.0 - (next.0 - tick.0).rem_euclid(step.0));
                self.next_propagated = Some(if late < next { late + step } else { late });
                continue;
            }
            if tick > pushed {
                self.frontend.push(&events.slice(TimeWindow { start: pushed, end: tick }))?;
                pushed = tick;
            }
            self.propagate(tick);
            self.next_propagated = Some(tick + step);
        }
        let end = last + Micros(1);
        if pushed <= first {
            self.frontend.push(events)?;
        } else if pushed < end {
            self.frontend.push(&events.slice(TimeWindow { start: pushed, end }))?;
        }
        self.control.meter.followed.add(events.len() as u64);
        self.now = self.now.max(last);
        if self.next_propagated.is_none() {
            self.next_propagated = self.step.map(|step| last + step);
        }
        self.submit(last);
        Ok(())
    }

    /// Starts an inference, if none is running and a stride has passed.
    fn submit(&mut self, t: Micros) {
        if self.next_image.is_some_and(|next| t < next) {
            return;
        }
        self.frontend.stride(t);
        let stride = self.options.stride;
        if self.inference.is_busy() {
            // One for every stride that passes, not for every packet.
            if let Some(next) = self.next_image {
                let missed = (t.0 - next.0) / stride.0.max(1) + 1;
                self.control.meter.skipped_strides.add(missed.unsigned_abs());
                self.next_image = Some(Micros(next.0 + missed * stride.0));
            }
            return;
        }
        self.next_image = Some(t + stride);
        match self.frontend.input(t, self.memory.take()) {
            Some(input) => {
                self.control.meter.images.add(1);
                let (recording, clock) = (self.recording, self.clock);
                self.inference.submit(InferenceJob { input, t, recording, clock });
            }
            None => self.control.meter.repeated.add(1),
        }
    }

    fn accept(&mut self, inferred: Inferred<F::Input, F::Output>) {
        let Inferred { job, output } = inferred;
        if job.recording == self.recording {
            for (t, pose) in self.frontend.accept(job.t, &job.input, output, self.now) {
                let latency = job.clock.since(t);
                let pose = self.frontend.estimate(&pose);
                self.emit(LivePose { t, latency, origin: Origin::Network, pose });
            }
        }
        self.memory = Some(job.input);
    }

    fn propagate(&mut self, t: Micros) {
        if let Some(pose) = self.frontend.propagate(t) {
            let latency = self.clock.since(t);
            self.emit(LivePose { t, latency, origin: Origin::Propagated, pose });
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
