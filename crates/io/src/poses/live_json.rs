//! JSON Lines of `evpose live` of earlier versions: `[u, v, score]` for a joint of a person, `{"m": …,
//! "px": …}` in the world's frame for one of a hand, whose `params` are an array. Only read.

use std::path::Path;

use evpose_pose::{HandParams, JointFrame, PARAMETERS};
use glam::{Vec2, Vec3};
use serde_json::Value;

use super::format::PoseFormat;
use super::{PoseJoint, PoseKind, PoseSequence, json};
use crate::IoError;

/// The format.
pub(super) static FORMAT: PoseFormat = PoseFormat {
    name: "live-json",
    summary: "JSON Lines of `evpose live` of earlier versions",
    // Only these have arrays.
    detect: |start| start.trim_ascii_start().starts_with(b"{") && start.contains(&b'['),
    read,
    write: None,
};

fn read(path: &Path, bytes: &[u8]) -> Result<PoseSequence, IoError> {
    let sequence = json::read(path, bytes, joint_of, params_of)?;
    let frame = (sequence.kind == PoseKind::Hand).then_some(JointFrame::World);
    Ok(PoseSequence { frame, ..sequence })
}

fn joint_of(value: &Value) -> Result<PoseJoint, String> {
    if value.is_array() {
        let [u, v, score] = values(value)?;
        let image_px = Some(Vec2::new(u, v));
        return Ok(PoseJoint { image_px, score: Some(score), position_m: None });
    }
    let px = value.get("px").filter(|px| !px.is_null()).map(values).transpose()?;
    let m = value.get("m").map(values).transpose()?;
    let position_m = m.map(Vec3::from_array);
    Ok(PoseJoint { image_px: px.map(Vec2::from_array), score: None, position_m })
}

fn params_of(value: &Value) -> Result<HandParams, String> {
    Ok(HandParams::from_array(values::<PARAMETERS>(value)?))
}

fn values<const N: usize>(value: &Value) -> Result<[f32; N], String> {
    let cells = value.as_array().map(|cells| cells.iter().map(Value::as_f64));
    let read: Option<Vec<f64>> = cells.and_then(Iterator::collect);
    let read: Result<[f64; N], _> = read.unwrap_or_default().try_into();
    Ok(read.map_err(|_| format!("{N} values were expected"))?.map(|value| value as f32))
}
