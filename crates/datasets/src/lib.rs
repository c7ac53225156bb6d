//! Data sets as they are distributed, and recordings with labels of the user's own, as training data.
//!
//! * [`Annotation`]: an image and the person on it, as one line of JSON for a whole set.
//! * [`LabelledRecording`]: events of a camera with the joints of the person, of any data set;
//!   [`write_eros_frames`] makes images and annotations of it, [`FrameSet`] of many.
//! * [`check`]: checks for labels that are wrong or suspicious.
//! * [`dhp19`]: movements recorded by four event cameras.
//! * [`h36m`]: clips of videos that were turned into events.
//! * [`mpii`], [`lsp`], [`coco`]: photographs of persons; [`stills`] renders them in the style of
//!   event images.
//! * [`import`]: recordings and labels of the user's own, of bodies and hands.
//!
//! ```
//! use evpose_core::SensorSize;
//! use evpose_datasets::{Annotation, TorsoRule, body_label, read_annotations, write_annotations};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("poses.json");
//! // Joints in pixels of an event camera, here of four images of two recordings without any label.
//! let label = body_label(&[None; 13], SensorSize::DAVIS240C, TorsoRule::default());
//! let images = ["walk_0.png", "walk_1.png", "jump_0.png", "jump_1.png"];
//! let annotation = |image: &str| Annotation {
//!     image: image.to_owned(),
//!     t_s: None,
//!     label: label.clone(),
//! };
//! write_annotations(&path, &images.map(annotation))?;
//!
//! let sequences: Vec<_> = read_annotations(&path)?.iter().map(|a| a.sequence().to_owned()).collect();
//! assert_eq!(sequences, ["walk", "walk", "jump", "jump"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod annotation;
pub mod check;
pub mod coco;
pub mod dhp19;
mod error;
pub mod h36m;
pub mod import;
pub mod lsp;
pub mod mpii;
mod open;
mod recording;
mod runs;
pub mod stills;

pub use annotation::{Annotation, read_annotations, write_annotations};
pub use error::DatasetError;
pub use recording::{
    ErosFrameOptions, ErosStyle, FrameSet, LabelledRecording, TimedBody, TorsoRule, body_label,
    write_eros_frames,
};
