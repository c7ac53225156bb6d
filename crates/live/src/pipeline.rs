//! The pipeline from events to poses, on three threads.
//!
//! * The feeder waits for the source, validates its events and fills the queue.
//! * The front end, on the caller's thread, updates the representation and propagates poses.
//! * The inference worker takes the newest input whenever it is idle. Of a source that is lossless
//!   and has no pace, it takes the input of every stride: poses then depend on the events alone.

mod clock;
mod feeder;
mod inference;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::Duration;

use evpose_core::{EventStream, Micros, TimeWindow};

use crate::queue::PopOutcome;
use crate::sink::Sinks;
use crate::source::Source;
use crate::{LiveError, LivePose, Meter, Packet, PacketQueue, PoseOrigin, Report};
use clock::Clock;
use evpose_pose::stream::{InferenceWorker, PoseStream, StreamFrontend};
use feeder::Feeder;
use inference::{InferenceHandle, InferenceJob, Inferred};

/// Options of a pipeline.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveOptions {
    /// Propagated poses per second of event time; 0 for none.
    pub propagate_hz: f64,
    /// Minimum event time from one input of the network to the next.
    pub stride: Micros,
    /// Capacity of the queue in packets.
    pub max_packets: usize,
    /// Capacity of the queue in events.
    pub max_events: usize,
    /// Host time without events after which the source counts as stalled.
    pub stall: Duration,
    /// Host time without events after which the pipeline ends with an error.
    pub give_up: Option<Duration>,
}

impl Default for LiveOptions {
    fn default() -> Self {
        Self {
            propagate_hz: 500.0,
            stride: Micros(1_000),
            max_packets: 16,
            max_events: 1 << 20,
            stall: Duration::from_millis(500),
            give_up: None,
        }
    }
}

/// A callback with the events of every packet, on the front end's thread: it must be quick.
pub type Observer = Arc<dyn Fn(&EventStream) + Send + Sync>;

/// Handle to watch and to stop a running pipeline.
#[derive(Clone, Default)]
pub struct Control {
    stop: Arc<AtomicBool>,
    /// Counters of the pipeline.
    pub meter: Arc<Meter>,
    /// Callback with the events.
    pub observer: Option<Observer>,
}

impl Control {
    /// Requests that the pipeline ends after the current packet.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether a stop was requested.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Interval at which waiting threads check for a stop request: short enough that Ctrl-C feels
/// immediate.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Interval at which the follower looks whether more of a recording has been read.
const HORIZON_INTERVAL: Duration = Duration::from_millis(2);

/// Runs the stream on the events of `source` and sends its poses to `sinks`, until the source ends,
/// [`Control::stop`] is called, or every sink has failed; [`Sinks::finish`] returns the errors of
/// sinks.
///
/// # Errors
/// If the source or the stream fails; every pose before that has been sent to the sinks.
pub fn run<F, W>(
    source: Box<dyn Source>,
    stream: PoseStream<F, W>,
    sinks: &mut Sinks,
    options: &LiveOptions,
    control: &Control,
) -> Result<Report, LiveError>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    let queue = Arc::new(PacketQueue::new(options.max_packets, options.max_events));
    let clock = Clock::new(source.pace(), options.stall);
    let is_lossless = source.is_lossless();
    let mode = Mode { is_lossless, infers_all: is_lossless && source.pace().is_none() };
    let horizon = source.horizon();
    let feeder = Feeder::start(source, queue.clone(), control.meter.clone());
    let PoseStream { frontend, mut worker, .. } = stream;
    // Scoped, so that the follower may borrow the sinks of the caller.
    let ended = std::thread::scope(|scope| {
        let (inference, thread) = InferenceHandle::new(queue.clone());
        scope.spawn(move || thread.run(&mut worker));
        let mut follower =
            Follower::new(frontend, inference, clock, mode, sinks, (options, control));
        follower.horizon = horizon;
        follower.run(&queue)
    });
    // A feeder that is blocked on an abandoned source must not block the caller.
    queue.abandon();
    // A source that has not ended is woken first, or abandoned if nothing wakes it.
    let fed = feeder.end(control.is_stopped() || sinks.have_all_failed() || ended.is_err());
    let report = control.meter.report();
    // If the stream failed, its source was abandoned and has no error.
    ended?;
    fed?;
    Ok(report)
}

