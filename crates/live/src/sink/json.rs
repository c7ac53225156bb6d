//! Poses as JSON Lines, to a file, a pipe or a socket.

use std::io::{self, Write};

use evpose_pose::EVALUATION_JOINTS;
use evpose_pose::body::JOINT_NAMES;
use serde_json::{Map, Value, json};

use super::Sink;
use crate::{LivePose, PoseOrigin};
use evpose_pose::PoseEstimate;

/// Writes a line for every pose: `t_us`, `origin` (`network` or `propagated`), `latency_ms`, and
///
/// * for a body, `joints`: pixels and score of each detected joint;
/// * for a hand, `params`, its 12 parameters, and `joints`: metres and pixels of each of its 21
///   points, the latter null behind the camera.
pub struct JsonLines<W> {
    name: String,
    out: W,
}

impl<W: Write> JsonLines<W> {
    /// Writes to `out`; `name` identifies it in messages.
    pub fn new(name: impl Into<String>, out: W) -> Self {
        Self { name: name.into(), out }
    }
}

impl<W: Write + Send + 'static> Sink for JsonLines<W> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        serde_json::to_writer(&mut self.out, &value(pose))?;
        self.out.write_all(b"\n")
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// A pose as JSON.
pub fn value(pose: &LivePose) -> Value {
    let origin = match pose.origin {
        PoseOrigin::Network => "network",
        PoseOrigin::Propagated => "propagated",
    };
    let latency_ms = pose.latency.as_micros() as f64 * 1e-3;
    let mut line = json!({ "t_us": pose.t.0, "origin": origin, "latency_ms": latency_ms });
    let mut joints = Map::new();
    match &pose.pose {
        PoseEstimate::Body { joints_px, scores } => {
            for ((name, at), score) in JOINT_NAMES.iter().zip(joints_px).zip(scores) {
                if let Some(at) = at {
                    joints.insert((*name).to_owned(), json!([at.x, at.y, score]));
                }
            }
        }
        PoseEstimate::Hand { params, points } => {
            line["params"] = json!(params.to_array());
            let points = points.world_m.iter().zip(&points.image_px);
            for (name, (m, px)) in EVALUATION_JOINTS.iter().zip(points) {
                let px = px.map(|px| json!([px.x, px.y]));
                joints.insert((*name).to_owned(), json!({ "m": [m.x, m.y, m.z], "px": px }));
            }
        }
    }
    line["joints"] = Value::Object(joints);
    line
}
