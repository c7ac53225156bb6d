//! The parts of a data set: for training, for validation, and for the noise of filters.

use std::ops::Range;
use std::sync::Arc;

use evpose_core::Micros;
use evpose_pose::stream::InferenceSchedule;
use evpose_task::hand::{HandConfig, Predictor};

use super::{HandDataset, HandSequence};
use crate::TrainError;
use crate::hand::evaluation::frame_before;
use crate::hand::filter_noise::MeasuredTrack;

/// Frames of a sequence that filters are estimated from, at most.
const FILTER_FRAMES: u64 = 2000;
/// Sequences that filters are estimated from: one of twenty, at most twelve.
const FILTER_SHARE: usize = 20;
const FILTER_SEQUENCES: usize = 12;

/// The parts that a data set is split into for a training.
#[derive(Debug, Clone)]
pub(crate) struct HandSplit {
    /// The network is trained on.
    pub train: HandDataset,
    /// The best network is chosen by.
    pub valid: HandDataset,
    /// Noise of filters is estimated from.
    pub filter: HandDataset,
}

impl HandDataset {
    /// Splits off the first `training.validation_s` seconds of every sequence. Validation begins
    /// with the first full window, so that all of its windows are alike. If filters are estimated,
    /// some sequences are left out of the training as a whole: lag shows on long motions only, and
    /// residuals are smaller where a network was trained.
    ///
    /// # Errors
    /// If one of the parts would be empty.
    pub(crate) fn split(self, config: &HandConfig) -> Result<HandSplit, TrainError> {
        // Labels are one a millisecond.
        let validation_ms = (config.training.validation_s * 1e3).round() as u64;
        let cut = |s: &HandSequence| validation_ms.min(s.frames);
        let first = u64::from(self.window_frames) - 1;
        let all = self.sequences.len();
        // With a single sequence there is none to spare.
        let is_whole = config.training.estimate_filter && all > 1;
        let whole = if is_whole { (all / FILTER_SHARE).clamp(1, FILTER_SEQUENCES) } else { 0 };
        let part = |make: &dyn Fn(bool, &HandSequence) -> Range<u64>| {
            let of = |(i, s): (usize, &HandSequence)| make(i >= all - whole, s);
            let parts = self.sequences.iter().enumerate().map(of).collect();
            Self::from_parts(Arc::clone(&self.sequences), parts, config, self.sensor)
        };
        Ok(HandSplit {
            train: part(&|is_whole, s| if is_whole { 0..0 } else { cut(s)..s.frames })?,
            valid: part(&|_, s| first.min(cut(s))..cut(s))?,
            filter: part(&|is_whole, s| {
                let end = if is_whole { s.frames } else { cut(s) };
                // Without whole sequences, the part for validation has to do.
                if is_whole || whole == 0 { first.min(end)..end } else { 0..0 }
            })?,
        })
    }

    /// Measured and true poses of the parts, a pose for each frame: those that the stream's filter takes.
    pub(crate) fn measured_tracks(
        &self,
        config: &HandConfig,
        predictor: &mut dyn Predictor,
    ) -> Result<Vec<MeasuredTrack>, TrainError> {
        let every_ms = InferenceSchedule::Every(Micros(1_000));
        let mut tracks = Vec::new();
        for (sequence, part) in self.sequences.iter().zip(&self.parts) {
            let part = part.start..part.end.min(part.start + FILTER_FRAMES);
            if part.is_empty() {
                continue;
            }
            let (mut frames, mut measured) = (Vec::new(), Vec::new());
            for inferred in sequence.stream(config, &mut *predictor, every_ms)? {
                let inferred = inferred?;
                for (t, estimate) in inferred.poses {
                    let frame = frame_before(t);
                    if part.contains(&frame) {
                        frames.push(frame);
                        measured.push(estimate.measured.params);
                    }
                }
                // Nothing after the part is needed, and inference is what takes the time here.
                if frame_before(inferred.t) >= part.end {
                    break;
                }
            }
            if frames.is_empty() {
                continue;
            }
            let truth = frames.iter().map(|&frame| sequence.pose(frame));
            let truth = truth.collect::<Result<_, TrainError>>()?;
            tracks.push(MeasuredTrack { frames, measured, truth });
        }
        Ok(tracks)
    }
}
