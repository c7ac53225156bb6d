//! What a `.bpk` file is the network of.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Result;
use burn::module::Module;
use burn::tensor::Device;
use evpose_task::hand::HandCheckpoint;

use evpose_app::body_checkpoint;

/// What the names of our weight files end with.
const EXTENSION: &str = "bpk";

/// Whether a file is one, by its name.
pub(super) fn is_likely(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == EXTENSION)
}

/// The network, what it was trained on, and the experiment.
pub(super) fn describe(path: &Path) -> Result<String> {
    let device = Device::flex();
    let mut text = path.display().to_string();
    let config = if let Some(body) = body_checkpoint::checkpoint(path, &device)? {
        let image = &body.config.image;
        let _ = write!(
            text,
            "\nbodies: {} joints from {} of {side}x{side} pixels, {} parameters",
            body.network.config().joints,
            image.representation,
            body.network.num_params(),
            side = image.side_px,
        );
        if let Some(data) = &body.data {
            let _ = write!(text, "\ntrained on data of SHA-256 {data}");
        }
        body.config.to_toml()?
    } else {
        let hand = HandCheckpoint::load(path, &device)?;
        let (representation, simulation) = (&hand.config.representation, &hand.config.simulation);
        let _ = write!(
            text,
            "\nhands: {} of width {} from {} of {} ms at {}, {} parameters",
            hand.config.network.backbone,
            hand.config.network.width,
            representation.name,
            representation.window_ms,
            simulation.image_size(),
            hand.network.num_params(),
        );
        hand.config.to_toml()?
    };
    let _ = write!(text, "\nthe experiment it came from:\n\n{}", config.trim_end());
    Ok(text)
}
