//! Hands before any sensor.

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_camera::{Calibration, ViewAdaptor};
use evpose_cli::configs;
use evpose_cli::progress::bar;
use evpose_core::{EventStream, SensorSize};
use evpose_pose::HandParams;
use evpose_pose::metric::{HandEvaluation, SequenceScores};
use evpose_sim::{Simulation, SimulationConfig};
use evpose_task::hand::HandConfig;
use evpose_task::hand::{HandCheckpoint, HandView, canonical_view, poses_every_ms};
use rayon::prelude::*;

use super::{BenchCamerasArgs, Scenes, covering_fov_deg};

/// Config of the scenes.
const SCENES: &str = "quick";

/// Scenes of hands.
pub(super) struct HandScenes {
    checkpoint: HandCheckpoint,
    simulation: SimulationConfig,
    seed: u64,
}

/// A sequence before a sensor.
struct SeenSequence {
    events: EventStream,
    truth: Vec<HandParams>,
    betas: Vec<f32>,
}

impl HandScenes {
    pub(super) fn new(checkpoint: HandCheckpoint, args: &BenchCamerasArgs) -> Result<Self> {
        let mut simulation = configs::load::<HandConfig>(SCENES, &[])?.simulation;
        simulation.sequences = args.sequences;
        simulation.seconds = args.seconds;
        simulation.image_scale = 1.0;
        Ok(Self { checkpoint, simulation, seed: args.seed })
    }

    /// One sequence as the network sees it, and its true poses.
    fn sequence(&self, simulation: &Simulation, index: u64) -> Result<SeenSequence> {
        let config = simulation.config();
        let fov_deg = f64::from(config.camera.vertical_fov_deg);
        let calibration = Calibration::from_vertical_fov(config.image_size(), fov_deg);
        let mut adaptor = ViewAdaptor::new(&calibration, &canonical_view(&self.checkpoint.config));
        let size = adaptor.view().sensor;
        let (mut all, mut mapped) = (EventStream::empty(size), EventStream::empty(size));
        let mut simulator = simulation.sequence(index)?;
        let (mut truth, mut betas) = (Vec::new(), Vec::new());
        for _ in 0..config.frames() {
            let step = simulator.advance()?;
            truth.push(step.label);
            betas.clone_from(&step.episode.betas);
            adaptor.push(step.events, &mut mapped);
            for event in mapped.iter() {
                all.push(event).context("events in order")?;
            }
        }
        Ok(SeenSequence { events: all, truth, betas })
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
        let config = &self.checkpoint.config;
        let mut scenes = self.simulation.clone();
        scenes.sensor_size = sensor;
        let fov_deg = f64::from(scenes.camera.vertical_fov_deg);
        scenes.camera.vertical_fov_deg = covering_fov_deg(sensor, fov_deg) as f32;
        let simulation = Simulation::new(&scenes, self.seed)?;
        let progress = bar("simulating", scenes.sequences as u64, "sequences");
        let sequences = (0..scenes.sequences as u64)
            .into_par_iter()
            .map(|index| {
                let sequence = self.sequence(&simulation, index);
                progress.inc(1);
                sequence
            })
            .collect::<Result<Vec<_>>>()?;
        progress.finish_and_clear();
        let view = HandView::new(config)?;
        let side = config.simulation.hands.side(0);
        let mut predictor = self.checkpoint.predictor(Device::flex())?;
        let mut evaluation = HandEvaluation::default();
        for sequence in &sequences {
            let poses = poses_every_ms(config, &sequence.events, &mut predictor, &mut |_| {})?;
            let mut scores = SequenceScores::default();
            for pose in poses {
                let Some(truth) = sequence.truth.get((pose.t.0 / 1000) as usize) else { continue };
                let predicted = view.points(side, &pose.measured, &[]);
                scores.push_points(&predicted, &view.points(side, truth, &sequence.betas));
            }
            evaluation.sequences.push(scores);
        }
        let summary = evaluation.summary(&config.evaluation.bootstrap);
        Ok(summary.auc_2d.context("no pose was evaluated")?.estimate)
    }
}
