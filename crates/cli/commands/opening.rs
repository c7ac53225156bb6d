//! How a recording is opened, where its file leaves a choice.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_core::SensorSize;
use evpose_io::Encoding;
use evpose_io::FrameSource;
use evpose_io::OpenOptions;
use evpose_sim::SequenceInfo;

/// Images that light is read from.
#[derive(Debug, clap::Args)]
pub(crate) struct FrameArgs {
    /// A folder of .png or .jpg images (8 or 16 bits, grey or colour, in natural order of their names), or
    /// an .npy array (frames, height, width) of u1, u2, f2, f4 or f8
    #[arg(long)]
    pub(crate) frames: PathBuf,
    /// Frames per second; the first is at time 0
    #[arg(long)]
    pub(crate) fps: f64,
    /// How values stand for light. `linear`: in proportion, as v2e takes them. `srgb`: as on a
    /// display, which is what cameras and video files store
    #[arg(long, default_value = "linear", value_parser = ["linear", "srgb"])]
    pub(crate) encoding: String,
    /// The value of reference white [default: 255 of 8 bits, 65535 of 16 bits, 1 of floats]
    #[arg(long)]
    pub(crate) white: Option<f64>,
}

impl FrameArgs {
    /// Opens them.
    pub(crate) fn open(&self) -> Result<FrameSource> {
        let encoding: Encoding = self.encoding.parse().map_err(anyhow::Error::msg)?;
        Ok(FrameSource::open(&self.frames, encoding, self.white)?)
    }
}

/// Properties of a recording that its file may not state.
#[derive(Debug, clap::Args)]
pub(crate) struct OpeningArgs {
    /// The sensor, for files that do not state it, for example 346x260
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) sensor: Option<SensorSize>,
    /// Camera of a file that holds several, counted from 0
    #[arg(long)]
    pub(crate) camera: Option<u8>,
    /// Microseconds in a tick of YARP's clock: 0.08 or 1
    #[arg(long, value_name = "MICROSECONDS")]
    pub(crate) tick_us: Option<f64>,
    /// Take what is readable of a damaged file, and say what is lost
    #[arg(long)]
    pub(crate) salvage: bool,
}

impl OpeningArgs {
    /// How to open `input`; what was simulated says beside its file what sensor it is of.
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

/// A recording and how it is opened.
#[derive(Debug, clap::Args)]
pub(crate) struct RecordingArgs {
    /// Recording of any format; `evpose convert --help` lists them
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
}

/// Columns and rows, as 346x260.
pub(crate) fn parse_size(text: &str) -> Result<SensorSize> {
    let (width, height) = text.split_once('x').context("expected columns x rows, as 346x260")?;
    let pixels = |text: &str| text.parse().ok().filter(|&n: &u16| n > 0);
    let width = pixels(width).context("columns are a whole number from 1 to 65535")?;
    let height = pixels(height).context("rows are a whole number from 1 to 65535")?;
    Ok(SensorSize { width, height })
}
