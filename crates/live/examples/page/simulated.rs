//! A source, a front end and a network that know the true pose.

use std::sync::Arc;
use std::time::{Duration, Instant};

use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::Columns;
use evpose_live::LiveError;
use evpose_live::source::Source;
use evpose_pose::PoseEstimate;
use evpose_pose::stream::InferenceWorker;
use evpose_pose::stream::StreamError;
use evpose_pose::stream::StreamFrontend;
use glam::Vec2;

use crate::actor::{Actor, Outline, SENSOR};

/// Event time of a packet.
const PACKET: Micros = Micros(1_000);
/// Packets from one computation of the outline to the next.
const PACKETS_PER_OUTLINE: u64 = 8;
/// Points of the outline drawn for a packet, and noise events in it.
const POINTS: usize = 2_500;
const NOISE: usize = 30;
/// Mean inference time, and error of the joints.
const INFERENCE_TIME: Duration = Duration::from_millis(9);
const ERROR_PX: f32 = 2.5;

pub(crate) struct SimulatedSource {
    actor: Arc<dyn Actor>,
    began: Instant,
    packet: u64,
    end_s: f64,
    outline: Option<Outline>,
}

impl SimulatedSource {
    pub(crate) fn new(actor: Arc<dyn Actor>, end_s: f64) -> Self {
        Self { actor, began: Instant::now(), packet: 0, end_s, outline: None }
    }
}

impl Source for SimulatedSource {
    fn name(&self) -> String {
        "simulated".to_owned()
    }

    fn sensor(&self) -> SensorSize {
        SENSOR
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        let part = self.packet % PACKETS_PER_OUTLINE;
        self.packet += 1;
        let t = Micros(self.packet as i64 * PACKET.0);
        let due = self.began + Duration::from_secs_f64(t.as_seconds());
        if t.as_seconds() > self.end_s {
            return Ok(None);
        }
        let mut rng = CounterRng::new(1, "events", self.packet);
        let ahead = t + Micros(PACKETS_PER_OUTLINE as i64 * PACKET.0);
        let outline = self.outline.take().filter(|_| part > 0);
        let outline = outline.unwrap_or_else(|| self.actor.outline(t, ahead));
        let mut push = |at: Vec2, polarity| {
            let size = Vec2::new(f32::from(SENSOR.width), f32::from(SENSOR.height));
            if at.cmpge(Vec2::ZERO).all() && at.cmplt(size).all() {
                columns.push(Event { t, x: at.x as u16, y: at.y as u16, polarity });
            }
        };
        for _ in 0..POINTS {
            let [before, now, out] = outline.draw(&mut rng);
            // The faster an edge moves along its normal, the more events it causes.
            let across_px = (now - before).dot(out);
            if across_px.abs() > 8.0 * rng.unit() {
                let passed = (part as f32 + rng.unit()) / PACKETS_PER_OUTLINE as f32;
                push(before.lerp(now, passed), Polarity::from_on(across_px > 0.0));
            }
        }
        for _ in 0..NOISE {
            let at = Vec2::new(rng.uniform(0.0, 640.0), rng.uniform(0.0, 480.0));
            push(at, Polarity::from_on(rng.unit() < 0.5));
        }
        self.outline = Some(outline);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        Ok(Some(due))
    }
}

pub(crate) struct SimulatedFrontend {
    actor: Arc<dyn Actor>,
    has_pose: bool,
}

impl SimulatedFrontend {
    pub(crate) fn new(actor: Arc<dyn Actor>) -> Self {
        Self { actor, has_pose: false }
    }
}

impl StreamFrontend for SimulatedFrontend {
    type Input = Micros;
    type Output = PoseEstimate;
    type Pose = PoseEstimate;

    fn push(&mut self, _: &EventStream) -> Result<(), StreamError> {
        Ok(())
    }

    fn input(&mut self, t: Micros, _: Option<Micros>) -> Option<Micros> {
        Some(t)
    }

    fn accept(
        &mut self,
        t: Micros,
        _: &Micros,
        pose: PoseEstimate,
        _: Micros,
    ) -> Vec<(Micros, PoseEstimate)> {
        self.has_pose = true;
        vec![(t, pose)]
    }

    fn estimate(&self, pose: &PoseEstimate) -> PoseEstimate {
        pose.clone()
    }

    fn propagate(&mut self, t: Micros) -> Option<PoseEstimate> {
        self.has_pose.then(|| self.actor.pose(t))
    }

    fn reset(&mut self) {
        self.has_pose = false;
    }
}

pub(crate) struct SimulatedNetwork {
    actor: Arc<dyn Actor>,
    inferences: u64,
}

impl SimulatedNetwork {
    pub(crate) fn new(actor: Arc<dyn Actor>) -> Self {
        Self { actor, inferences: 0 }
    }
}

impl InferenceWorker for SimulatedNetwork {
    type Input = Micros;
    type Output = PoseEstimate;

    fn infer(&mut self, image: &Micros) -> Result<PoseEstimate, StreamError> {
        self.inferences += 1;
        let mut rng = CounterRng::new(2, "network", self.inferences);
        std::thread::sleep(INFERENCE_TIME.mul_f32(rng.uniform(0.9, 1.3)));
        let mut estimate = self.actor.pose(*image);
        let mut error = || ERROR_PX * Vec2::new(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
        match &mut estimate {
            PoseEstimate::Body { joints_px, .. } => {
                joints_px.iter_mut().flatten().for_each(|at| *at += error());
            }
            PoseEstimate::Hand { points, .. } => {
                points.image_px.iter_mut().flatten().for_each(|at| *at += error());
            }
        }
        if let PoseEstimate::Body { scores, .. } = &mut estimate {
            scores.iter_mut().for_each(|score| *score = rng.uniform(0.25, 1.0));
        }
        Ok(estimate)
    }
}
