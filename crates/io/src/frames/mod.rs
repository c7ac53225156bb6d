//! The light of an image sequence, one frame at a time.
//!
//! A folder of `.png` images, in the natural order of their names (2 before 10), or of `.jpg` images if it
//! has none of those, or an `.npy` array of shape `(frames, height, width)`:
//!
//! | source | values | white, unless given |
//! |---|---|---|
//! | 8-bit images, `u1` | codes | 255 |
//! | 16-bit images, `u2` | codes | 65535 |
//! | `f2`, `f4`, `f8` | numbers | 1 |
//!
//! Frames come as luminance relative to white: `value / white`, through the curve of sRGB where
//! the encoding is sRGB. Colours become `0.2126 R + 0.7152 G + 0.0722 B` behind the curve. Alpha
//! is ignored. One frame is in memory at a time.
//!
//! # Source
//! IEC 61966-2-1:1999 for the curve, ITU-R BT.709 for the weights.

mod folder;
mod light;
mod natural;
mod npy;

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use evpose_core::{Plane, SensorSize};

use crate::IoError;
use folder::Folder;
use light::Light;
use npy::NpyFrames;

pub use npy::write_codes;

/// How values stand for light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// In proportion.
    Linear,
    /// As on a display.
    Srgb,
}

/// Frames in order.
#[derive(Debug)]
pub struct FrameSource {
    path: PathBuf,
    kind: Kind,
    encoding: Encoding,
    light: Light,
}

#[derive(Debug)]
enum Kind {
    Folder(Folder),
    Npy(NpyFrames),
}

/// What the numbers of a source are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// Codes of 8 bits.
    Eight,
    /// Codes of 16 bits.
    Sixteen,
    /// Floating-point numbers.
    Float,
}

/// Why there are no frames to be had.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameFault {
    /// A folder without images.
    NoImages,
    /// An image that cannot be decoded.
    Undecodable(String),
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
        /// Whole frames that are there.
        whole: u64,
        /// Frames of the shape.
        of: u64,
        /// Where in the file the first that is not whole begins.
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
        got: Depth,
        /// That of the first.
        first: Depth,
    },
    /// A level of white that is not a positive number.
    White,
}

impl FrameSource {
    /// Opens a folder or an array. Without `white`, the largest code or 1 is white.
    ///
    /// # Errors
    /// If there are no frames, the first cannot be read, or an array is not as long as it says.
    pub fn open(
        path: impl AsRef<Path>,
        encoding: Encoding,
        white: Option<f64>,
    ) -> Result<Self, IoError> {
        let path = path.as_ref();
        if white.is_some_and(|white| !(white > 0.0 && white.is_finite())) {
            return Err(IoError::frames(path, FrameFault::White));
        }
        let kind = if path.is_dir() {
            Kind::Folder(Folder::open(path)?)
        } else {
            Kind::Npy(NpyFrames::open(path)?)
        };
        let depth = match &kind {
            Kind::Folder(folder) => folder.depth(),
            Kind::Npy(npy) => npy.depth(),
        };
        let light = Light::new(depth, encoding, white);
        Ok(Self { path: path.to_owned(), kind, encoding, light })
    }

    /// The folder or file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The size of every frame.
    pub fn size(&self) -> SensorSize {
        match &self.kind {
            Kind::Folder(folder) => folder.size(),
            Kind::Npy(npy) => npy.size(),
        }
    }

    /// The number of frames, read or not.
    pub fn frames(&self) -> u64 {
        match &self.kind {
            Kind::Folder(folder) => folder.frames(),
            Kind::Npy(npy) => npy.frames(),
        }
    }

    /// What the numbers are.
    pub fn depth(&self) -> Depth {
        self.light.depth()
    }

    /// How they stand for light.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// The number that is white.
    pub fn white(&self) -> f64 {
        self.light.white()
    }

    /// Reads the next frame; false, and nothing read, behind the last.
    ///
    /// # Errors
    /// If the frame cannot be read, or is unlike the first.
    pub fn next_into(&mut self, frame: &mut Plane<f32>) -> Result<bool, IoError> {
        let size = self.size();
        if (frame.width(), frame.height()) != (size.width.into(), size.height.into()) {
            *frame = Plane::for_sensor(size, 0.0);
        }
        match &mut self.kind {
            Kind::Folder(folder) => folder.next_into(&self.light, frame.data_mut()),
            Kind::Npy(npy) => npy.next_into(&self.light, frame.data_mut()),
        }
    }
}

/// A size that a sensor can have.
fn sensor_size(width: u64, height: u64) -> Result<SensorSize, FrameFault> {
    match (u16::try_from(width), u16::try_from(height)) {
        (Ok(width), Ok(height)) => Ok(SensorSize { width, height }),
        _ => Err(FrameFault::TooLarge(width, height)),
    }
}

impl Encoding {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Srgb => "srgb",
        }
    }
}

impl FromStr for Encoding {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let known = [Self::Linear, Self::Srgb].into_iter().find(|e| e.name() == name);
        known.ok_or_else(|| "expected `linear` or `srgb`".to_owned())
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for Depth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Eight => "8 bit",
            Self::Sixteen => "16 bit",
            Self::Float => "floating point",
        })
    }
}

impl fmt::Display for FrameFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoImages => f.write_str("no .png image in this folder, and no .jpg either"),
            Self::Undecodable(why) => write!(f, "cannot be decoded: {why}"),
            Self::Pixels(found) => write!(f, "pixels of type {found}, expected 8 or 16 bits"),
            Self::NotAnArray(why) => write!(f, "neither a folder nor an .npy array: {why}"),
            Self::Shape(shape) => {
                write!(f, "an array of shape {shape:?}, expected (frames, height, width)")
            }
            Self::Type(found) => write!(
                f,
                "values of type {found}, expected u1, u2, f2, f4 or f8: save \
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

#[cfg(test)]
mod tests;
