//! Whose hand is simulated, as written down.

use std::path::PathBuf;

use evpose_pose::HandSide;
use serde::{Deserialize, Serialize};

/// The model of hand and arm.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyConfig {
    /// Where it comes from.
    pub source: BodySource,
    /// Texture coordinates of a model file, for skins that are painted for it: a text file with one
    /// `u v` a vertex, v upwards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uvs: Option<PathBuf>,
}

/// A model made in code, or a file of the user's.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodySource {
    /// `source = "procedural"`.
    #[default]
    Procedural,
    /// `source = { file = "SMPLH_male.pkl" }`: SMPL+H, of which the right arm is shown, or MANO, which
    /// ends at the wrist and is moved by the procedural arm.
    File(PathBuf),
}

/// Which hands a run has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hands {
    /// Right ones, as published.
    #[default]
    Right,
    /// Left ones: the same seen in a mirror, before backgrounds that are not mirrored.
    Left,
    /// Right ones in sequences of even number, left ones in the others.
    Both,
}

impl Hands {
    /// The hand of sequence number `index`.
    pub fn side(self, index: u64) -> HandSide {
        match self {
            Self::Right => HandSide::Right,
            Self::Left => HandSide::Left,
            Self::Both if index.is_multiple_of(2) => HandSide::Right,
            Self::Both => HandSide::Left,
        }
    }
}
