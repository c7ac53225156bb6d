//! A recording through the stream from events to poses: the one way from a file to poses, for every task.
//!
//! # Model
//! Events are read forwards, a tenth of a second of them at a time, and pushed into the front end up to the
//! time of each input. An [`InferenceSchedule`] says when inputs are taken. A silence of more than
//! [`MAX_SILENCE`] parts a recording: the events before it end as the recording would, and those behind it
//! begin as another one. So time without events takes neither memory nor inferences.

use std::time::Instant;

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow};
use evpose_io::{IoError, Windows};
use evpose_pose::stream::{
    InferenceSchedule, InferenceWorker, PoseStream, RemainingEvents, StreamFrontend,
};

use crate::TaskError;

/// Longest time without events within which poses are inferred: somebody at rest. Cameras have noise, so
/// that longer silences are gaps of the recording.
pub const MAX_SILENCE: Micros = Micros(10_000_000);

/// Event time that is read at once.
const CHUNK: Micros = Micros(100_000);

/// Poses that became known together.
#[derive(Debug, Clone, PartialEq)]
pub struct InferredPoses<P> {
    /// Time up to which events were taken.
    pub t: Micros,
    /// The poses with their time stamps, which are earlier in batches; none while a batch is not full.
    pub poses: Vec<(Micros, P)>,
    /// Times before all of these at which too few events had come for an inference.
    pub skipped: Vec<Micros>,
    /// Time from the events to the poses, in seconds.
    pub delay_s: f64,
}

impl<P> InferredPoses<P> {
    fn is_empty(&self) -> bool {
        self.poses.is_empty() && self.skipped.is_empty()
    }
}

/// A recording, read forwards in time through a task's stream. As an iterator, it takes inputs by its
/// schedule; [`Self::infer_at`] takes them at times of the caller.
pub struct RecordingStream<F: StreamFrontend, W> {
    events: ForwardEvents,
    stream: PoseStream<F, W>,
    schedule: InferenceSchedule,
    /// The newest event pushed; none before the first and behind a silence.
    newest: Option<Micros>,
    has_begun: bool,
    next_stride: Option<Micros>,
    strides: u64,
}

