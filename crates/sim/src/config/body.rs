//! Configuration of the body model and of the simulated hands.

use std::path::PathBuf;

use evpose_pose::HandSide;
use serde::{Deserialize, Serialize};

/// Model of hand and arm.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandModelConfig {
    /// Source of the model.
    pub source: BodySource,
    /// Texture coordinates of a model file, for skins that are painted for it: a text file with one
    /// `u v` a vertex, v upwards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uvs: Option<PathBuf>,
}

/// Source of the body model.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodySource {
    /// `source = "procedural"`.
    #[default]
    Procedural,
    /// `source = { file = "SMPLH_male.pkl" }`: SMPL+H, of which the right arm is shown, or MANO,
    /// which ends at the wrist and is moved by the procedural arm.
    File(PathBuf),
    /// `source = { makehuman = "DIR" }`: MakeHuman's files as distributed. Of people, it is mixed with
    /// the procedural body by `body_share`; of hands, the right arm is shown.
    #[serde(rename = "makehuman")]
    MakeHuman(PathBuf),
}

/// Source of the motions of people.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionSource {
    /// `motion = "activities"`: those of the program.
    #[default]
    Activities,
    /// `motion = { cmu = "DIR" }`: CMU's motion capture as distributed (ASF and AMC), mixed with the
    /// activities by `motion_share`. Subjects 01 and 02 belong to test sets and are never used.
    Cmu(PathBuf),
}

/// Sides of the hands of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hands {
    /// Right hands, as published.
    #[default]
    Right,
    /// Left hands: right ones mirrored, before backgrounds that are not mirrored.
    Left,
    /// Right hands in sequences of even index, left hands in the others.
    Both,
}

impl Hands {
    /// Side of the hand of sequence `index`.
    pub fn side(self, index: u64) -> HandSide {
        match self {
            Self::Right => HandSide::Right,
            Self::Left => HandSide::Left,
            Self::Both if index.is_multiple_of(2) => HandSide::Right,
            Self::Both => HandSide::Left,
        }
    }
}
