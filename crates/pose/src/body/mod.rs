//! Bodies: the maps that a network tells of one, and its joints as read off them.
//!
//! * [`BodyMaps`]: heatmaps, centres, regressions and offsets.
//! * [`BodyDecoder`]: from maps to [`BodyJoint`]s.
//! * [`positions`], [`positions_and_scores`]: joints as rows of plain numbers.

mod decoder;
mod joint;
mod maps;

pub use decoder::{BodyDecoder, DEFAULT_THRESHOLD};
pub use joint::{BodyJoint, positions, positions_and_scores};
pub use maps::BodyMaps;
