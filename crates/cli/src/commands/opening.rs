//! Arguments of opening frames and recordings.

use std::path::PathBuf;

use crate::progress::say;
use crate::ranges::{hertz, within};
use crate::tasks::opening::OpeningArgs;
use anyhow::{Context, Result, ensure};
use evpose_io::{Encoding, FrameSource, OpenOptions};

/// Frames and their luminance.
#[derive(Debug, clap::Args)]
pub(crate) struct FrameArgs {
    /// A folder of .png or .jpg images (8 or 16 bits, grey or colour, in natural order of their
    /// names), an .npy array (frames, height, width) of u1, u2, f2, f4 or f8, a video (.gif and .y4m
    /// are read, others decoded by the program ffmpeg), or a recording of ROS with images
    #[arg(long)]
    pub(crate) frames: PathBuf,
    /// Frames per second; the first is at time 0 [default: the times that a video or a recording of ROS states]
    #[arg(long, value_parser = hertz())]
    pub(crate) fps: Option<f64>,
    /// Encoding of luminance: `linear`, as v2e assumes, or `srgb`, as cameras and video files store
    /// it
    #[arg(long, default_value = "linear", value_parser = ["linear", "srgb"])]
    pub(crate) encoding: String,
    /// The value of reference white [default: 255 for 8 bits, 65535 for 16 bits, 1 for floats, of which
    /// values above 2 are taken for those of 8 bits]
    #[arg(long, value_parser = within(1e-6..=1e9))]
    pub(crate) white: Option<f64>,
}

impl FrameArgs {
    /// The rate that must be given.
    pub(crate) fn rate(&self) -> Result<f64> {
        self.fps.context("--fps is required, for frames at a constant rate")
    }

    /// The times that frames state, in seconds since the first, unless a rate is given.
    pub(crate) fn stated_times<'a>(&self, source: &'a FrameSource) -> Result<Option<&'a [f64]>> {
        // A given rate wins: slow-motion videos state that of their playback.
        let times = source.times_s().filter(|_| self.fps.is_none());
        ensure!(
            times.is_none_or(|times| times.is_sorted_by(|a, b| a < b)),
            "{}: its frames state times that do not increase: give --fps",
            self.frames.display()
        );
        Ok(times)
    }

    /// Opens the frames; `options` are of the recording that may hold them.
    pub(crate) fn open(&self, options: &OpenOptions) -> Result<FrameSource> {
        let encoding: Encoding = self.encoding.parse().map_err(anyhow::Error::msg)?;
        let source = FrameSource::open_as(&self.frames, encoding, self.white, options)?;
        if let Some(note) = source.note() {
            say(format!("note      {note}"));
        }
        Ok(source)
    }
}

/// A recording and its options.
#[derive(Debug, clap::Args)]
pub(crate) struct RecordingArgs {
    /// Recording in any supported format; `evpose convert --help` lists them
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
}
