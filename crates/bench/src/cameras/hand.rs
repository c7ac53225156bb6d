//! Hands before any sensor.

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_app::hand_config;
use evpose_app::progress::bar;
use evpose_core::{Micros, SensorSize};
use evpose_pose::metric::{HandEvaluation, SequenceScores};
use evpose_pose::stream::{InferenceSchedule, StreamFrontend as _};
use evpose_sim::{Simulation, SimulationConfig};
use evpose_task::hand::{HandCheckpoint, HandView, canonical_view, hand_stream};
use evpose_view::Calibration;
use rayon::prelude::*;

use super::{BenchCamerasArgs, Scenes, covering_fov_deg};

/// Config of the scenes.
const SCENES: &str = "quick";
/// A frame of labels.
const FRAME: Micros = Micros(1_000);
/// Inputs of one inference.
const BATCH: usize = 64;

/// Scenes of hands.
pub(super) struct HandScenes {
    checkpoint: HandCheckpoint,
    simulation: SimulationConfig,
    seed: u64,
}

impl HandScenes {
    pub(super) fn new(checkpoint: HandCheckpoint, args: &BenchCamerasArgs) -> Result<Self> {
        let mut simulation = hand_config::load(SCENES, &[])?.simulation;
        simulation.sequences = args.sequences;
        simulation.seconds = args.seconds;
        simulation.image_scale = 1.0;
        Ok(Self { checkpoint, simulation, seed: args.seed })
    }

    /// Scores of the poses of one sequence, every millisecond.
    fn scores(&self, simulation: &Simulation, index: u64) -> Result<SequenceScores> {
        let (config, simulated) = (&self.checkpoint.config, simulation.config());
        let fov_deg = f64::from(simulated.camera.vertical_fov_deg);
        let calibration = Calibration::from_vertical_fov(simulated.image_size(), fov_deg);
        let predictor = self.checkpoint.predictor(Device::flex())?;
        let every_ms = InferenceSchedule::Every(FRAME);
        let mut stream = hand_stream(config, predictor, &calibration, every_ms, BATCH)?;
        let first = stream.frontend.first_stride(Micros(0), FRAME);
        let mut simulator = simulation.sequence(index)?;
        let (mut truth, mut poses, mut betas) = (Vec::new(), Vec::new(), Vec::new());
        let mut t = FRAME - Micros(1);
        for _ in 0..simulated.frames() {
            let step = simulator.advance()?;
            truth.push(step.label);
            betas.clone_from(&step.episode.betas);
            stream.frontend.push(step.events)?;
            if t >= first {
                stream.frontend.stride(t);
                poses.extend(stream.infer(t)?);
            }
            t = t + FRAME;
        }
        poses.extend(stream.finish(t)?);
        let (view, side) = (HandView::new(config)?, config.simulation.hands.side(0));
        let mut scores = SequenceScores::default();
        for (t, pose) in poses {
            // A pose is that of the end of its frame.
            let Some(truth) = truth.get((t.0 / FRAME.0 - 1) as usize) else { continue };
            let predicted = view.points(side, &pose.measured, &[]);
            scores.push_points(&predicted, &view.points(side, truth, &betas));
        }
        Ok(scores)
    }
}

impl Scenes for HandScenes {
    fn metric(&self) -> &'static str {
        "AUC 2D"
    }

    fn native(&self) -> SensorSize {
        canonical_view(&self.checkpoint.config).sensor
    }

    fn score(&self, sensor: SensorSize) -> Result<f64> {
        let mut scenes = self.simulation.clone();
        scenes.sensor_size = sensor;
        let fov_deg = f64::from(scenes.camera.vertical_fov_deg);
        scenes.camera.vertical_fov_deg = covering_fov_deg(sensor, fov_deg) as f32;
        let simulation = Simulation::new(&scenes, self.seed)?;
        let progress = bar("simulating", scenes.sequences as u64, "sequences");
        let sequences = (0..scenes.sequences as u64)
            .into_par_iter()
            .map(|index| {
                let scores = self.scores(&simulation, index);
                progress.inc(1);
                scores
            })
            .collect::<Result<Vec<_>>>()?;
        progress.finish_and_clear();
        let evaluation = HandEvaluation { sequences };
        let config = &self.checkpoint.config;
        let summary = evaluation.summary(&config.evaluation.bootstrap);
        Ok(summary.auc_2d.context("no pose was evaluated")?.estimate)
    }
}
