//! Faults of image sequences.

use std::fmt;

use evpose_core::SensorSize;

/// Type of the values of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameDepth {
    /// Codes of 8 bits.
    Eight,
    /// Codes of 16 bits.
    Sixteen,
    /// Floating-point values.
    Float,
}

impl fmt::Display for FrameDepth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Eight => "8 bit",
            Self::Sixteen => "16 bit",
            Self::Float => "floating point",
        })
    }
}

/// A fault of an image sequence.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameFault {
    /// A folder without images.
    #[error("no .png image in this folder, and no .jpg either")]
    NoImages,
    /// Images of two kinds that are not previews of each other.
    #[error("{png} .png and {jpg} .jpg images in one folder: keep frames of one kind in it")]
    Mixed {
        /// Count of .png images.
        png: usize,
        /// Count of .jpg images.
        jpg: usize,
    },
    /// Images of kinds that are not read.
    #[error(
        "images that are not read, {count} in all, such as {first}: save all frames as PNG, or keep others \
         elsewhere"
    )]
    OtherImages {
        /// How many there are.
        count: usize,
        /// The name of the first.
        first: String,
    },
    /// An image or a video that cannot be decoded.
    #[error("cannot be decoded: {0}")]
    Undecodable(String),
    /// A video where there is no `ffmpeg`.
    #[error(
        "a video is decoded by the program ffmpeg, which is not on the path: install it, or write the \
         frames as images elsewhere: ffmpeg -i VIDEO frames/%06d.png"
    )]
    NoDecoder,
    /// An image whose pixels are neither codes of 8 nor of 16 bits.
    #[error("pixels of type {0}, expected 8 or 16 bits")]
    Pixels(String),
    /// A file that is no `.npy` array, with the reason.
    #[error("neither a folder, an .npy array, a video nor a recording of ROS: {0}")]
    NotAnArray(String),
    /// An array of another shape than frames, height, width, or without any of them.
    #[error("an array of shape {0:?}, expected (frames, height, width)")]
    Shape(Vec<u64>),
    /// An array of values that are none of u1, u2, f2, f4, f8.
    #[error("values of type {0}, expected u1, u2, f2, f4 or f8: save frames.astype('float32')")]
    Type(String),
    /// An array stored column by column.
    #[error(
        "stored column by column (fortran_order), expected row by row: save \
         numpy.ascontiguousarray(frames)"
    )]
    Columns,
    /// An array that ends before its shape does.
    #[error("truncated: {whole} of its {of} frames are there, up to byte {byte}")]
    Truncated {
        /// Whole frames of the file.
        whole: u64,
        /// Frames of the shape.
        of: u64,
        /// Byte of the file at which the first incomplete frame begins.
        byte: u64,
    },
    /// An array that goes on behind its shape.
    #[error("{0} bytes more than its shape says")]
    Trailing(u64),
    /// More columns or rows than a sensor can have.
    #[error("{0}x{1} pixels, more than 65535 in a row or column")]
    TooLarge(u64, u64),
    /// A frame that differs in size from the first.
    #[error("{got} pixels, but the first frame has {first}")]
    Size {
        /// Its size.
        got: SensorSize,
        /// That of the first.
        first: SensorSize,
    },
    /// A frame that differs in depth from the first.
    #[error("{got}, but the first frame is {first}")]
    Depth {
        /// Its depth.
        got: FrameDepth,
        /// That of the first.
        first: FrameDepth,
    },
    /// A level of white that is not a positive number.
    #[error("the level of white must be a positive number")]
    White,
}

/// Checks that a size is one that a sensor can have.
pub(super) fn sensor_size(width: u64, height: u64) -> Result<SensorSize, FrameFault> {
    match (u16::try_from(width), u16::try_from(height)) {
        (Ok(width), Ok(height)) => Ok(SensorSize { width, height }),
        _ => Err(FrameFault::TooLarge(width, height)),
    }
}
