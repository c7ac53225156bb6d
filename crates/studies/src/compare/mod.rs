//! `evpose compare`: the systems that MoveEnet was compared with, under one protocol.
//!
//! MoveEnet, the networks of DHP19 and LiftMono-HPE are trained here, on the same people; networks of others run from the ONNX
//! files that the user names. All are evaluated on the same held-out recordings, each on images of its
//! own representation, and every published ordering of two systems is tested.
//!
//! * `system`: the registry of systems, with their published figures; `ordering`: that of published orderings.
//! * `stages`, `networks`: what networks of bodies are trained with, several at once; `baselines`: networks
//!   of others that are trained here.
//! * `clips`: what pre-training and fine-tuning are worth on real images.
//! * `data`: recordings or images to train on and to evaluate on.
//! * `predictor`: a system ready to predict poses; `spatial`: joints in space, of two calibrated cameras.
//! * `trial`: one system under one seed: evaluated and timed; `study`: all of them, here and in `evpose ablate body`.

pub(crate) mod args;
mod baselines;
mod clips;
pub(crate) mod data;
mod networks;
pub(crate) mod ordering;
mod predictor;
mod spatial;
pub(crate) mod stages;
pub(crate) mod study;
pub(crate) mod system;
mod trial;

use anyhow::Result;

pub use args::{CompareBodyArgs, CompareCommand};
pub use clips::CompareClipsArgs;
use data::Data;
use study::Protocol;

/// The protocol of MoveEnet's tables.
const COMPARISON: Protocol = Protocol {
    title: "Systems that estimate poses of people",
    system: "system",
    folder: "systems",
    files: ["comparison.json", "comparison.md", "comparison.html"],
    orderings: ordering::ORDERINGS,
    about_orderings: "Statements of MoveEnet's tables and text about two systems, and their tests: the first system \
                      minus the second.",
};

/// Runs a comparison.
///
/// # Errors
/// If a network cannot be trained or evaluated, or a result cannot be written.
pub fn run(command: &CompareCommand) -> Result<()> {
    match command {
        CompareCommand::Body(args) => {
            let data = Data::new(args.train.as_ref(), args.data.as_ref())?;
            let chosen = system::selected(&system::SYSTEMS, &args.systems);
            study::run(&COMPARISON, &args.body, chosen, data, &args.files)
        }
        CompareCommand::Clips(args) => clips::run(args),
    }
}
