//! The part of `evpose eval` of bodies that is about joints in the world.

use anyhow::Result;
use evpose_core::Micros;
use evpose_pose::metric::body::{SpatialErrors, SpatialSummary};
use evpose_task::body::{BodyCheckpoint, BodyPredictor, SpatialConfig};
use evpose_train::body::{BodyRecordings, calibrated_scenes, evaluate_spatial};
use serde::Serialize;

use super::eval::cell;
use crate::progress::{bar, say};

/// Scores of joints in the world, as written to JSON.
#[derive(Debug, Serialize)]
pub(super) struct WorldScores {
    /// Smallest and largest number of cameras of a scene.
    cameras: [usize; 2],
    /// Of triangulated joints.
    triangulated: SpatialSummary,
    /// Of triangulated joints after the Kalman filter.
    filtered: SpatialSummary,
}

/// Evaluates and prints joints in the world; none if no scene was recorded by several calibrated
/// cameras.
pub(super) fn evaluate(
    checkpoint: &BodyCheckpoint,
    predictor: &BodyPredictor,
    recordings: &BodyRecordings,
    every: Micros,
) -> Result<Option<WorldScores>> {
    let scenes = calibrated_scenes(recordings)?;
    let counts = || scenes.iter().map(|scene| scene.recordings.len());
    let Some((least, most)) = counts().min().zip(counts().max()) else { return Ok(None) };
    let progress = bar("triangulating", scenes.len() as u64, "scenes");
    let config = SpatialConfig::filtered();
    let advance = |done| progress.inc(done);
    let errors = evaluate_spatial(checkpoint, predictor, &scenes, every, &config, &advance)?;
    progress.finish_and_clear();
    let (triangulated, filtered): (Vec<SpatialErrors>, Vec<SpatialErrors>) =
        errors.into_iter().map(Into::into).unzip();
    let bootstrap = &checkpoint.config.evaluation.bootstrap;
    let scores = WorldScores {
        cameras: [least, most],
        triangulated: SpatialSummary::new(&triangulated, bootstrap),
        filtered: SpatialSummary::new(&filtered, bootstrap),
    };
    let cameras = if least == most { format!("{least}") } else { format!("{least} to {most}") };
    say(format!("joints in the world, {} scenes of {cameras} cameras:", scenes.len()));
    for (name, summary) in [("triangulated", &scores.triangulated), ("filtered", &scores.filtered)]
    {
        say(format!(
            "{name:<14}MPJPE {} mm, {:.1}% of the joints missing",
            cell(summary.mpjpe_mm, 1),
            100.0 * summary.missing
        ));
    }
    for joint in &scores.filtered.joints {
        let error = joint.error_mm.map_or_else(|| "-".to_owned(), |mm| format!("{mm:.1}"));
        let missing = 100.0 * joint.missing;
        say(format!("{:<12}{error:>9} mm, {missing:.1}% missing", joint.joint));
    }
    Ok(Some(scores))
}