/// Treatment of events and inputs that come faster than they are processed.
#[derive(Debug, Clone, Copy)]
struct Mode {
    /// Sinks that are slow are waited for.
    is_lossless: bool,
    /// The network is waited for at every stride.
    infers_all: bool,
}

/// The front end's loop.
struct Follower<'a, F: StreamFrontend> {
    frontend: F,
    inference: InferenceHandle<F::Input, F::Output>,
    clock: Clock,
    mode: Mode,
    sinks: &'a mut Sinks,
    options: &'a LiveOptions,
    control: &'a Control,
    /// Interval of propagated poses.
    step: Option<Micros>,
    next_propagated: Option<Micros>,
    next_image: Option<Micros>,
    memory: Option<F::Input>,
    /// Index of the recording: outputs for an earlier one are dropped.
    recording: u64,
    now: Micros,
    has_stalled: bool,
    /// [`Source::horizon`].
    horizon: Option<Arc<AtomicI64>>,
}

impl<'a, F: StreamFrontend> Follower<'a, F> {
    fn new(
        frontend: F,
        inference: InferenceHandle<F::Input, F::Output>,
        clock: Clock,
        mode: Mode,
        sinks: &'a mut Sinks,
        (options, control): (&'a LiveOptions, &'a Control),
    ) -> Self {
        // Steps that round to 0 µs would never pass the next event.
        let step = (options.propagate_hz > 0.0)
            .then(|| Micros(((1e6 / options.propagate_hz).round() as i64).max(1)));
        Self {
            frontend,
            inference,
            clock,
            mode,
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
            horizon: None,
        }
    }

    fn run(&mut self, queue: &PacketQueue) -> Result<(), LiveError> {
        loop {
            // Never longer than the interval: stopping must be noticed without events.
            let next = match self.next_propagated.filter(|t| !self.is_within_horizon(*t)) {
                None => self.clock.until(self.next_propagated),
                // More of the recording may be read at any time.
                Some(_) => Some(HORIZON_INTERVAL),
            };
            match queue.pop(next.map_or(POLL_INTERVAL, |next| next.min(POLL_INTERVAL))) {
                PopOutcome::Packet(packet) => {
                    self.has_stalled = false;
                    self.take(&packet)?;
                    if let Some(observer) = &self.control.observer {
                        observer(&packet.events);
                    }
                    // The feeder fills the buffer again, instead of allocating one for each packet.
                    queue.recycle(packet.events);
                }
                PopOutcome::Empty => self.wait()?,
                PopOutcome::Closed => break,
            }
            while let Some(inferred) = self.inference.try_finished()? {
                self.accept(inferred);
            }
            if self.control.is_stopped() || self.sinks.have_all_failed() {
                return Ok(());
            }
        }
        // The running inference belongs to the recording, too.
        if let Some(inferred) = self.inference.wait_for_last()? {
            self.accept(inferred);
        }
        Ok(())
    }

    /// Handles a timeout of the queue: propagates poses by the clock and detects stalls.
    fn wait(&mut self) -> Result<(), LiveError> {
        // No events are information, too: the pose is propagated by the clock.
        while let Some((step, tick)) = self.step.zip(self.next_propagated)
            && self.is_within_horizon(tick)
            && self.clock.until(Some(tick)) == Some(Duration::ZERO)
        {
            // Detections that arrive later arrive after what has been propagated.
            self.now = self.now.max(tick);
            self.propagate(tick);
            self.next_propagated = Some(tick + step);
        }
        let silence = self.clock.silence();
        // Counted once a silence, not once a timeout.
        if silence >= self.options.stall && !self.has_stalled {
            self.has_stalled = true;
            self.control.meter.stalls.add(1);
        }
        match self.options.give_up.filter(|limit| silence >= *limit) {
            None => Ok(()),
            Some(limit) => Err(LiveError::Source {
                name: "the source".to_owned(),
                reason: format!("no events for {:.1} s", limit.as_secs_f64()),
            }),
        }
    }

