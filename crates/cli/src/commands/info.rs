//! `evpose info`: descriptions of files, data sets and devices.

use crate::tasks::opening::OpeningArgs;
use anyhow::{Result, bail};
use evpose_body::files::ModelFile;
use evpose_io::detect_format;

use super::{checkpoint_info, data_set, devices};
use crate::progress::say;
use crate::shipped::{card_of, checkpoint_path};
use std::path::PathBuf;

/// Arguments of `evpose info`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  evpose info data/train/0000.evc\n  evpose info MANO_RIGHT.pkl\n  \
    evpose info body\n  \
    evpose info --verify data/train\n  evpose info --devices"
)]
pub struct InfoArgs {
    /// Recordings of any format, checkpoints (.bpk) or names of shipped ones, hand and body models (.pkl, .npz), all recognised by
    /// content; directories of sequences
    #[arg(required_unless_present = "devices")]
    pub(crate) files: Vec<PathBuf>,
    /// Read every file of a directory of sequences and compare it with its digest
    #[arg(long)]
    pub(crate) verify: bool,
    /// List the devices that networks can be computed on, and why others cannot
    #[arg(long, conflicts_with_all = ["files", "verify"])]
    pub(crate) devices: bool,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
}

/// Runs `evpose info`.
pub fn run(args: &InfoArgs) -> Result<()> {
    if args.devices {
        say(devices::describe());
    }
    for (i, given) in args.files.iter().enumerate() {
        // Names of shipped networks are accepted as paths are.
        let file = &checkpoint_path(given)?;
        if i > 0 {
            say("");
        }
        // Recordings of ROS 2 and of YARP are folders as well.
        if file.is_dir() && detect_format(file).is_err() {
            data_set::describe(file)?;
            if args.verify {
                data_set::verify(file)?;
            }
        } else if args.verify {
            bail!("{}: --verify is for directories of sequences", file.display());
        } else if checkpoint_info::is_likely(file) {
            say(checkpoint_info::describe(file)?);
            if let Some(card) = card_of(&std::fs::read(file)?) {
                say(format!("\n{card}"));
            }
        } else if ModelFile::is_likely(file) {
            let model = ModelFile::read(file)?;
            say(format!("{}\n{model}", file.display()));
        } else {
            say(evpose_io::info(file, &args.opening.options(file)?)?);
        }
    }
    Ok(())
}
