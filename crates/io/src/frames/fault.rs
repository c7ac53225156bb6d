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
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameFault {
    /// A folder without images.
    NoImages,
    /// Images of two kinds that are not previews of each other.
    Mixed {
        /// Count of .png images.
        png: usize,
        /// Count of .jpg images.
        jpg: usize,
    },
    /// Images of kinds that are not read.
    OtherImages {
        /// How many there are.
        count: usize,
        /// The name of the first.
        first: String,
    },
    /// An image or a video that cannot be decoded.
    Undecodable(String),
    /// A video where there is no `ffmpeg`.
    NoDecoder,
    /// An image whose pixels are neither codes of 8 nor of 16 bits.
    Pixels(String),
    /// A file that is no `.npy` array, with the reason.
    NotAnArray(String),
    /// An array of another shape than frames, height, width, or without any of them.
    Shape(Vec<u64>),
    /// An array of values that are none of u1, u2, f2, f4, f8.
    Type(String),
    /// An array stored column by column.
    Columns,
    /// An array that ends before its shape does.
    Truncated {
        /// Whole frames of the file.
        whole: u64,
        /// Frames of the shape.
        of: u64,
        /// Byte of the file at which the first incomplete frame begins.
        byte: u64,
    },
    /// An array that goes on behind its shape.
    Trailing(u64),
    /// More columns or rows than a sensor can have.
    TooLarge(u64, u64),
    /// A frame that differs in size from the first.
    Size {
        /// Its size.
        got: SensorSize,
        /// That of the first.
        first: SensorSize,
    },
    /// A frame that differs in depth from the first.
    Depth {
        /// Its depth.
        got: FrameDepth,
        /// That of the first.
        first: FrameDepth,
    },
    /// A level of white that is not a positive number.
    White,
}

impl fmt::Display for FrameFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoImages => f.write_str("no .png image in this folder, and no .jpg either"),
            Self::Mixed { png, jpg } => write!(
                f,
                "{png} .png and {jpg} .jpg images in one folder: keep frames of one kind in it"
            ),
            Self::OtherImages { count, first } => write!(
                f,
                "images that are not read, {count} in all, such as {first}: save all frames as PNG, or keep \
                 others elsewhere"
            ),
            Self::Undecodable(why) => write!(f, "cannot be decoded: {why}"),
            Self::NoDecoder => f.write_str(
                "a video is decoded by the program ffmpeg, which is not on the path: install it, or \
                 write the frames as images elsewhere: ffmpeg -i VIDEO frames/%06d.png",
            ),
            Self::Pixels(actual) => write!(f, "pixels of type {actual}, expected 8 or 16 bits"),
            Self::NotAnArray(why) => write!(f, "neither a folder, an .npy array, a video nor a recording of ROS: {why}"),
            Self::Shape(shape) => {
                write!(f, "an array of shape {shape:?}, expected (frames, height, width)")
            }
            Self::Type(actual) => write!(
                f,
                "values of type {actual}, expected u1, u2, f2, f4 or f8: save \
                 frames.astype('float32')"
            ),
            Self::Columns => f.write_str(
                "stored column by column (fortran_order), expected row by row: save \
                 numpy.ascontiguousarray(frames)",
            ),
            Self::Truncated { whole, of, byte } => {
                write!(f, "truncated: {whole} of its {of} frames are there, up to byte {byte}")
            }
            Self::Trailing(bytes) => write!(f, "{bytes} bytes more than its shape says"),
            Self::TooLarge(width, height) => {
                write!(f, "{width}x{height} pixels, more than 65535 in a row or column")
            }
            Self::Size { got, first } => write!(f, "{got} pixels, but the first frame has {first}"),
            Self::Depth { got, first } => write!(f, "{got}, but the first frame is {first}"),
            Self::White => f.write_str("the level of white must be a positive number"),
        }
    }
}

/// Checks that a size is one that a sensor can have.
pub(super) fn sensor_size(width: u64, height: u64) -> Result<SensorSize, FrameFault> {
    match (u16::try_from(width), u16::try_from(height)) {
        (Ok(width), Ok(height)) => Ok(SensorSize { width, height }),
        _ => Err(FrameFault::TooLarge(width, height)),
    }
}
