//! How photographs are converted.

use std::path::PathBuf;

use evpose_repr::ErosLike;
use serde::Serialize;

/// Style of the converted images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StillStyle {
    /// Images like those of an EROS.
    ErosLike(ErosLike),
    /// Grey images, the baseline of an ablation of the event-like style.
    Grey,
}

/// In which format images are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CropFormat {
    /// Without loss.
    Png,
    /// As published, with loss.
    Jpeg {
        /// From 1 to 100; OpenCV's default is 95.
        quality: u8,
    },
}

impl CropFormat {
    /// Ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg { .. } => "jpg",
        }
    }
}

/// Options of a conversion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StillOptions {
    /// The file of annotations: a MAT-file of MPII or LSP, or COCO's JSON.
    pub annotations: PathBuf,
    /// The folder of photographs.
    pub images: PathBuf,
    /// The folder to write; only a conversion with the same options may be in there already, and is
    /// gone on with.
    pub output: PathBuf,
    /// Style of the converted images.
    pub style: StillStyle,
    /// In which format.
    pub format: CropFormat,
    /// Seed of all noise.
    pub seed: u64,
    /// For MPII, whether labels are those of the published program, with what is wrong with them:
    ///
    /// * of a photograph on which somebody is annotated in part, nobody is taken;
    /// * a person with a point of unknown visibility is not taken;
    /// * points whose visibility is written as a text are hidden, `1` or not;
    /// * joints outside of a person's image stay labelled, which heads can be.
    pub parity: bool,
}

impl StillOptions {
    /// A conversion as published, without what is wrong with it and without loss.
    pub fn new(
        annotations: impl Into<PathBuf>,
        images: impl Into<PathBuf>,
        output: impl Into<PathBuf>,
    ) -> Self {
        Self {
            annotations: annotations.into(),
            images: images.into(),
            output: output.into(),
            style: StillStyle::ErosLike(ErosLike::default()),
            format: CropFormat::Png,
            seed: 0,
            parity: false,
        }
    }
}
