//! Files of the published hand and body models.
//!
//! | file | what it is | joints | vertices |
//! |---|---|---|---|
//! | `MANO_RIGHT.pkl`, `MANO_LEFT.pkl` | a hand that ends at the wrist | 16 | 778 |
//! | `SMPLH_male.pkl`, `SMPLH_female.pkl` | a whole body with both hands | 52 | 6,890 |
//!
//! Both are read as distributed (pickles of Python 2) and as `.npz` archives of the same arrays,
//! recognised by content. Nothing in a pickle is executed. Licences forbid to pass these files on:
//! users obtain them from <https://mano.is.tue.mpg.de>.
//!
//! # Source
//! Romero, Tzionas, Black: *Embodied Hands* (SIGGRAPH Asia 2017); vertices at the finger tips of
//! the hand from `vertex_ids.py` of the Python package `smplx`, of the body from EventHands.

mod build;
mod describe;
mod error;
mod fields;
#[cfg(feature = "gltf")]
mod glb;
mod npz;
mod skin;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use evpose_pose::HandSide;
use zip::ZipArchive;

pub use error::{FieldFault, ModelFileError};
use fields::Fields;

use crate::BodyModel;

/// Largest size of a file that is read. The published ones have up to 0.3 GB.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Kind of the model in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelKind {
    /// MANO: one hand.
    Hand(HandSide),
    /// A hand of another maker, with the joints of WebXR.
    Jointed(HandSide),
    /// SMPL+H: a body with both hands.
    Body,
}

impl ModelKind {
    /// The hand that is estimated.
    pub fn side(self) -> HandSide {
        match self {
            Self::Hand(side) | Self::Jointed(side) => side,
            Self::Body => HandSide::Right,
        }
    }
}

/// A model with the metadata of its file.
#[derive(Debug, Clone)]
pub struct ModelFile {
    /// Kind of the model.
    pub kind: ModelKind,
    /// Name of the file format.
    pub format: &'static str,
    /// The model. Of a hand, its wrist is joint 0 and `right_hand` is that hand, whichever it is.
    pub model: BodyModel,
    /// Rows of the hand's articulation basis that the file has; those beyond are zero.
    pub hand_components: usize,
    /// Optional arrays that the file does not have, with their purposes, and corrections.
    pub missing: Vec<&'static str>,
}

impl ModelFile {
    /// Reads a model file of either format.
    ///
    /// # Errors
    /// [`ModelFileError`], with the field and its defect.
    pub fn read(path: &Path) -> Result<Self, ModelFileError> {
        let io = |source| ModelFileError::File { path: path.to_owned(), source };
        let bytes = std::fs::metadata(path).map_err(io)?.len();
        if bytes > MAX_FILE_BYTES {
            let (path, max) = (path.to_owned(), MAX_FILE_BYTES);
            return Err(ModelFileError::TooLong { path, bytes, max });
        }
        Self::from_bytes(path, std::fs::read(path).map_err(io)?)
    }

    /// Reads a model file that is in memory; `path` is for messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, ModelFileError> {
        #[cfg(feature = "gltf")]
        if glb::is_glb(&bytes) {
            return glb::model(path, &bytes);
        }
        build::model(Fields::open(path, bytes)?)
    }

    /// Whether a file is a pickle, or an archive that has a template of vertices: no recording is.
    pub fn is_likely(path: &Path) -> bool {
        let Ok(file) = File::open(path) else { return false };
        let mut file = BufReader::new(file);
        let Ok(head) = file.fill_buf() else { return false };
        match head {
            // A dictionary in protocol 0 and 1, any value in later ones.
            [b'(', b'd', ..] | [b'}', b'q', ..] | [0x80, 2..=5, ..] => true,
            [b'g', b'l', b'T', b'F', ..] => cfg!(feature = "gltf"),
            [b'P', b'K', ..] => {
                let archive = ZipArchive::new(file).ok();
                archive.is_some_and(|zip| zip.index_for_name("v_template.npy").is_some())
            }
            _ => false,
        }
    }
}
