//! What the page is told, as JSON.

use evpose_core::{Micros, SensorSize};
use evpose_pose::body::{JOINT_NAMES, LIMBS};
use evpose_pose::{EVALUATION_JOINTS, HAND_BONES};
use glam::Vec2;
use serde::{Serialize, Serializer};

use super::plane::Cells;
use super::poses::Lane;
use super::rates::{Point, Rates, State};
use super::{HandMesh, PageInfo, Subject};
use crate::Report;
use evpose_pose::PoseEstimate;

/// The first message of every client: what is shown.
#[derive(Serialize)]
pub(super) struct About {
    kind: &'static str,
    title: String,
    source: String,
    sensor: SensorSize,
    /// Pixels of the sensor along a side of a cell of the picture.
    cell_px: u16,
    subject: &'static str,
    joints: &'static [&'static str],
    bones: &'static [[usize; 2]],
    faces: Option<Vec<[u32; 3]>>,
}

impl About {
    pub(super) fn new(info: &PageInfo) -> Self {
        let (subject, joints, bones): (_, &[_], &[_]) = match info.subject {
            Subject::Body => ("body", &JOINT_NAMES, &LIMBS),
            Subject::Hand => ("hand", &EVALUATION_JOINTS, &HAND_BONES),
        };
        Self {
            kind: "about",
            title: info.title.clone(),
            source: info.source.clone(),
            sensor: info.sensor,
            cell_px: Cells::of(info.sensor).side_px,
            subject,
            joints,
            bones,
            faces: info.hand_mesh.as_ref().map(|mesh| mesh.faces.clone()),
        }
    }

    pub(super) fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// With the figures of the last seconds.
    pub(super) fn with(&self, history: &[Point]) -> String {
        #[derive(Serialize)]
        struct Message<'a> {
            #[serde(flatten)]
            about: &'a About,
            history: &'a [Point],
        }
        text(&Message { about: self, history })
    }
}

/// The text of a frame.
#[derive(Serialize)]
pub(super) struct Words<'a> {
    pub(super) kind: &'static str,
    pub(super) state: State,
    /// Time of the newest event.
    pub(super) t_us: Option<i64>,
    pub(super) network: Option<Shown>,
    pub(super) between: Option<Shown>,
    pub(super) figures: &'a Figures,
}

/// Figures, new ten times a second.
#[derive(Serialize)]
pub(super) struct Figures {
    /// The latencies of the last second.
    pub(super) point: Point,
    /// The rates of the last second.
    pub(super) rates: Rates,
    /// All since the pipeline began.
    pub(super) report: Report,
}

/// A pose as it is drawn.
#[derive(Serialize)]
pub(super) struct Shown {
    t_us: i64,
    latency_ms: f64,
    /// Since it came.
    age_ms: f64,
    /// Of every joint pixels to the right and down.
    joints: Vec<Option<[Tenth; 2]>>,
    /// Of every joint how sure the network was, in tenths.
    #[serde(skip_serializing_if = "Option::is_none")]
    tenths: Option<Vec<Tenth>>,
    /// Of every vertex pixels to the right, down, and away from the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    vertices: Option<Vec<[Tenth; 3]>>,
}

impl Shown {
    /// The newest pose of `lane`.
    pub(super) fn newest(lane: &Lane) -> Option<(Self, PoseEstimate)> {
        let (pose, came) = lane.pose.as_ref()?;
        let Micros(t_us) = pose.t;
        let shown = Self {
            t_us,
            latency_ms: pose.latency.as_secs_f64() * 1e3,
            age_ms: came.elapsed().as_secs_f64() * 1e3,
            joints: Vec::new(),
            tenths: None,
            vertices: None,
        };
        Some((shown, pose.pose.clone()))
    }

    /// With what is drawn of `answer`.
    pub(super) fn drawn(mut self, answer: &PoseEstimate, mesh: Option<&mut HandMesh>) -> Self {
        match answer {
            PoseEstimate::Body { joints_px, scores } => {
                self.joints = joints_px.iter().map(joint).collect();
                self.tenths = Some(scores.iter().map(|score| Tenth(10.0 * score)).collect());
            }
            PoseEstimate::Hand { params, points } => {
                self.joints = points.image_px.iter().map(joint).collect();
                let vertices = mesh.and_then(|mesh| (mesh.vertices)(params));
                self.vertices = vertices
                    .filter(|all| all.iter().all(|v| v.is_finite()))
                    .map(|all| all.iter().map(|v| [Tenth(v.x), Tenth(v.y), Tenth(v.z)]).collect());
            }
        }
        self
    }
}

fn joint(at: &Option<Vec2>) -> Option<[Tenth; 2]> {
    at.filter(|at| at.is_finite()).map(|at| [Tenth(at.x), Tenth(at.y)])
}

/// A number that is told to a tenth.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tenth(f32);

impl Serialize for Tenth {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64((f64::from(self.0) * 10.0).round() / 10.0)
    }
}

/// A message as JSON.
pub(super) fn text(message: &impl Serialize) -> String {
    // Fields have names, and nothing here can fail.
    serde_json::to_string(message).unwrap_or_default()
}
