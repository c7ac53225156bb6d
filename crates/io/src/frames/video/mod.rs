//! A video: GIF and Y4M are read here, all others by the program `ffmpeg`.

mod ffmpeg;
mod gif;
mod y4m;

use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _};
use std::path::Path;

use evpose_core::SensorSize;

use super::light::Light;
use super::{About, FrameDepth, FrameFault, Frames};
use crate::IoError;

/// Endings of files that are taken for videos.
const ENDINGS: [&str; 12] =
    ["mp4", "m4v", "mov", "mkv", "webm", "avi", "mpg", "mpeg", "gif", "y4m", "mjpeg", "ts"];

/// The frames of a video that are still to come.
struct Video {
    decoder: Box<dyn VideoDecoder>,
    next: usize,
    frames: usize,
}

/// Decodes the frames of a video one after the other.
trait VideoDecoder {
    /// Decodes frame number `frame`, which comes next.
    fn decode(&mut self, frame: usize, light: &Light, out: &mut [f32]) -> Result<(), FrameFault>;
}

/// A decoder, and of the video the size and the seconds of each frame since the first.
type OpenedVideo = (Box<dyn VideoDecoder>, SensorSize, Vec<f64>);

/// Whether a file is taken for a video, by its ending.
pub(super) fn is_video(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known))
}

pub(super) fn open(path: &Path) -> Result<super::Opened, IoError> {
    let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
    let (mut file, mut head) = (BufReader::new(file), Vec::new());
    let read = file.by_ref().take(y4m::MAGIC.len() as u64).read_to_end(&mut head);
    read.and_then(|_| file.rewind()).map_err(|e| IoError::file(path, "read", e))?;
    let fault = |fault| IoError::frames(path, fault);
    // By content, as recordings are: the name says only that it is a video.
    let own = if head.starts_with(gif::MAGIC) {
        Some(gif::open(path).map_err(fault)?)
    } else if head == y4m::MAGIC {
        y4m::open(file).map_err(fault)?
    } else {
        None
    };
    let (decoder, size, times_s) = own.map_or_else(|| ffmpeg::open(path), Ok).map_err(fault)?;
    let frames = times_s.len();
    let about = About::new(size, FrameDepth::Eight, frames as u64);
    let about = About { times_s: Some(times_s), ..about };
    Ok((Box::new(Video { decoder, next: 0, frames }), about))
}

impl Frames for Video {
    fn next_into(&mut self, path: &Path, light: &Light, out: &mut [f32]) -> Result<bool, IoError> {
        if self.next == self.frames {
            return Ok(false);
        }
        let decoded = self.decoder.decode(self.next, light, out);
        decoded.map_err(|fault| IoError::frames(path, fault))?;
        self.next += 1;
        Ok(true)
    }
}

/// A fault of decoding, in words.
fn undecodable(fault: impl std::fmt::Display) -> FrameFault {
    FrameFault::Undecodable(fault.to_string())
}
