//! JSON messages to the page.

use evpose_core::{Micros, SensorSize};
use evpose_pose::body::{JOINT_NAMES, LIMBS};
use evpose_pose::{EVALUATION_JOINTS, HAND_BONES, PoseEstimate};
use glam::Vec2;
use serde::{Serialize, Serializer};

use super::event_counts::Cells;
use super::poses::OriginPoses;
use super::rates::{Point, Rates, State};
use super::{HandMesh, PageInfo, Skeleton};
use crate::Report;

/// First message to every client: a description of the stream.
#[derive(Serialize)]
pub(super) struct About {
    kind: &'static str,
    title: String,
    source: String,
    sensor: SensorSize,
    /// Side of a cell of the event image, in pixels of the sensor.
    cell_px: u16,
    skeleton: &'static str,
    joints: Vec<&'static str>,
    bones: &'static [[usize; 2]],
    faces: Option<Vec<[u32; 3]>>,
}

impl About {
    pub(super) fn new(info: &PageInfo) -> Self {
        let (skeleton, joints, bones): (_, _, &[_]) = match info.skeleton {
            Skeleton::Body => ("body", JOINT_NAMES.to_vec(), &LIMBS),
            Skeleton::Hand => ("hand", EVALUATION_JOINTS.to_vec(), &HAND_BONES),
            Skeleton::Points(layout) => {
                (layout.name, layout.points().map(|(name, _)| name).collect(), &[])
            }
        };
        Self {
            kind: "about",
            title: info.title.clone(),
            source: info.source.clone(),
            sensor: info.sensor,
            cell_px: Cells::for_sensor(info.sensor).side_px,
            skeleton,
            joints,
            bones,
            faces: info.hand_mesh.as_ref().map(|mesh| mesh.faces.clone()),
        }
    }

    pub(super) fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// The message with the measurements of the last seconds.
    pub(super) fn with(&self, history: &[Point]) -> String {
        #[derive(Serialize)]
        struct Message<'a> {
            #[serde(flatten)]
            about: &'a About,
            history: &'a [Point],
        }
        to_json(&Message { about: self, history })
    }
}

#[derive(Serialize)]
pub(super) struct FrameMessage<'a> {
    pub(super) kind: &'static str,
    pub(super) state: State,
    /// Time of the newest event.
    pub(super) t_us: Option<i64>,
    pub(super) network: Option<PoseMessage>,
    pub(super) propagated: Option<PoseMessage>,
    pub(super) figures: &'a Figures,
}

/// Measurements, updated ten times a second.
#[derive(Serialize)]
pub(super) struct Figures {
    /// Latencies of the last second.
    pub(super) point: Point,
    /// Rates of the last second.
    pub(super) rates: Rates,
    /// Counts since the pipeline began.
    pub(super) report: Report,
}

#[derive(Serialize)]
pub(super) struct PoseMessage {
    t_us: i64,
    latency_ms: f64,
    /// Time since it arrived.
    age_ms: f64,
    /// Pixel coordinates of every joint.
    joints: Vec<Option<[Tenth; 2]>>,
    /// Score of every joint, times ten.
    #[serde(skip_serializing_if = "Option::is_none")]
    tenths: Option<Vec<Tenth>>,
    /// Pixels of every vertex to the right, down, and away from the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    vertices: Option<Vec<[Tenth; 3]>>,
}

impl PoseMessage {
    pub(super) fn newest(poses: &OriginPoses) -> Option<(Self, PoseEstimate)> {
        let (pose, came) = poses.pose.as_ref()?;
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

    /// The message with the joints and vertices of `estimate`.
    pub(super) fn drawn(mut self, estimate: &PoseEstimate, mesh: Option<&mut HandMesh>) -> Self {
        match estimate {
            PoseEstimate::Body { joints_px, scores, .. } => {
                self.joints = joints_px.iter().map(joint).collect();
                self.tenths = Some(scores.iter().map(|score| Tenth(10.0 * score)).collect());
            }
            PoseEstimate::Values { layout, values } => {
                self.joints = layout.points_px(values).iter().map(joint).collect();
            }
            PoseEstimate::Hand { params, points, .. } => {
                self.joints = points.image_px.iter().map(joint).collect();
                let vertices = mesh.and_then(|mesh| (mesh.vertices)(params));
                self.vertices = vertices
                    // JSON has no word for what is not a number: the page keeps the mesh it has.
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

/// A value rounded to a tenth, which keeps messages short.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tenth(f32);

impl Serialize for Tenth {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64((f64::from(self.0) * 10.0).round() / 10.0)
    }
}

pub(super) fn to_json(message: &impl Serialize) -> String {
    // Serialising structs with string keys cannot fail.
    serde_json::to_string(message).unwrap_or_default()
}