impl<F, W> RecordingStream<F, W>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    /// The stream of a recording, from its first event on. The network is always free: inputs of
    /// [`InferenceSchedule::NewestWhenFree`] are those of [`InferenceSchedule::Triggered`].
    pub fn new(windows: Windows, stream: PoseStream<F, W>, schedule: InferenceSchedule) -> Self {
        let events = ForwardEvents::new(windows);
        let (newest, next_stride) = (None, None);
        Self { events, stream, schedule, newest, has_begun: false, next_stride, strides: 0 }
    }

    /// Size of the sensor of the recording.
    pub fn sensor(&self) -> SensorSize {
        self.events.windows.sensor()
    }

    /// Remarks on the content read so far, in sentences without a full stop.
    pub fn warnings(&self) -> Vec<String> {
        let outside = self.events.windows.outside();
        let outside =
            (outside > 0).then(|| format!("{outside} events are outside the sensor: left out"));
        let remarks = self.stream.frontend.remarks().into_iter();
        outside.into_iter().chain(remarks).chain(self.events.windows.remarks()).collect()
    }

    /// When the recording begins and ends; none if it is empty. Only before anything was read.
    ///
    /// # Errors
    /// If it cannot be read to its end.
    pub fn span(&mut self) -> Result<Option<[Micros; 2]>, TaskError> {
        let Some(start) = self.events.windows.start() else { return Ok(None) };
        Ok(Some([start, self.events.windows.end()?]))
    }

    /// Times of the schedule so far.
    pub fn strides(&self) -> u64 {
        self.strides
    }

    /// Events so far.
    pub fn events(&self) -> u64 {
        self.events.count
    }

    /// The events that are left after reading and after each step before the network.
    pub fn remaining_events(&self) -> Vec<RemainingEvents> {
        let read = RemainingEvents {
            step: "of the recording".to_owned(),
            events: self.events.count,
            edge_share: 1.0,
            advice: "record for longer, or something that moves more, nearer, or in more light",
        };
        std::iter::once(read).chain(self.stream.frontend.remaining_events()).collect()
    }

    /// The stream, at the last time it was advanced to.
    pub fn stream(&mut self) -> &mut PoseStream<F, W> {
        &mut self.stream
    }

    /// Pushes the events up to and including `t`, which is not before the last one, silences included.
    ///
    /// # Errors
    /// If the recording cannot be read up to there.
    pub fn advance(&mut self, t: Micros) -> Result<(), TaskError> {
        while self.push_until(t)? {
            self.newest = None;
        }
        Ok(())
    }

    /// The time from `t` on, not before the last one, at which there is no silence of more than
    /// [`MAX_SILENCE`].
    ///
    /// # Errors
    /// If the recording cannot be read up to there.
    pub fn skip_silence(&mut self, t: Micros) -> Result<Micros, TaskError> {
        self.advance(t)?;
        Ok(self.events.peek()?.filter(|next| self.is_behind_silence(*next)).unwrap_or(t))
    }

    /// Takes the input at `t`, which is not before the last one.
    ///
    /// # Errors
    /// If the recording cannot be read up to there, or the network fails.
    pub fn infer_at(&mut self, t: Micros) -> Result<InferredPoses<F::Pose>, TaskError> {
        self.advance(t)?;
        self.infer(t)
    }

    /// Pushes the events up to and including `t`; returns whether a silence parts some of them.
    fn push_until(&mut self, t: Micros) -> Result<bool, TaskError> {
        while let Some(next) = self.events.peek()?.filter(|next| *next <= t) {
            if self.is_behind_silence(next) {
                return Ok(true);
            }
            let events = self.events.take_until(t);
            self.newest = events.t().last().copied();
            self.stream.frontend.push(events)?;
        }
        Ok(false)
    }

    /// Whether a silence lies between the newest event and one at `next`.
    fn is_behind_silence(&self, next: Micros) -> bool {
        self.newest.is_some_and(|newest| next - newest > MAX_SILENCE)
    }

    fn infer(&mut self, t: Micros) -> Result<InferredPoses<F::Pose>, TaskError> {
        let begin = Instant::now();
        self.strides += 1;
        self.stream.frontend.stride(t);
        let poses = self.stream.infer(t)?;
        let skipped = self.stream.frontend.skipped();
        Ok(InferredPoses { t, poses, skipped, delay_s: begin.elapsed().as_secs_f64() })
    }

    /// The poses of the inputs that wait, once no event follows; none if there are none. What comes behind
    /// a silence then begins anew.
    fn finish(&mut self) -> Result<Option<InferredPoses<F::Pose>>, TaskError> {
        self.next_stride = None;
        let Some(t) = self.newest.take() else { return Ok(None) };
        let begin = Instant::now();
        let poses = self.stream.finish(t)?;
        let skipped = self.stream.frontend.skipped();
        let delay_s = begin.elapsed().as_secs_f64();
        let inferred = InferredPoses { t, poses, skipped, delay_s };
        Ok((!inferred.is_empty()).then_some(inferred))
    }

    /// The time of the next event, before which the front end forgets what was before a silence.
    fn begin(&mut self) -> Result<Option<Micros>, TaskError> {
        let Some(next) = self.events.peek()? else { return Ok(None) };
        if self.newest.is_none() && std::mem::replace(&mut self.has_begun, true) {
            self.stream.reset();
        }
        Ok(Some(next))
    }

    fn every(&mut self, step: Micros) -> Result<Option<InferredPoses<F::Pose>>, TaskError> {
        loop {
            let is_first = self.next_stride.is_none();
            let t = match self.next_stride {
                Some(t) => t,
                None => {
                    let Some(next) = self.begin()? else { return Ok(None) };
                    self.stream.frontend.first_stride(next, step)
                }
            };
            self.push_until(t)?;
            let goes_on = self.events.peek()?.is_some_and(|next| !self.is_behind_silence(next));
            let last = self.newest.map_or(t, |newest| self.stream.frontend.last_stride(newest));
            // Events that are over before the first time have one input, at their end.
            let is_short = is_first && !goes_on && t > last;
            if goes_on || t <= last || is_short {
                let t = if is_short { last } else { t };
                self.next_stride = Some(t + step);
                return self.infer(t).map(Some);
            }
            if let Some(rest) = self.finish()? {
                return Ok(Some(rest));
            }
        }
    }

    fn triggered(&mut self) -> Result<Option<InferredPoses<F::Pose>>, TaskError> {
        while let Some(next) = self.begin()? {
            // The events of one time stamp are pushed together, since each may trigger an input; those
            // before the earliest that can, at once.
            let earliest = self.stream.frontend.earliest_trigger().map(|t| t - Micros(1));
            let is_over = self.push_until(next.max(earliest.unwrap_or(next)))?;
            let inferred = match self.newest.filter(|_| !is_over) {
                Some(newest) => Some(self.infer(newest)?),
                None => self.finish()?,
            };
            if let Some(inferred) = inferred.filter(|inferred| !inferred.is_empty()) {
                return Ok(Some(inferred));
            }
        }
        self.finish()
    }
}

