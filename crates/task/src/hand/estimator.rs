//! The hand's stream without its schedule: representation, batch, stillness gate, filter.

use evpose_core::{EventStream, Micros, SensorSize};
use evpose_pose::HandPose;
use evpose_pose::filter::{HoldAtRest, StillnessGate};
use evpose_repr::{Representation, StreamWindow, representation_by_name};

use evpose_clean::DenoiseFilter;

use super::batch::InputBatch;
use super::config::HandConfig;
use super::detection::{HandDetectionConfig, PresenceGate, WarmUp};
use super::evidence::HandEvidence;
use super::smoothing::Smoothing;
use crate::TaskError;

/// A pose of a hand with what the gate and the filter did to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandEstimate {
    /// Time stamp of its input.
    pub t: Micros,
    /// Time stamp of the last input of its batch: the earliest at which the pose is known.
    pub known: Micros,
    /// The network's output, of this batch or repeated from an earlier one.
    pub measured: HandPose,
    /// After the filter; the output itself where there is none.
    pub filtered: HandPose,
    /// Whether the scene was at rest and an earlier output was repeated.
    pub is_repeated: bool,
    /// Whether the filter took it with its fast settings.
    pub is_fast: bool,
}

/// How often a network of joints saw no hand.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PresenceCounts {
    /// Time of the first window that showed enough; none before.
    pub since: Option<Micros>,
    /// Windows without a hand, from then on.
    pub absent: u64,
    /// The highest smoothed presence; none of networks that do not say.
    pub best: Option<f32>,
}

/// Events to inputs of the network, and its outputs to filtered poses.
///
/// When inputs are taken is the schedule of [`HandFrontend`](super::HandFrontend).
#[derive(Debug)]
pub(super) struct HandEstimator {
    sensor: SensorSize,
    representation: Box<dyn Representation>,
    denoise: Option<DenoiseFilter>,
    /// Memory of the filter, and the events that it left.
    filtered: EventStream,
    filtered_events: u64,
    warm_up: WarmUp,
    gate: Option<StillnessGate<HandPose>>,
    hold: Option<HoldAtRest<HandPose>>,
    evidence: HandEvidence,
    smoothing: Smoothing,
    detection: HandDetectionConfig,
    presence_gate: PresenceGate,
    /// Counts of windows with and without a hand.
    pub(super) presence: PresenceCounts,
    /// Inputs of a full batch, and those so far.
    pub(super) batch: usize,
    pub(super) pending: InputBatch,
    /// Times of inputs since the last stride that have shown too little.
    pub(super) skipped: Vec<Micros>,
}

impl HandEstimator {
    /// The plain pipeline: every input is inferred, in batches of `batch`, and the published Kalman
    /// filter smooths the poses. Otherwise the slow-motion mode: batches of a scene at rest repeat
    /// earlier poses, and the filter has two settings.
    ///
    /// # Errors
    /// If the representation is not known or a setting is out of range.
    pub(super) fn new(
        config: &HandConfig,
        sensor: SensorSize,
        batch: usize,
        is_plain: bool,
    ) -> Result<Self, TaskError> {
        let gate = match is_plain {
            true => None,
            false => Some(StillnessGate::new(&config.slow_motion.stillness, sensor)?),
        };
        let input = &config.representation;
        let window = StreamWindow::new(sensor, input.window(), input.channel_order)?;
        let representation = representation_by_name(&input.name)?.start(window);
        let pending = InputBatch::default();
        let denoise = input.denoise.map(|denoise| denoise.start(sensor));
        let filtered = EventStream::empty(sensor);
        Ok(Self {
            sensor,
            representation,
            denoise,
            filtered,
            filtered_events: 0,
            warm_up: WarmUp::new(config.detection, sensor),
            gate,
            hold: config.hold.map(|hold| HoldAtRest::new(&hold, sensor)).transpose()?,
            evidence: HandEvidence::new(config.simulation.camera(), config.detection.min_evidence),
            smoothing: Smoothing::new(config, !is_plain)?,
            presence: PresenceCounts::default(),
            detection: config.detection,
            presence_gate: PresenceGate::new(config.detection),
            batch: batch.max(1),
            pending,
            skipped: Vec::new(),
        })
    }

    pub(super) fn push(&mut self, events: &EventStream) {
        let Some(denoise) = &mut self.denoise else { return self.representation.push(events) };
        self.filtered.clone_from(events);
        denoise.apply(&mut self.filtered);
        self.filtered_events += self.filtered.len() as u64;
        self.representation.push(&self.filtered);
    }

    /// The events that the filter has left; none without one.
    pub(super) fn events_after_filter(&self) -> Option<u64> {
        self.denoise.as_ref().map(|_| self.filtered_events)
    }

