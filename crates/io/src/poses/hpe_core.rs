//! hpe-core's table of a person: see `predictions`. Seconds, no header, no
//! scores.

use std::path::Path;

use evpose_core::Micros;
use evpose_pose::JointFrame;
use evpose_pose::metric::body::BodyPrediction;

use super::format::{PoseFormat, PoseIterator};
use super::{PoseKind, PoseSequence, TimedPose};
use crate::predictions::{PredictionWriter, predictions_of};
use crate::{Input, IoError};

/// The format.
pub(super) static FORMAT: PoseFormat = PoseFormat {
    name: "hpe-core",
    summary: "hpe-core's table of a person: t delay x0 y0 … in seconds and pixels, without a header",
    endings: &[],
    detect: |start| {
        let mut line = start.iter().take_while(|byte| **byte != b'\n');
        start.starts_with(b"#")
            || line.all(|byte| byte.is_ascii_digit() || b" \t\r,.+-eE".contains(byte))
    },
    read,
    write: Some(write),
};

fn read(path: &Path, bytes: &[u8]) -> Result<PoseSequence, IoError> {
    let mut sequence = PoseSequence::new(PoseKind::Body);
    for row in predictions_of(Input::memory(path, bytes.to_vec()))? {
        let mut pose = TimedPose::empty(PoseKind::Body, Micros::from_seconds(row.t_s));
        pose.latency_ms = Some(1e3 * row.delay_s);
        for (joint, at) in pose.joints.iter_mut().zip(row.joints_px) {
            joint.image_px = at;
        }
        sequence.poses.push(pose);
    }
    Ok(sequence)
}

fn write(
    path: &Path,
    kind: PoseKind,
    _: Option<JointFrame>,
    poses: PoseIterator<'_>,
) -> Result<(), IoError> {
    if kind != PoseKind::Body {
        return Err(IoError::unwritable(
            path,
            format!("hpe-core has no table of {}", kind.subject()),
        ));
    }
    let mut writer = PredictionWriter::create(path)?;
    for pose in poses {
        writer.write(&BodyPrediction {
            t_s: pose.t.as_seconds(),
            delay_s: 1e-3 * pose.latency_ms.unwrap_or(0.0),
            joints_px: pose.body_px(),
        })?;
    }
    writer.finish()
}
