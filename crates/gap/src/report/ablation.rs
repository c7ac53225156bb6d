//! Alternatives to the answer: confusable effects, ablation, and assumptions.

use serde::{Deserialize, Serialize};

use crate::verdict::{Answer, GapValue, Verdict};

/// Similarity of the directions of effects; one for indistinguishable pairs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Confusability {
    /// Names of effects, in the order of rows and columns.
    pub names: Vec<String>,
    /// `|cos|` of the angle between the changes of the summary that they cause.
    pub cosines: Vec<Vec<f64>>,
}

/// Change of the model in an ablation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelChange {
    /// None: the model as given.
    None,
    /// All identified effects are added.
    Added,
    /// One identified effect is dropped.
    Dropped,
    /// One identified effect is swapped for its nearest rival.
    Swapped,
}

/// Gap of one variant of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ablation {
    /// Kind of the change.
    pub change: ModelChange,
    /// Effect that was added, dropped, or swapped in; empty if there is none.
    pub effect: String,
    /// Gap of the variant.
    pub gap: GapValue,
}

/// An assumption of the answer, with an observation that would overturn it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Doubt {
    /// Assumption as a sentence.
    pub assumption: String,
    /// Observation that would show that it does not hold.
    pub overturned_by: String,
}

/// Note of a verdict whose held-out data is a second recording.
pub(crate) const SECOND_RECORDING: &str = "held out: a second recording";

/// Beginning of a note of a verdict on a correction of its input.
pub const CORRECTED_NOTE: &str = "corrected: ";

impl Doubt {
    fn new(assumption: impl Into<String>, overturned_by: impl Into<String>) -> Self {
        Self { assumption: assumption.into(), overturned_by: overturned_by.into() }
    }

    /// Assumptions of a verdict without a scene.
    fn for_recording_alone() -> Vec<Self> {
        vec![
            Self::new(
                "Nothing in front of the camera has a structure in time finer than the windows \
                 in which times were redrawn.",
                "A lamp or a screen that flickers, or a motion that repeats, does: record the same scene \
                 in daylight. The listed effects are those that the recording is consistent with.",
            ),
            Self::new(
                "Both halves of the recording see the same camera.",
                "Settings or temperature that change meanwhile: record again and compare.",
            ),
            Self::new(
                "Other effects were either tested or are listed as untestable.",
                "A recording of a known scene, with `--scene`: most effects need one to show.",
            ),
        ]
    }

    /// Assumptions of a verdict.
    pub fn for_verdict(verdict: &Verdict) -> Vec<Self> {
        if verdict.is_scene_free() {
            return Self::for_recording_alone();
        }
        let mut doubts = vec![
            Self::new(
                "The luminance of the scene is what the camera saw: linear, in focus, complete.",
                "A photodiode beside the camera, or frames taken with another exposure. A gamma \
                 that was not undone looks like other thresholds and like lost events in the dark.",
            ),
            Self::new(
                "Recording and scene share one clock.",
                "A light that is switched in view of the camera. Without one, a constant delay of \
                 all pixels and an offset of the clock are the same thing.",
            ),
        ];
        if !verdict.notes.iter().any(|note| note == SECOND_RECORDING) {
            doubts.push(Self::new(
                "What was held out is of the same recording: it shares its pixels and its light.",
                "A second recording of another scene. The corrected model should do as well there.",
            ));
        }
        for finding in &verdict.effects {
            let name = &finding.name;
            if finding.confusable_with.is_empty() {
                doubts.push(Self::new(
                    format!("Nothing that is not in the catalogue does what {name} does."),
                    "A measurement of that property by itself, by the camera's own bias settings \
                     or in a stimulus made for it.",
                ));
            } else {
                doubts.push(Self::new(
                    format!(
                        "{name} rather than {}: here they do nearly the same.",
                        finding.confusable_with.join(" or ")
                    ),
                    "A recording with other speeds, brightness or texture, where they differ.",
                ));
            }
        }
        if verdict.verdict == Answer::NoGap {
            doubts.push(Self::new(
                "An effect that is there would have shown.",
                "A scene that exercises more: the table of limits says what would not have shown.",
            ));
        }
        if verdict.c2st_after.is_some_and(|after| after.p < 0.05) {
            doubts.push(Self::new(
                "The compared statistics hold all that matters.",
                "They do not: a classifier still separates patches of measured events from \
                 simulated ones. Something is left that no probe measures.",
            ));
        }
        doubts
    }
}
