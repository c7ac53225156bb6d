//! A video, decoded by the program `ffmpeg`.
//!
//! It is decoded twice: for the times of its frames, which a video may state one by one, and for
//! the frames.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use evpose_core::SensorSize;

use crate::IoError;
use crate::frames::fault::sensor_size;
use crate::frames::light::Light;
use crate::frames::{FrameFault, folder};

const PROGRAM: &str = "ffmpeg";

/// The frames of a video that are still to come.
#[derive(Debug)]
pub(in crate::frames) struct Ffmpeg {
    decoder: Child,
    pixels: BufReader<ChildStdout>,
    size: SensorSize,
    times_s: Vec<f64>,
    next: usize,
    /// One frame, 3 bytes a pixel.
    codes: Vec<u8>,
}

impl Ffmpeg {
    pub(super) fn open(path: &Path) -> Result<Self, IoError> {
        let fault = |fault| IoError::frames(path, fault);
        let (size, times_s) = Self::look_through(path).map_err(fault)?;
        // Numbered anew at a constant rate: none is repeated or left out to fill one.
        let mut decoder = ffmpeg(path)
            .args([
                "-vf",
                "setpts=N/(25*TB)",
                "-r",
                "25",
                "-f",
                "rawvideo",
                "-pix_fmt",
                "rgb24",
                "-",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| fault(FrameFault::Undecodable(e.to_string())))?;
        let Some(pixels) = decoder.stdout.take() else {
            return Err(fault(FrameFault::Undecodable("ffmpeg has no output".to_owned())));
        };
        let codes = vec![0; 3 * size.pixels()];
        Ok(Self { decoder, pixels: BufReader::new(pixels), size, times_s, next: 0, codes })
    }

    /// Size, and times of all frames in seconds since the first.
    fn look_through(path: &Path) -> Result<(SensorSize, Vec<f64>), FrameFault> {
        let failed = |why: String| FrameFault::Undecodable(why);
        let mut program = ffmpeg(path)
            .args(["-vf", "showinfo", "-f", "null", "-"])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|e| match e.kind() {
                std::io::ErrorKind::NotFound => FrameFault::NoDecoder,
                _ => FrameFault::Undecodable(e.to_string()),
            })?;
        let (mut size, mut times, mut last) = (None, Vec::new(), String::new());
        if let Some(said) = program.stderr.take() {
            for line in BufReader::new(said).lines() {
                let line = line.map_err(|e| failed(e.to_string()))?;
                if let Some(time) = value(&line, "pts_time:") {
                    times.push(time.parse().map_err(|_| failed(line.clone()))?);
                    size = size.or_else(|| value(&line, " s:").map(str::to_owned));
                } else if !line.contains("Parsed_showinfo") {
                    last = line;
                }
            }
        }
        // The last line of what it says is its reason.
        let has_ended_well = program.wait().is_ok_and(|status| status.success());
        let size = size.filter(|_| has_ended_well).ok_or_else(|| failed(last.clone()))?;
        let sides = size.split_once('x').map(|(w, h)| (w.parse(), h.parse()));
        let Some((Ok(width), Ok(height))) = sides else { return Err(failed(size)) };
        let start = times.first().copied().unwrap_or(0.0);
        let times = times.iter().map(|t: &f64| t - start).collect();
        Ok((sensor_size(width, height)?, times))
    }

    pub(super) fn size(&self) -> SensorSize {
        self.size
    }

    /// Seconds of each frame since the first.
    pub(super) fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    pub(super) fn next_into(&mut self, light: &Light, out: &mut [f32]) -> Result<bool, FrameFault> {
        if self.next == self.times_s.len() {
            return Ok(false);
        }
        self.pixels.read_exact(&mut self.codes).map_err(|e| {
            FrameFault::Undecodable(format!("frame {} of {}: {e}", self.next, self.times_s.len()))
        })?;
        folder::colour::<_, 3>(&self.codes, light, out);
        self.next += 1;
        Ok(true)
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // It may wait for somebody to read on; that it has ended before is no fault.
        let _ = self.decoder.kill();
        let _ = self.decoder.wait();
    }
}

/// The program with its input: the first video stream of a file, and no other address.
fn ffmpeg(path: &Path) -> Command {
    let mut address = std::ffi::OsString::from("file:");
    address.push(path);
    let mut command = Command::new(PROGRAM);
    command.args(["-nostdin", "-hide_banner", "-nostats", "-protocol_whitelist", "file", "-i"]);
    command.arg(address).args(["-map", "0:v:0"]).stdin(Stdio::null());
    command
}

/// The word behind a key in a line of `showinfo`.
fn value<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = line.split_once(key)?;
    rest.split_whitespace().next()
}
