//! `evpose simulate`.

use anyhow::{Context, Result};
use evpose_core::atomic_write;
use evpose_sim::set::MANIFEST;
use evpose_sim::{SequenceSet, Shard, Simulation};
use evpose_train::Condition;

use evpose_app::progress::say;
use evpose_app::recorded::{claim, held_out, record_shard_of};
use evpose_app::threads::use_threads;
use evpose_app::{body_config, hand_config};

use super::body;
use evpose_app::args::ConfigArgs;
use evpose_report::camera_views;
use evpose_report::png::png;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose simulate quick --out data/train\n  \
    evpose simulate eventhands --out data/one --sequences 1 --seconds 10 --seed 7\n  \
    evpose simulate quick --out data/train --shard 3/64 --resume\n  \
    evpose simulate quick --condition dark --out data/dark --held-out\n  \
    evpose simulate eventhands --set simulation.motion.variant=bottom --sequences 8 --seconds 3 \
    --out data/bottom --preview bottom.png\n\n\
    Shards may share a directory or be copied together: the files are those of one run. The last \
    one to finish\nwrites manifest.sha256; `evpose info --verify DIR` and `sha256sum -c` check it. \
    docs/guide/scale.md says more.")]
pub(crate) struct SimulateArgs {
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Directory to write the sequences into
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// Length of each sequence in seconds, instead of the config's
    #[arg(long)]
    pub(crate) seconds: Option<f64>,
    /// Number of sequences, instead of the config's
    #[arg(long)]
    pub(crate) sequences: Option<usize>,
    /// Seed, instead of the config's
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// Record the held-out set: its number and length of sequences, and seeds of its own
    #[arg(long)]
    pub(crate) held_out: bool,
    /// Record only part I of N of the sequences (I from 1), beside those of other shards
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Keep the sequences that are complete and record the others
    #[arg(long)]
    pub(crate) resume: bool,
    /// A condition to record under (`evpose eval --help` lists them), or a TOML file of one
    #[arg(long)]
    pub(crate) condition: Option<String>,
    /// Also write a PNG file of what the camera looks at, with the events beside it
    #[arg(long, alias = "pictures", value_name = "FILE")]
    pub(crate) preview: Option<PathBuf>,
    /// CPU threads; all cores by default. The bytes written do not depend on it
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

pub(crate) fn run(args: &SimulateArgs) -> Result<()> {
    use_threads(args.threads)?;
    if let Some(config) = body_config::config(&args.config)? {
        return body::simulate(config, args);
    }
    let mut config = hand_config::load(&args.config.config, &args.config.overrides)?;
    if let Some(condition) = &args.condition {
        config = Condition::load(condition)?.apply(&config)?;
    }
    if args.held_out {
        config = held_out(&config);
    }
    let simulation = &mut config.simulation;
    simulation.seconds = args.seconds.unwrap_or(simulation.seconds);
    simulation.sequences = args.sequences.unwrap_or(simulation.sequences);
    config.seed = args.seed.unwrap_or(config.seed);
    config.simulation.validate()?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let set = SequenceSet::new(&args.out, config.simulation.sequences);
    claim(&set, &config, shard, args.resume)?;
    let recorded = record_shard_of(&config, &args.out, shard, "simulating")?;
    recorded.report_earlier_work();
    if recorded.sequences > 0 {
        say(&recorded);
        say(format!("written to {}", args.out.display()));
    }
    say(if recorded.finished {
        format!("all {} sequences are there: {MANIFEST}", config.simulation.sequences)
    } else {
        format!("shard {shard} is complete; whoever records the last sequence writes {MANIFEST}")
    });
    if let Some(path) = &args.preview {
        let sheet = camera_views::sheet(&Simulation::new(&config.simulation, config.seed)?)?;
        atomic_write(path, &png(&sheet)?).with_context(|| format!("writing {}", path.display()))?;
        say(format!("preview: {}", path.display()));
    }
    Ok(())
}
