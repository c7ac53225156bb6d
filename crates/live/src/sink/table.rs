//! Poses as a CSV table.

use std::fmt::Write as _;
use std::io::{self, Write};

use evpose_pose::EVALUATION_JOINTS;
use evpose_pose::body::JOINT_NAMES;

use super::Sink;
use crate::{LivePose, PoseOrigin};
use evpose_pose::PoseEstimate;

/// First columns of every table.
const COMMON_COLUMNS: &str = "t_us,origin,latency_us";

/// Writes a line for every pose: its time stamp, `network` or `propagated`, its latency, and for a
/// body 13 joints in pixels, for a hand 21 joints in pixels and 12 parameters. Unknown values are
/// empty.
pub struct PoseCsv<W> {
    name: String,
    out: W,
    is_begun: bool,
    line: String,
}

impl<W: Write> PoseCsv<W> {
    /// Writes to `out`; `name` identifies it in messages.
    pub fn new(name: impl Into<String>, out: W) -> Self {
        Self { name: name.into(), out, is_begun: false, line: String::new() }
    }
}

impl<W: Write + Send + 'static> Sink for PoseCsv<W> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        let line = &mut self.line;
        line.clear();
        if !std::mem::replace(&mut self.is_begun, true) {
            header(line, &pose.pose);
        }
        let origin = match pose.origin {
            PoseOrigin::Network => "network",
            PoseOrigin::Propagated => "propagated",
        };
        let _ = write!(line, "{},{origin},{}", pose.t.0, pose.latency.as_micros());
        let mut pixels = |at: &Option<glam::Vec2>| {
            let _ = match at {
                Some(at) => write!(line, ",{:.2},{:.2}", at.x, at.y),
                None => write!(line, ",,"),
            };
        };
        match &pose.pose {
            PoseEstimate::Body { joints_px, .. } => joints_px.iter().for_each(pixels),
            PoseEstimate::Hand { params, points } => {
                points.image_px.iter().for_each(&mut pixels);
                params.to_array().iter().for_each(|value| {
                    let _ = write!(line, ",{value}");
                });
            }
        }
        line.push('\n');
        self.out.write_all(line.as_bytes())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

fn header(line: &mut String, pose: &PoseEstimate) {
    line.push_str(COMMON_COLUMNS);
    let names: &[&str] = match pose {
        PoseEstimate::Body { .. } => &JOINT_NAMES,
        PoseEstimate::Hand { .. } => &EVALUATION_JOINTS,
    };
    for name in names {
        let _ = write!(line, ",{name}_u_px,{name}_v_px");
    }
    if matches!(pose, PoseEstimate::Hand { .. }) {
        (1..=12).for_each(|k| {
            let _ = write!(line, ",parameter_{k}");
        });
    }
    line.push('\n');
}
