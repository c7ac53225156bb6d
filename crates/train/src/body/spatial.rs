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

use super::recordings::BodyRecordings;
use crate::TrainError;

/// The recordings of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedScene {
    /// Its number.
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
    scenes.retain(|_, recordings| recordings.len() > 1);
    let scene = |(scene, recordings)| CalibratedScene { scene, recordings };
    Ok(scenes.into_iter().map(scene).collect())
}

/// Errors of each scene: of its triangulated joints, and of the filtered ones, a pose every `every`
/// from the first sample of the checkpoint's config on. `progress` receives 1 after each scene.
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
            Ok(PlacedRecording::new(windows, *camera, checkpoint, predictor.another())?)
        };
        let recordings =
            scene.recordings.iter().map(open).collect::<Result<Vec<_>, TrainError>>()?;
        let mut people = SpatialRecordings::new(recordings, *config);
        let table = PoseTable::read(&scene.recordings[0].1)?;
        let mut next = Micros(1_000 * i64::from(checkpoint.config.data.first_ms));
        let mut errors = [SpatialErrors::default(), SpatialErrors::default()];
        // At labels alone: the world of the labels is not interpolated.
        for row in table.rows.iter().filter(|row| row.joints_m[0].is_finite()) {
            if row.t < next {
                continue;
            }
            next = row.t + every;
            let truth: WorldJoints =
                row.joints_m.map(|at_m| at_m.is_finite().then(|| at_m.as_dvec3()));
            let pose = people.pose(row.t)?;
            let points = pose.points.map(|point| point.map(|point| point.position_m));
            errors[0].push(&points, &truth);
            errors[1].push(&pose.joints_m, &truth);
        }
        progress(1);
        Ok(errors)
    };
    scenes.par_iter().map(one).collect()
}
