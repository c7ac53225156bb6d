//! `evpose compare`: the systems that MoveEnet was compared with, under one protocol.
//!
//! MoveEnet, the networks of DHP19 and LiftMono-HPE are trained here, on the same people; networks of others run from the ONNX
//! files that the user names. All are evaluated on the same held-out recordings, each on images of its
//! own representation, and every published ordering of two systems is tested.
//!
//! * `system`: the registry of systems, with their published figures.
//! * `ordering`: the registry of published orderings, and their tests.
//! * `baselines`: networks of others that are trained here.
//! * `clips`: what pre-training and fine-tuning are worth on real images.
//! * `data`: recordings or images to train on and to evaluate on.
//! * `predictor`: a system ready to predict poses.
//! * `spatial`: joints in space, of two calibrated cameras.
//! * `trial`: one system under one seed: evaluated and timed.
//! * `outcome`: means over seeds with intervals; `table` and `page` render them.

mod args;
mod baselines;
mod clips;
mod data;
mod measure;
mod ordering;
mod outcome;
mod page;
mod predictor;
mod spatial;
mod study;
mod system;
mod table;
mod trial;

use anyhow::Result;

pub use args::{CompareBodyArgs, CompareCommand};
pub use clips::CompareClipsArgs;

/// Runs a comparison.
///
/// # Errors
/// If a network cannot be trained or evaluated, or a result cannot be written.
pub fn run(command: &CompareCommand) -> Result<()> {
    match command {
        CompareCommand::Body(args) => study::run(args),
        CompareCommand::Clips(args) => clips::run(args),
    }
}
