//! Evaluation of people in the world: scenes that several calibrated cameras recorded.

use std::collections::BTreeMap;
use std::path::PathBuf;

use evpose_core::{Micros, PlacedCamera};
use evpose_io::{OpenOptions, Windows};
use evpose_pose::body::WorldJoints;
use evpose_pose::metric::body::SpatialErrors;
use evpose_sim::person::{PoseTable, RecordingPlace};
use evpose_task::body::{
    BodyCheckpoint, BodyPredictor, PlacedRecording, SpatialConfig, SpatialRecordings,
};
use rayon::prelude::*;

use super::recordings::{BodyRecordings, PoseTrack};
use crate::TrainError;

/// The recordings of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedScene {
    /// Index of the scene.
    pub scene: u64,
    /// Events, poses and camera of each recording.
    pub recordings: Vec<(PathBuf, PathBuf, PlacedCamera)>,
}

/// The scenes of a directory that two or more cameras recorded whose place is known.
///
/// # Errors
/// If the metadata of a recording cannot be read.
pub fn calibrated_scenes(recordings: &BodyRecordings) -> Result<Vec<CalibratedScene>, TrainError> {
    let mut scenes: BTreeMap<u64, Vec<_>> = BTreeMap::new();
    for (events, poses) in &recordings.files {
        let RecordingPlace { scene, camera } =
            RecordingPlace::read(&events.with_extension("toml"))?;
        if let Some((scene, camera)) = scene.zip(camera) {
            scenes.entry(scene).or_default().push((events.clone(), poses.clone(), camera));
        }
    }
    // A single camera has nothing to triangulate with.
    scenes.retain(|_, recordings| recordings.len() > 1);
    let scene = |(scene, recordings)| CalibratedScene { scene, recordings };
    Ok(scenes.into_iter().map(scene).collect())
}

/// Errors of each scene: of its triangulated joints, and of the filtered ones, of the poses that `evpose infer`
/// writes every `every`, from the time of the first sample of the checkpoint's config on. `progress` receives 1
/// after each scene.
///
/// # Errors
/// If a recording cannot be read.
pub fn evaluate_spatial(
    checkpoint: &BodyCheckpoint,
    predictor: &BodyPredictor,
    scenes: &[CalibratedScene],
    every: Micros,
    config: &SpatialConfig,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<[SpatialErrors; 2]>, TrainError> {
    let one = |scene: &CalibratedScene| {
        let open = |(events, _, camera): &(PathBuf, PathBuf, PlacedCamera)| {
            let windows = Windows::open(events, &OpenOptions::default())?;
            Ok(PlacedRecording::new(windows, *camera, checkpoint, None, predictor.another())?)
        };
        let recordings =
            scene.recordings.iter().map(open).collect::<Result<Vec<_>, TrainError>>()?;
        // Each table has the same positions in the world.
        let track = PoseTrack(PoseTable::read(&scene.recordings[0].1)?);
        let first = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
        let mut errors = [SpatialErrors::default(), SpatialErrors::default()];
        for pose in SpatialRecordings::new(recordings, *config, every)? {
            let pose = pose?;
            // Tables without positions in the world have no truth.
            let joints_m = track.at_m(pose.t).filter(|m| pose.t >= first && m[0].is_finite());
            let Some(joints_m) = joints_m else { continue };
            let truth: WorldJoints = joints_m.map(|at_m| at_m.is_finite().then(|| at_m.as_dvec3()));
            let points = pose.points.map(|point| point.map(|point| point.position_m));
            errors[0].push(&points, &truth);
            errors[1].push(&pose.joints_m, &truth);
        }
        progress(1);
        Ok(errors)
    };
    scenes.par_iter().map(one).collect()
}