    /// Whether the recording goes on until event time `t`, as far as it has been read.
    fn is_within_horizon(&self, t: Micros) -> bool {
        self.horizon.as_ref().is_none_or(|horizon| t.0 <= horizon.load(Ordering::Relaxed))
    }

    fn take(&mut self, packet: &Packet) -> Result<(), LiveError> {
        let events = &packet.events;
        let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
            return Ok(());
        };
        // Another recording: nothing of the one before may show in its poses.
        if packet.is_restart {
            self.frontend.reset();
            self.recording += 1;
            (self.next_propagated, self.next_image, self.now) = (None, None, first);
        }
        // The newest time is read before the update, since a gap is measured from the packet
        // before.
        let newest = self.clock.newest().filter(|_| !packet.is_restart).unwrap_or(first);
        self.clock.update(last, packet.host_time);
        let stall = i64::try_from(self.options.stall.as_micros()).unwrap_or(i64::MAX);
        let mut pushed = first;
        // Propagated in between: a packet may be longer than a step.
        while let Some((step, tick)) =
            self.step.zip(self.next_propagated).filter(|(_, t)| *t <= last)
        {
            // After a gap, poses of the time without events are of no use.
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
        // The end of a window is not in it.
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
        self.submit(last)
    }

    /// Starts an inference, if none is running and a stride has passed.
    fn submit(&mut self, t: Micros) -> Result<(), LiveError> {
        if self.next_image.is_some_and(|next| t < next) {
            return Ok(());
        }
        // Front ends that batch inputs take one at each stride, also while the network is busy.
        self.frontend.stride(t);
        let stride = self.options.stride;
        if self.inference.is_busy() {
            // Counts strides, not packets.
            if let Some(next) = self.next_image {
                let missed = (t.0 - next.0) / stride.0.max(1) + 1;
                self.control.meter.skipped_strides.add(missed.unsigned_abs());
                self.next_image = Some(Micros(next.0 + missed * stride.0));
            }
            return Ok(());
        }
        // A stride counts from this image: on a fixed grid, two could follow each other at once.
        self.next_image = Some(t + stride);
        match self.frontend.input(t, self.memory.take()) {
            Some(input) => {
                self.control.meter.images.add(1);
                let (recording, clock) = (self.recording, self.clock);
                self.inference.submit(InferenceJob { input, t, recording, clock });
            }
            None => self.control.meter.repeated.add(1),
        }
        // Without a pace nothing is late: each stride waits for its pose.
        if self.mode.infers_all
            && let Some(inferred) = self.inference.wait_for_last()?
        {
            self.accept(inferred);
        }
        Ok(())
    }

    fn accept(&mut self, inferred: Inferred<F::Input, F::Output>) {
        let Inferred { job, output } = inferred;
        // A result of a recording that has ended meanwhile is dropped, but its memory is used
        // again.
        if job.recording == self.recording {
            for (t, pose) in self.frontend.accept(job.t, &job.input, output, self.now) {
                let latency = job.clock.since(t);
                let pose = self.frontend.estimate(&pose);
                self.emit(LivePose { t, latency, origin: PoseOrigin::Network, pose });
            }
        }
        self.memory = Some(job.input);
    }

    fn propagate(&mut self, t: Micros) {
        if let Some(pose) = self.frontend.propagate(t) {
            let latency = self.clock.since(t);
            let origin = self.frontend.origin_between();
            self.emit(LivePose { t, latency, origin, pose });
        }
    }

    fn emit(&mut self, pose: LivePose) {
        self.control.meter.record(&pose);
        let pose = Arc::new(pose);
        let dropped = match self.mode.is_lossless {
            true => self.sinks.send_waiting(&pose),
            false => self.sinks.send(&pose),
        };
        self.control.meter.dropped_poses.add(dropped);
    }
}

#[cfg(test)]
mod tests;