impl<F, W> Iterator for RecordingStream<F, W>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    type Item = Result<InferredPoses<F::Pose>, TaskError>;

    fn next(&mut self) -> Option<Self::Item> {
        let inferred = match self.schedule {
            InferenceSchedule::Every(step) => self.every(step),
            InferenceSchedule::Triggered | InferenceSchedule::NewestWhenFree => self.triggered(),
        };
        inferred.transpose()
    }
}

/// The events of a recording, forwards, without time that has none.
pub(crate) struct ForwardEvents {
    pub(crate) windows: Windows,
    chunk: EventStream,
    taken: usize,
    piece: EventStream,
    read_to: Micros,
    count: u64,
}

impl ForwardEvents {
    pub(crate) fn new(windows: Windows) -> Self {
        let [chunk, piece] = [(); 2].map(|()| EventStream::empty(windows.sensor()));
        Self { windows, chunk, taken: 0, piece, read_to: Micros(i64::MIN), count: 0 }
    }

    /// The time of the next event.
    pub(crate) fn peek(&mut self) -> Result<Option<Micros>, IoError> {
        while self.taken == self.chunk.len() {
            if self.windows.is_over_at(self.read_to)? {
                return Ok(None);
            }
            // Some events may be late, so that the chunk begins a little before the first that was read.
            let next = self.windows.next_after(self.read_to);
            let start = Micros(next.0.saturating_sub(CHUNK.0 / 2)).max(self.read_to);
            let end = Micros(start.0.saturating_add(CHUNK.0));
            // At the largest time stamps the sum saturates, and no window contains the event.
            if end <= next {
                return Ok(None);
            }
            self.windows.read(TimeWindow { start, end }, &mut self.chunk)?;
            (self.taken, self.read_to) = (0, end);
        }
        Ok(Some(self.chunk.t()[self.taken]))
    }

    /// The events of the chunk up to and including `t`.
    pub(crate) fn take_until(&mut self, t: Micros) -> &EventStream {
        let from = self.taken;
        self.taken += self.chunk.t()[from..].partition_point(|at| *at <= t);
        self.count += (self.taken - from) as u64;
        // A whole chunk needs no copy.
        if from == 0 && self.taken == self.chunk.len() {
            return &self.chunk;
        }
        let (chunk, range) = (&self.chunk, from..self.taken);
        self.piece.clear();
        // In order and on the sensor, as in the chunk.
        let _ = self.piece.extend_columns(
            &chunk.t()[range.clone()],
            &chunk.x()[range.clone()],
            &chunk.y()[range.clone()],
            &chunk.polarity()[range],
        );
        &self.piece
    }
}
