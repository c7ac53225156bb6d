//! What was tried beside the answer, and what would overturn it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::verdict::{Answer, GapValue, Quantity, Verdict};

/// A candidate that was fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ranked {
    /// The name in the catalogue.
    pub name: String,
    /// What is left of the misfit with it.
    pub misfit: f64,
    /// Standard error of its difference to the best, where that is known.
    #[serde(default)]
    pub error: Option<f64>,
    /// Whether all its numbers were fitted, or only its strength was tried at a few values.
    pub is_fitted: bool,
    /// Its numbers at the best fit.
    #[serde(default)]
    pub parameters: BTreeMap<String, Quantity>,
}

/// How alike what effects do looks: one for pairs that cannot be told apart.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Confusability {
    /// Names of effects, in the order of rows and columns.
    pub names: Vec<String>,
    /// `|cos|` of the angle between what they do to the numbers measured.
    pub cosines: Vec<Vec<f64>>,
}

/// What was done to the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Nothing: the model as given.
    None,
    /// What was named is in it.
    Added,
    /// One of several that were named is out again.
    TakenOut,
    /// Another effect, the nearest one, is there in its place.
    Exchanged,
}

/// The gap of one variant of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ablation {
    /// What was done.
    pub change: Change,
    /// The effect that it was done with; empty where there is none.
    pub effect: String,
    /// The gap that is left.
    pub gap: GapValue,
}

/// Something that the answer rests on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Doubt {
    /// What is assumed.
    pub assumption: String,
    /// What would show that it does not hold.
    pub overturned_by: String,
}

/// The note of an answer that was judged on a second recording.
pub(crate) const SECOND_RECORDING: &str = "held out: a second recording";

impl Doubt {
    fn new(assumption: impl Into<String>, overturned_by: impl Into<String>) -> Self {
        Self { assumption: assumption.into(), overturned_by: overturned_by.into() }
    }

    /// What an answer without a scene rests on.
    fn of_recording_alone() -> Vec<Self> {
        vec![
            Self::new(
                "Nothing in front of the camera has a structure in time finer than the windows \
                 in which times were redrawn.",
                "A lamp or a screen that flickers, or a motion that repeats, does: look at the same \
                 scene in daylight. What is named is what the recording is consistent with.",
            ),
            Self::new(
                "Both halves of the recording see the same camera.",
                "Settings or temperature that change meanwhile: record again and compare.",
            ),
            Self::new(
                "What is not named was either looked for or is listed as untestable.",
                "A recording of a known scene, with `--scene`: most effects need one to show.",
            ),
        ]
    }

    /// What every answer rests on, and what this one does.
    pub fn of(verdict: &Verdict) -> Vec<Self> {
        if verdict.is_bare() {
            return Self::of_recording_alone();
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
                "The numbers that are compared hold all that matters.",
                "They do not: a classifier still tells patches of measured events from simulated \
                 ones. Something is left that no probe looks at.",
            ));
        }
        doubts
    }
}