    /// Adds the input at `now` to the batch, with the time stamp `t`.
    pub(super) fn sample(&mut self, now: Micros, t: Micros) {
        self.representation.advance(now);
        self.pending.add(&mut *self.representation, self.sensor, t);
    }

    /// Whether the batch is full.
    pub(super) fn is_full(&self) -> bool {
        self.pending.len() >= self.batch
    }

    /// The poses of the batch if the scene is at rest: those of an earlier batch, once more. The
    /// batch is then empty.
    pub(super) fn repeat_at_rest(&mut self) -> Option<Vec<HandEstimate>> {
        let (gate, pending) = (self.gate.as_mut()?, &self.pending);
        if !gate.is_at_rest(pending.values(), pending.len()) {
            return None;
        }
        let poses = gate.repeat(pending.len()).to_vec();
        // It is taken out while the filter runs, which borrows the estimator as a whole.
        let batch = std::mem::take(&mut self.pending);
        let estimates = self.smooth(batch.times(), &poses, true);
        self.pending = batch;
        self.pending.clear();
        Some(estimates)
    }

    /// Takes the batch, leaving the memory of `next` for the one to come.
    pub(super) fn take(&mut self, mut next: InputBatch) -> InputBatch {
        next.clear();
        std::mem::replace(&mut self.pending, next)
    }

    /// Takes the network's outputs for a batch. There are none before an input has shown enough, and
    /// where there is no hand: see [`HandDetectionConfig`](super::HandDetectionConfig).
    pub(super) fn accept(
        &mut self,
        batch: &InputBatch,
        mut outputs: Vec<HandPose>,
    ) -> Vec<HandEstimate> {
        let pixels = self.sensor.pixels();
        let first = self.warm_up.first(batch.values(), pixels);
        // Before anything has moved, the network predicts its mean pose.
        outputs.drain(..first.min(outputs.len()));
        self.skipped.extend(&batch.times()[..first]);
        if outputs.is_empty() {
            return Vec::new();
        }
        let inputs = batch.values().chunks_exact(2 * pixels).skip(first);
        let times = &batch.times()[first..];
        self.presence.since = self.presence.since.or(times.first().copied());
        let min_score = self.detection.min_score;
        let evidence = &mut self.evidence;
        let mut is_seen = |t: Micros, input: &[f32], pose: &HandPose| {
            pose.mean_score().is_none_or(|score| score >= min_score)
                && evidence.is_enough(t, input, pose)
        };
        let held: Vec<HandPose> = match &mut self.hold {
            None => outputs.clone(),
            Some(hold) => {
                let windows = inputs.zip(&outputs).zip(times);
                windows
                    .map(|((input, pose), t)| hold.pose(input, pose, is_seen(*t, input, pose)))
                    .collect()
            }
        };
        let (mut of_hands, mut poses) = (Vec::new(), Vec::new());
        for (&t, pose) in times.iter().zip(held) {
            let presence = self.presence_gate.update(t, &pose);
            if let Some((presence, _)) = presence {
                let best = self.presence.best.get_or_insert(presence);
                *best = best.max(presence);
            }
            if presence.is_none_or(|(_, is_there)| is_there) {
                of_hands.push(t);
                poses.push(pose);
            } else {
                self.presence.absent += 1;
                self.skipped.push(t);
            }
        }
        let estimates = self.smooth(&of_hands, &poses, false);
        if let Some(gate) = &mut self.gate {
            // The gate repeats outputs of the network, not the poses that were held in their place.
            gate.predicted(outputs);
        }
        estimates
    }

    fn smooth(
        &mut self,
        times: &[Micros],
        poses: &[HandPose],
        is_repeated: bool,
    ) -> Vec<HandEstimate> {
        // All poses of a batch become known with its last input.
        let Some(&known) = times.last() else { return Vec::new() };
        let pairs = times.iter().zip(poses);
        let estimates = pairs.map(|(&t, measured)| {
            let filtered = self.smoothing.update(t, measured);
            let is_fast = self.smoothing.is_fast();
            HandEstimate { t, known, measured: *measured, filtered, is_repeated, is_fast }
        });
        estimates.collect()
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        self.representation.reset();
        if let Some(denoise) = &mut self.denoise {
            denoise.reset();
        }
        self.pending.clear();
        self.warm_up.reset();
        self.presence = PresenceCounts::default();
        self.presence_gate.reset();
        if let Some(gate) = &mut self.gate {
            gate.reset();
        }
        if let Some(hold) = &mut self.hold {
            hold.reset();
        }
        self.evidence.reset();
        self.smoothing.reset();
    }
}
