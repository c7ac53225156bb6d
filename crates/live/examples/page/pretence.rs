//! A source, an eye and a network that know the truth.

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

/// Events of so much time come together.
const PACKET: Micros = Micros(1_000);
/// The outline is looked at once in so many packets.
const LOOK: u64 = 8;
/// Places that are looked at for a packet, and events of noise in it.
const PLACES: usize = 2_500;
const NOISE: usize = 30;
/// How long the network takes, and what it is wrong by.
const THINKS: Duration = Duration::from_millis(9);
const WRONG_PX: f32 = 2.5;

pub(crate) struct PretendedSource {
    actor: Arc<dyn Actor>,
    began: Instant,
    packet: u64,
    end_s: f64,
    outline: Option<Outline>,
}

impl PretendedSource {
    pub(crate) fn new(actor: Arc<dyn Actor>, end_s: f64) -> Self {
        Self { actor, began: Instant::now(), packet: 0, end_s, outline: None }
    }
}

impl Source for PretendedSource {
    fn name(&self) -> String {
        "made up".to_owned()
    }

    fn sensor(&self) -> SensorSize {
        SENSOR
    }

    fn next(&mut self, columns: &mut Columns) -> Result<Option<Instant>, LiveError> {
        let part = self.packet % LOOK;
        self.packet += 1;
        let t = Micros(self.packet as i64 * PACKET.0);
        let due = self.began + Duration::from_secs_f64(t.as_seconds());
        if t.as_seconds() > self.end_s {
            return Ok(None);
        }
        let mut rng = CounterRng::new(1, "events", self.packet);
        let ahead = t + Micros(LOOK as i64 * PACKET.0);
        let outline = self.outline.take().filter(|_| part > 0);
        let outline = outline.unwrap_or_else(|| self.actor.outline(t, ahead));
        let mut push = |at: Vec2, polarity| {
            let size = Vec2::new(f32::from(SENSOR.width), f32::from(SENSOR.height));
            if at.cmpge(Vec2::ZERO).all() && at.cmplt(size).all() {
                columns.push(Event { t, x: at.x as u16, y: at.y as u16, polarity });
            }
        };
        for _ in 0..PLACES {
            let [before, now, out] = outline.draw(&mut rng);
            // The faster an edge moves across itself, the more of it is seen.
            let across_px = (now - before).dot(out);
            if across_px.abs() > 8.0 * rng.unit() {
                let passed = (part as f32 + rng.unit()) / LOOK as f32;
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

pub(crate) struct PretendedEye {
    actor: Arc<dyn Actor>,
    has_seen: bool,
}

impl PretendedEye {
    pub(crate) fn new(actor: Arc<dyn Actor>) -> Self {
        Self { actor, has_seen: false }
    }
}

impl StreamFrontend for PretendedEye {
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
        found: PoseEstimate,
        _: Micros,
    ) -> Vec<(Micros, PoseEstimate)> {
        self.has_seen = true;
        vec![(t, found)]
    }

    fn estimate(&self, pose: &PoseEstimate) -> PoseEstimate {
        pose.clone()
    }

    fn propagate(&mut self, t: Micros) -> Option<PoseEstimate> {
        self.has_seen.then(|| self.actor.pose(t))
    }

    fn reset(&mut self) {
        self.has_seen = false;
    }
}

pub(crate) struct PretendedNetwork {
    actor: Arc<dyn Actor>,
    looked: u64,
}

impl PretendedNetwork {
    pub(crate) fn new(actor: Arc<dyn Actor>) -> Self {
        Self { actor, looked: 0 }
    }
}

impl InferenceWorker for PretendedNetwork {
    type Input = Micros;
    type Output = PoseEstimate;

    fn infer(&mut self, image: &Micros) -> Result<PoseEstimate, StreamError> {
        self.looked += 1;
        let mut rng = CounterRng::new(2, "network", self.looked);
        std::thread::sleep(THINKS.mul_f32(rng.uniform(0.9, 1.3)));
        let mut answer = self.actor.pose(*image);
        let mut wrong = || WRONG_PX * Vec2::new(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
        match &mut answer {
            PoseEstimate::Body { joints_px, .. } => {
                joints_px.iter_mut().flatten().for_each(|at| *at += wrong());
            }
            PoseEstimate::Hand { points, .. } => {
                points.image_px.iter_mut().flatten().for_each(|at| *at += wrong());
            }
        }
        if let PoseEstimate::Body { scores, .. } = &mut answer {
            scores.iter_mut().for_each(|score| *score = rng.uniform(0.25, 1.0));
        }
        Ok(answer)
    }
}
