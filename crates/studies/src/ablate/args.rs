//! Arguments of `evpose ablate`.

use clap::builder::{PossibleValue, PossibleValuesParser};

use super::body::AblateBodyArgs;
use super::rows::{BACKBONES, ROWS};
use crate::study::{SeedArgs, StudyArgs};
use evpose_cli::ranges::count;

/// The ablation studies.
#[derive(Debug, clap::Subcommand)]
#[command(after_help = "Start with:\n  evpose ablate hand --out runs/ablation\n  \
    evpose ablate body --out runs/ablation-body")]
pub enum AblateCommand {
    /// The EventHands method: window lengths, representations, augmentation, filter, networks
    Hand(AblateHandArgs),
    /// The MoveEnet method: representation, stages of training, resolution, moving cameras
    Body(AblateBodyArgs),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose ablate hand --out runs/ablation\n  \
    evpose ablate hand --out runs/ablation --resume\n  \
    evpose ablate hand --rows lnes-33,eoi,no-filter --seeds 5 --out runs/inputs\n  \
    evpose ablate hand --rows backbones --seeds 1 --stride-ms 5 --out runs/networks \\\n      \
    --set simulation.image_scale=0.42 --set simulation.sequences=240 --set network.width=0.0625 \\\n      \
    --set training.steps=1000 --set training.steps_per_validation=100\n\n\
    Every row is the full method with one thing changed. Sequences are simulated once for each seed \
    and shared by all rows; the full method always runs, since every row is compared with it. More \
    rows and seeds can be added to a directory later, with --resume. `backbones` stands for all rows of \
    other networks; Inception v3 is left out where images have less than 75 pixels a side.")]
pub struct AblateHandArgs {
    /// A TOML file, or an embedded config: `ablation`, `quick`, `eventhands`
    #[arg(long, default_value = "ablation")]
    pub(crate) config: String,
    /// Rows to run, comma-separated [default: all]
    #[arg(long, value_delimiter = ',', value_parser = row_names())]
    pub(crate) rows: Vec<String>,
    #[command(flatten)]
    pub(crate) seeds: SeedArgs,
    /// Milliseconds between the poses that are evaluated and filtered
    #[arg(long, default_value_t = 1, value_parser = count::<u32>())]
    pub(crate) stride_ms: u32,
    #[command(flatten)]
    pub(crate) study: StudyArgs,
}

fn row_names() -> PossibleValuesParser {
    let group = PossibleValue::new(BACKBONES).help("every row of another network");
    let rows = ROWS.iter().map(|row| PossibleValue::new(row.name).help(row.about));
    PossibleValuesParser::new(rows.chain([group]).collect::<Vec<_>>())
}
