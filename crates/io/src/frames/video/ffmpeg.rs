//! A video, decoded by the program `ffmpeg`.
//!
//! It is decoded twice: for the times of its frames, which a video may state one by one, and for
//! the frames.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use evpose_core::SensorSize;

use super::{OpenedVideo, VideoDecoder, undecodable};
use crate::frames::fault::sensor_size;
use crate::frames::light::Light;
use crate::frames::{FrameFault, folder};

const PROGRAM: &str = "ffmpeg";

/// The frames of a video that are still to come.
struct Ffmpeg {
    decoder: Child,
    pixels: BufReader<ChildStdout>,
    frames: usize,
    /// One frame, 3 bytes a pixel.
    codes: Vec<u8>,
}

pub(super) fn open(path: &Path) -> Result<OpenedVideo, FrameFault> {
    let (size, times_s) = look_through(path)?;
    // Numbered anew at a constant rate: none is repeated or left out to fill one.
    let mut decoder = ffmpeg(path)
        .args(["-vf", "setpts=N/(25*TB)", "-r", "25", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(undecodable)?;
    let pixels = decoder.stdout.take().ok_or_else(|| undecodable("ffmpeg has no output"))?;
    let (pixels, frames) = (BufReader::new(pixels), times_s.len());
    let video = Ffmpeg { decoder, pixels, frames, codes: vec![0; 3 * size.pixels()] };
    Ok((Box::new(video), size, times_s))
}

/// Size, and times of all frames in seconds since the first.
fn look_through(path: &Path) -> Result<(SensorSize, Vec<f64>), FrameFault> {
    let mut program = ffmpeg(path)
        // The filter writes a line for each frame to standard error, and frames go nowhere.
        .args(["-vf", "showinfo", "-f", "null", "-"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => FrameFault::NoDecoder,
            _ => undecodable(e),
        })?;
    let (mut size, mut times, mut last) = (None, Vec::new(), String::new());
    // The output is read to its end before the wait: a full pipe would hold ffmpeg up forever.
    if let Some(said) = program.stderr.take() {
        for line in BufReader::new(said).lines() {
            let line = line.map_err(undecodable)?;
            if let Some(time) = value(&line, "pts_time:") {
                times.push(time.parse().map_err(|_| undecodable(&line))?);
                size = size.or_else(|| value(&line, " s:").map(str::to_owned));
            } else if !line.contains("Parsed_showinfo") {
                last = line;
            }
        }
    }
    // The last line of what it says is its reason.
    let has_ended_well = program.wait().is_ok_and(|status| status.success());
    let size = size.filter(|_| has_ended_well).ok_or_else(|| undecodable(&last))?;
    let sides = size.split_once('x').map(|(w, h)| (w.parse(), h.parse()));
    let Some((Ok(width), Ok(height))) = sides else { return Err(undecodable(size)) };
    let start = times.first().copied().unwrap_or(0.0);
    let times = times.iter().map(|t: &f64| t - start).collect();
    Ok((sensor_size(width, height)?, times))
}

impl VideoDecoder for Ffmpeg {
    fn decode(&mut self, frame: usize, light: &Light, out: &mut [f32]) -> Result<(), FrameFault> {
        let read = self.pixels.read_exact(&mut self.codes);
        read.map_err(|e| undecodable(format!("frame {frame} of {}: {e}", self.frames)))?;
        folder::colour::<_, 3>(&self.codes, light, out);
        Ok(())
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
    // The prefix keeps any name of a file from being taken for an address or an option.
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
