//! Hands online: the newest surfaces for the network, and a filter that knows poses in between.
//!
//! # Model
//! A surface is due when time has passed and events have come. A network that takes one surface is shown the
//! newest whenever it is free; one that takes a batch is shown the newest batch that is full. Surfaces of a
//! scene at rest are not looked at: the last answer stands. Answers go through the filter of the slow-motion
//! mode, with its two settings, at the times of their surfaces; poses between them are where the filter says
//! that the hand goes on to.
//!
//! # Source
//! EventHands, live pipeline; there the filter's poses come with those of the network alone.

use evpose_body::PosedBody;
use evpose_core::{EventStream, Micros, SensorSize};
use evpose_pose::filter::{AdaptiveHandFilter, StillnessGate};
use evpose_pose::{HandParams, HandSide};
use evpose_repr::{Representation, StreamWindow, SurfaceTrigger, representation_called};
use evpose_train::{HandConfig, Predictor, Stage, SurfaceBatch};

use crate::body::failed;
use crate::page::HandMesh;
use crate::{Answer, Eye, LiveError, Network, Task};

/// A network of hands before events of `sensor`, shown `batch` surfaces at once.
///
/// # Errors
/// If the representation is not known, the hand cannot be made, or a setting is out of range.
pub fn hand_task<P: Predictor + Send>(
    config: &HandConfig,
    predictor: P,
    sensor: SensorSize,
    batch: usize,
) -> Result<Task<HandEye, HandNetwork<P>>, LiveError> {
    let mode = &config.slow_motion;
    let length = Micros(i64::from(config.representation.window_ms) * 1_000);
    let window = StreamWindow::new(sensor, length, config.representation.channel_order);
    let surface = representation_called(&config.representation.name).map_err(failed)?;
    let eye = HandEye {
        sensor,
        surface: surface.start(window.map_err(failed)?),
        trigger: SurfaceTrigger::new(&mode.trigger, sensor),
        is_due: false,
        gate: StillnessGate::new(&mode.stillness, sensor).map_err(failed)?,
        filter: AdaptiveHandFilter::new(&mode.filter).map_err(failed)?,
        stage: Stage::new(config).map_err(failed)?,
        // A network of both hands does not say which it saw.
        side: config.simulation.hands.side(0),
        batch: batch.max(1),
        gathered: SurfaceBatch::default(),
    };
    let size = (usize::from(sensor.height), usize::from(sensor.width));
    let mut network = HandNetwork { predictor, size };
    // What is compiled for the first images is not for the first pose to wait for.
    network.look(&SurfaceBatch::empty_surfaces(sensor, eye.batch))?;
    Ok(Task { eye, network })
}

/// The surface of the hand of `config`, for a page.
///
/// # Errors
/// If the file of its model cannot be read.
pub fn hand_mesh(config: &HandConfig) -> Result<HandMesh, LiveError> {
    let (stage, side) = (Stage::new(config).map_err(failed)?, config.simulation.hands.side(0));
    let faces = stage.faces(side).to_vec();
    let mut memory = PosedBody::default();
    let vertices = move |params: &HandParams| stage.vertices_px(side, params, &mut memory);
    Ok(HandMesh { faces, vertices: Box::new(vertices) })
}

/// Follows the events of a hand.
#[derive(Debug)]
pub struct HandEye {
    sensor: SensorSize,
    surface: Box<dyn Representation>,
    trigger: SurfaceTrigger,
    is_due: bool,
    gate: StillnessGate,
    filter: AdaptiveHandFilter,
    stage: Stage,
    side: HandSide,
    batch: usize,
    /// Surfaces of the batch that is not full yet.
    gathered: SurfaceBatch,
}

impl HandEye {
    fn answer(&self, params: HandParams) -> Answer {
        Answer::Hand { params, points: Box::new(self.stage.points(self.side, &params, &[])) }
    }

    /// Adds the surface of `t`.
    fn gather(&mut self, t: Micros) {
        self.surface.advance(t);
        self.gathered.add(&mut *self.surface, self.sensor, t);
    }
}

impl Eye for HandEye {
    type Image = SurfaceBatch;
    type Found = Vec<HandParams>;

    fn push(&mut self, events: &EventStream) -> Result<(), LiveError> {
        self.surface.push(events);
        let mut from = 0;
        while let Some(taken) = self.trigger.due(&events.t()[from..]) {
            from += taken;
            self.is_due = true;
        }
        Ok(())
    }

    fn stride(&mut self, t: Micros) {
        if self.batch > 1 && std::mem::take(&mut self.is_due) {
            if self.gathered.len() == self.batch {
                // Nobody had time for it.
                self.gathered.clear();
            }
            self.gather(t);
        }
    }

    fn image(&mut self, t: Micros, memory: Option<SurfaceBatch>) -> Option<SurfaceBatch> {
        if self.batch == 1 {
            if !std::mem::take(&mut self.is_due) {
                return None;
            }
            self.gathered.clear();
            self.gather(t);
        }
        if self.gathered.len() < self.batch {
            return None;
        }
        if self.gate.is_at_rest(self.gathered.values(), self.gathered.len()) {
            let poses = self.gate.repeat(self.gathered.len());
            for (&t, measured) in self.gathered.times().iter().zip(poses) {
                self.filter.update(t, measured);
            }
            self.gathered.clear();
            return None;
        }
        let mut next = memory.unwrap_or_default();
        next.clear();
        Some(std::mem::replace(&mut self.gathered, next))
    }

    fn found(
        &mut self,
        _t: Micros,
        surfaces: &SurfaceBatch,
        found: Vec<HandParams>,
        _now: Micros,
    ) -> Vec<(Micros, Answer)> {
        let poses = surfaces.times().iter().zip(&found);
        let answers = poses.map(|(&t, measured)| {
            let filtered = self.filter.update(t, measured);
            (t, self.answer(filtered))
        });
        let answers = answers.collect();
        self.gate.predicted(found);
        answers
    }

    fn between(&mut self, t: Micros) -> Option<Answer> {
        Some(self.answer(self.filter.at(t)?))
    }

    fn reset(&mut self) {
        self.surface.reset();
        self.trigger.reset();
        self.filter.reset();
        self.gathered.clear();
        self.gate.reset();
        self.is_due = false;
    }
}

/// Predicts poses from surfaces.
pub struct HandNetwork<P> {
    predictor: P,
    /// Height and width.
    size: (usize, usize),
}

impl<P: Predictor + Send> Network for HandNetwork<P> {
    type Image = SurfaceBatch;
    type Found = Vec<HandParams>;

    fn look(&mut self, surfaces: &SurfaceBatch) -> Result<Vec<HandParams>, LiveError> {
        self.predictor.predict(surfaces.values(), self.size).map_err(failed)
    }
}
