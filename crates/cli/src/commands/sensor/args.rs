//! Arguments of `evpose sensor`.

use std::path::PathBuf;

use crate::outputs::OutputFile;
use crate::ranges::{threads, within};
use clap::{Subcommand, ValueEnum};

/// Subcommands of `evpose sensor`.
#[derive(Debug, Subcommand)]
#[command(
    after_help = "Start with:\n  evpose sensor list\n  evpose sensor show davis346\n  evpose sensor tap davis346 --pixel 120,90\n  evpose sensor gallery --out gallery.html"
)]
pub enum SensorCommand {
    /// All presets, and all effects with their parameters
    List(ListArgs),
    /// The chain of a sensor as a table, or the description of an effect
    Show(ShowArgs),
    /// Plot the signal of one pixel after every stage
    Tap(TapArgs),
    /// Every preset and every effect at three strengths, on one web page
    Gallery(GalleryArgs),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  evpose sensor list")]
pub struct ListArgs {
    /// Print JSON, with ranges, priors and sources
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose sensor show davis346\n  \
    evpose sensor show my-camera.toml --json\n  evpose sensor show leak_on")]
pub struct ShowArgs {
    /// A preset, a TOML file of effects, or the name of one effect
    pub(crate) name: String,
    /// Print JSON, with ranges, priors and sources
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose sensor tap davis346 --pixel 120,90\n  \
    evpose sensor tap evk4 --pixel 120,90 --input hand --out hand.svg\n  \
    evpose sensor tap my-camera.toml --pixel 0,0 --input flicker --out flicker.csv\n\n\
    Inputs other than the hand light a spot of 15 x 15 pixels, L = ln(light / white):\n  \
    step     L = -2.3, from 50 ms -0.7, from 150 ms -2.3 again, known every 0.1 ms\n  \
    ramp     L rises from -2.3 to -0.3 in 100 ms, rests for 50 ms, and falls back in 100 ms\n  \
    flicker  light 0.2 (1 + 0.5 sin(2 pi 50 Hz t))")]
pub struct TapArgs {
    /// A preset, or a TOML file of effects
    pub(crate) sensor: String,
    /// Column and row of the pixel, of 240 x 180
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pub(crate) pixel: (u16, u16),
    /// Output: a plot (.svg) or a table (.csv)
    #[arg(long, default_value = "tap.svg")]
    pub(crate) out: OutputFile,
    /// Light at the pixel
    #[arg(long, value_enum, default_value = "step")]
    pub(crate) input: Input,
    /// Seed of all noise and of the hand
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
}

/// Light at a tapped pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Input {
    /// A step to five times the light, and back
    Step,
    /// A ramp of log light, up and down
    Ramp,
    /// Flicker of 50 Hz
    Flicker,
    /// The simulator's moving hand
    Hand,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose sensor gallery --out gallery.html\n  \
    evpose sensor gallery --out leaks.html --only leak_on,parasitic_photo_leak,davis346")]
pub struct GalleryArgs {
    /// Where to write the page
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Only these presets and effects
    #[arg(long, value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// Scale of the image
    #[arg(long, default_value_t = 1.0, value_parser = within(0.1..=20.0_f32))]
    pub(crate) scale: f32,
    /// Seed of the hand and of all noise; with 10, all fingers are visible
    #[arg(long, default_value_t = 10)]
    pub(crate) seed: u64,
    /// CPU threads; all cores by default
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
}

fn pixel(text: &str) -> Result<(u16, u16), String> {
    let parts = text.split_once(',').and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)));
    parts.ok_or_else(|| "expected column,row: for example 120,90".to_owned())
}
