//! The light of an image sequence, one frame at a time.
//!
//! A folder of `.png` images, in the natural order of their names (2 before 10), or of `.jpg`
//! images if it has none of those, an `.npy` array of shape `(frames, height, width)`, a video:
//! GIF and Y4M, and any other if the program `ffmpeg` is there, or the images of a recording of ROS.
//!
//! | source | values | white, unless given |
//! |---|---|---|
//! | 8-bit images, `u1`, videos | codes | 255 |
//! | 16-bit images, `u2` | codes | 65535 |
//! | `f2`, `f4`, `f8` | floats | 1; of values above 2, 255 or the largest of them |
//!
//! Frames come as luminance relative to white: `value / white`, through the curve of sRGB where
//! the encoding is sRGB. Colours become `0.2126 R + 0.7152 G + 0.0722 B` behind the curve. Alpha
//! is ignored. One frame is in memory at a time.
//!
//! # Source
//! IEC 61966-2-1:1999 for the curve, ITU-R BT.709 for the weights.

mod bag;
mod fault;
mod folder;
mod light;
mod natural;
mod npy;
mod video;

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use evpose_core::{Micros, Plane, SensorSize};

use crate::{IoError, OpenOptions};
use light::Light;
use npy::NpyFrames;

pub use fault::{FrameDepth, FrameFault};
pub use npy::write_codes;

/// Values above this are no shares of white, which highlights surpass a little at most.
const BRIGHTEST_SHARE: f64 = 2.0;
/// White of values that are those of 8 bits, whatever type they are stored in: the commonest mistake of all.
const WHITE_OF_BYTES: f64 = 255.0;

/// Transfer curve from values to light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Values proportional to luminance.
    Linear,
    /// The curve of sRGB.
    Srgb,
}

/// A sequence of frames, read one at a time.
pub struct FrameSource {
    path: PathBuf,
    frames: Box<dyn Frames>,
    about: About,
    encoding: Encoding,
    light: Light,
}

/// The frames of a source that are still to come.
trait Frames {
    /// Reads the next frame of the source `path`; false, and nothing read, behind the last.
    fn next_into(&mut self, path: &Path, light: &Light, out: &mut [f32]) -> Result<bool, IoError>;
}

/// Properties of all frames, by the first of them and the headers of a source.
#[derive(Debug)]
struct About {
    size: SensorSize,
    depth: FrameDepth,
    /// Count of frames, read or not.
    frames: u64,
    /// Seconds of each frame since the first, where the source states them.
    times_s: Option<Vec<f64>>,
    /// Time of the first frame on the clock of the events, where there are any.
    start: Option<Micros>,
    /// Remark on what was left out.
    note: Option<String>,
}

/// The frames of a source, and what is known of all of them.
type Opened = (Box<dyn Frames>, About);

impl About {
    fn new(size: SensorSize, depth: FrameDepth, frames: u64) -> Self {
        Self { size, depth, frames, times_s: None, start: None, note: None }
    }
}

impl FrameSource {
    /// Opens a folder, an array, a video or a recording of ROS. Without `white`, the largest code or 1 is white; floating-point
    /// values above 2 are no shares of white, and 255 is, or the largest of them.
    ///
    /// # Errors
    /// If there are no frames, the first cannot be read, an array is not as long as it says, or there
    /// is no `ffmpeg` for a video that takes it.
    pub fn open(
        path: impl AsRef<Path>,
        encoding: Encoding,
        white: Option<f64>,
    ) -> Result<Self, IoError> {
        Self::open_as(path, encoding, white, &OpenOptions::default())
    }

    /// As [`Self::open`], with the options of the recording that holds the frames: its topic, and whether what
    /// is intact of it is enough.
    ///
    /// # Errors
    /// As [`Self::open`], and if no topic of images, or several, are beside that of the events.
    pub fn open_as(
        path: impl AsRef<Path>,
        encoding: Encoding,
        white: Option<f64>,
        options: &OpenOptions,
    ) -> Result<Self, IoError> {
        let path = path.as_ref();
        // Written as what is allowed, so that NaN is refused.
        if white.is_some_and(|white| !(white > 0.0 && white.is_finite())) {
            return Err(IoError::frames(path, FrameFault::White));
        }
        let (mut white, mut brightest) = (white, None);
        let (frames, mut about) = if bag::is_bag(path) {
            bag::open(path, options)?
        } else if path.is_dir() {
            folder::open(path)?
        } else if video::is_video(path) {
            video::open(path)?
        } else {
            let (mut npy, about) = NpyFrames::open(path)?;
            if about.depth == FrameDepth::Float && white.is_none() {
                brightest = Some(npy.brightest(path, &about)?);
            }
            (Box::new(npy) as Box<dyn Frames>, about)
        };
        if let Some(brightest) = brightest.filter(|brightest| *brightest > BRIGHTEST_SHARE) {
            let level = brightest.max(WHITE_OF_BYTES);
            white = Some(level);
            about.note = Some(format!(
                "{}: the brightest light is {brightest:.1} and `white` is not stated: it is taken to be \
                 {level}",
                path.display()
            ));
        }
        // The level of white depends on the depth, known from the first frame alone.
        let light = Light::new(about.depth, encoding, white);
        Ok(Self { path: path.to_owned(), frames, about, encoding, light })
    }

    /// Remark on the values, or on what was left out, for the user.
    pub fn note(&self) -> Option<&str> {
        self.about.note.as_deref()
    }

    /// The folder or file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The size of every frame.
    pub fn size(&self) -> SensorSize {
        self.about.size
    }

    /// Count of frames, read or not.
    pub fn frames(&self) -> u64 {
        self.about.frames
    }

    /// Seconds of each frame since the first, where the source states them.
    pub fn times_s(&self) -> Option<&[f64]> {
        self.about.times_s.as_deref()
    }

    /// Time of the first frame on the clock of the events that were recorded with it, if any were.
    pub fn start(&self) -> Option<Micros> {
        self.about.start
    }

    /// Type of the values.
    pub fn depth(&self) -> FrameDepth {
        self.about.depth
    }

    /// Transfer curve of the values.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// The value of white.
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
        self.frames.next_into(&self.path, &self.light, frame.data_mut())
    }
}

impl fmt::Debug for FrameSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut source = f.debug_struct("FrameSource");
        source.field("path", &self.path).field("about", &self.about).finish_non_exhaustive()
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

#[cfg(test)]
mod tests;
