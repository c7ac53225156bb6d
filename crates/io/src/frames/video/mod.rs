//! A video: GIF and Y4M are read here, all others by the program `ffmpeg`.

mod ffmpeg;
mod gif;
mod y4m;

use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _};
use std::path::Path;

use evpose_core::SensorSize;

use super::FrameFault;
use super::light::Light;
use crate::IoError;
use ffmpeg::Ffmpeg;
use gif::Gif;
use y4m::Y4m;

/// Endings of files that are taken for videos.
const ENDINGS: [&str; 12] =
    ["mp4", "m4v", "mov", "mkv", "webm", "avi", "mpg", "mpeg", "gif", "y4m", "mjpeg", "ts"];

/// The frames of a video that are still to come.
#[derive(Debug)]
pub(super) enum Video {
    Gif(Gif),
    Y4m(Y4m),
    Program(Ffmpeg),
}

/// Whether a file is taken for a video, by its ending.
pub(super) fn is_video(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known))
}

impl Video {
    pub(super) fn open(path: &Path) -> Result<Self, IoError> {
        let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
        let (mut file, mut head) = (BufReader::new(file), Vec::new());
        let read = file.by_ref().take(y4m::MAGIC.len() as u64).read_to_end(&mut head);
        read.and_then(|_| file.rewind()).map_err(|e| IoError::file(path, "read", e))?;
        let fault = |fault| IoError::frames(path, fault);
        // By content, as recordings are: the name says only that it is a video.
        if head.starts_with(gif::MAGIC) {
            return Gif::open(path).map(Self::Gif).map_err(fault);
        }
        if head == y4m::MAGIC
            && let Some(video) = Y4m::open(file).map_err(fault)?
        {
            return Ok(Self::Y4m(video));
        }
        Ffmpeg::open(path).map(Self::Program)
    }

    pub(super) fn size(&self) -> SensorSize {
        match self {
            Self::Gif(gif) => gif.size(),
            Self::Y4m(y4m) => y4m.size(),
            Self::Program(ffmpeg) => ffmpeg.size(),
        }
    }

    /// Seconds of each frame since the first.
    pub(super) fn times_s(&self) -> &[f64] {
        match self {
            Self::Gif(gif) => gif.times_s(),
            Self::Y4m(y4m) => y4m.times_s(),
            Self::Program(ffmpeg) => ffmpeg.times_s(),
        }
    }

    pub(super) fn next_into(
        &mut self,
        path: &Path,
        light: &Light,
        out: &mut [f32],
    ) -> Result<bool, IoError> {
        let next = match self {
            Self::Gif(gif) => gif.next_into(light, out),
            Self::Y4m(y4m) => y4m.next_into(light, out),
            Self::Program(ffmpeg) => ffmpeg.next_into(light, out),
        };
        next.map_err(|fault| IoError::frames(path, fault))
    }
}

/// A fault of decoding, in words.
fn undecodable(fault: impl std::fmt::Display) -> FrameFault {
    FrameFault::Undecodable(fault.to_string())
}
