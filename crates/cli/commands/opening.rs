//! Arguments of opening frames and recordings.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_core::SensorSize;
use evpose_io::Encoding;
use evpose_io::FrameSource;
use evpose_io::OpenOptions;
use evpose_sim::SequenceInfo;

/// Frames and their luminance.
#[derive(Debug, clap::Args)]
pub(crate) struct FrameArgs {
    /// A folder of .png or .jpg images (8 or 16 bits, grey or colour, in natural order of their
    /// names), or an .npy array (frames, height, width) of u1, u2, f2, f4 or f8
    #[arg(long)]
    pub(crate) frames: PathBuf,
    /// Frames per second; the first is at time 0
    #[arg(long)]
    pub(crate) fps: f64,
    /// Encoding of luminance: `linear`, as v2e assumes, or `srgb`, as cameras and video files store
    /// it
    #[arg(long, default_value = "linear", value_parser = ["linear", "srgb"])]
    pub(crate) encoding: String,
    /// The value of reference white [default: 255 for 8 bits, 65535 for 16 bits, 1 for floats]
    #[arg(long)]
    pub(crate) white: Option<f64>,
}

impl FrameArgs {
    /// Opens the frames.
    pub(crate) fn open(&self) -> Result<FrameSource> {
        let encoding: Encoding = self.encoding.parse().map_err(anyhow::Error::msg)?;
        Ok(FrameSource::open(&self.frames, encoding, self.white)?)
    }
}

/// Properties of a recording that its file may not state.
#[derive(Debug, clap::Args)]
pub(crate) struct OpeningArgs {
    /// Sensor size, for files that do not state it, for example 346x260
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) sensor: Option<SensorSize>,
    /// Camera of a file that holds several, counted from 0
    #[arg(long)]
    pub(crate) camera: Option<u8>,
    /// Microseconds per tick of YARP's clock: 0.08 or 1
    #[arg(long, value_name = "MICROSECONDS")]
    pub(crate) tick_us: Option<f64>,
    /// Read the intact parts of a damaged file, and report what is lost
    #[arg(long)]
    pub(crate) salvage: bool,
}

impl OpeningArgs {
    /// Options of opening `input`; simulated recordings state their sensor in a file beside them.
    pub(crate) fn options(&self, input: &Path) -> OpenOptions {
        let simulated = || SequenceInfo::beside(&input.with_extension("")).ok().flatten();
        OpenOptions {
            sensor: self.sensor.or_else(|| simulated().map(|info| info.sensor)),
            camera: self.camera,
            tick_us: self.tick_us,
            salvage: self.salvage,
        }
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

/// Parses a size such as 346x260.
pub(crate) fn parse_size(text: &str) -> Result<SensorSize> {
    let (width, height) =
        text.split_once('x').context("expected WIDTHxHEIGHT, for example 346x260")?;
    let pixels = |text: &str| text.parse().ok().filter(|&n: &u16| n > 0);
    let width = pixels(width).context("the width is an integer from 1 to 65535")?;
    let height = pixels(height).context("the height is an integer from 1 to 65535")?;
    Ok(SensorSize { width, height })
}
