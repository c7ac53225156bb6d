//! Poses as JSON, with the names of the table's columns: an array, or JSON Lines.
//!
//! An object a line: `t_us`, `origin`, `latency_ms`, `score`, and `frame` and `params` of hands as in
//! the table, `values` of other tasks, `joints` an object by name with `u_px`, `v_px`, `score`, `x_m`, `y_m`, `z_m`. What has no
//! value is left out, and so is a joint without a position.

use std::fmt::Write as _;
use std::path::Path;

use evpose_core::Micros;
use evpose_pose::{HandParams, JointFrame, PARAMETER_NAMES, PARAMETERS, PoseLayout, PoseOrigin};
use glam::{Vec2, Vec3};
use serde_json::{Map, Value};

use super::format::{PoseFormat, RowFault, row_fault, write_lines};
use super::{PoseJoint, PoseKind, PoseSequence, TimedPose};
use crate::IoError;

/// The format of a file that is one JSON value.
pub(super) static ARRAY: PoseFormat = PoseFormat {
    name: "json",
    summary: "a JSON array of objects with the names of the table",
    endings: &["json"],
    detect: |start| start.trim_ascii_start().starts_with(b"["),
    read,
    write: Some(|path, kind, frame, poses| {
        let mut is_first = true;
        let objects = poses.map(|pose| {
            let line = line_of(kind, frame, &pose);
            let separator = if std::mem::take(&mut is_first) { "" } else { ",\n" };
            format!("{separator}{}", line.trim_end())
        });
        let ends = ["[\n", "\n]\n"].map(|end| std::iter::once(end.to_owned()));
        let [begin, end] = ends;
        write_lines(path, begin.chain(objects).chain(end))
    }),
};

/// The format with an object a line.
pub(super) static LINES: PoseFormat = PoseFormat {
    name: "jsonl",
    summary: "JSON Lines of the same objects",
    endings: &["jsonl", "ndjson"],
    detect: |start| start.trim_ascii_start().starts_with(b"{"),
    read,
    write: Some(|path, kind, frame, poses| {
        write_lines(path, poses.map(|pose| line_of(kind, frame, &pose)))
    }),
};

/// A pose as a line of JSON, with its end. Positions in metres are in the camera's frame.
pub fn json_line(kind: PoseKind, pose: &TimedPose) -> String {
    line_of(kind, None, pose)
}

fn line_of(kind: PoseKind, frame: Option<JointFrame>, pose: &TimedPose) -> String {
    let mut line = format!("{{\"t_us\":{}", pose.t.0);
    if let Some(origin) = pose.origin {
        let _ = write!(line, ",\"origin\":\"{}\"", origin.name());
    }
    let mut value = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            let _ = write!(line, ",\"{name}\":{value}");
        }
    };
    value("latency_ms", pose.latency_ms.map(|ms| rounded(ms, 3)));
    value("score", pose.score.filter(|s| s.is_finite()).map(|s| rounded(s.into(), 4)));
    // A hand whose frame is not stated is in the camera's, as every estimate of one is.
    let of_hands = (kind == PoseKind::Hand).then_some(JointFrame::Camera);
    value("frame", frame.or(of_hands).map(|frame| format!("\"{}\"", frame.name())));
    // JSON has no infinity and no NaN.
    let params = pose.params.map(HandParams::to_array).filter(|v| v.iter().all(|v| v.is_finite()));
    value(
        "params",
        params.map(|values| {
            let pairs = PARAMETER_NAMES.iter().zip(values);
            object(pairs.map(|(name, value)| (*name, value.to_string())))
        }),
    );
    let values = kind.value_names().iter().enumerate().filter_map(|(k, name)| {
        // The names show the kind of a row without values, too.
        let text = pose.values.as_ref().map_or(Some("null".to_owned()), |values| {
            values[k].is_finite().then(|| values[k].to_string())
        });
        Some((*name, text?))
    });
    let values = object(values);
    value("values", matches!(kind, PoseKind::Values(_)).then_some(values));
    let joints = kind.joint_names().iter().zip(&pose.joints);
    let joints = joints.filter_map(|(name, joint)| Some((*name, json_joint(joint)?)));
    value("joints", Some(object(joints)));
    line + "}\n"
}

/// A joint; none without a position.
fn json_joint(joint: &PoseJoint) -> Option<String> {
    let at_px = joint.image_px.filter(|at| at.is_finite());
    let at_m = joint.position_m.filter(|at| at.is_finite());
    (at_px.is_some() || at_m.is_some()).then(|| {
        let px = at_px.into_iter().flat_map(|at| [("u_px", at.x), ("v_px", at.y)]);
        let score = joint.score.filter(|score| score.is_finite());
        let m = at_m.into_iter().flat_map(|at| [("x_m", at.x), ("y_m", at.y), ("z_m", at.z)]);
        let px = px.map(|(name, value)| (name, rounded(value.into(), 3)));
        let score = score.map(|score| ("score", rounded(score.into(), 4)));
        object(px.chain(score).chain(m.map(|(name, value)| (name, rounded(value.into(), 5)))))
    })
}

fn object<'a>(entries: impl Iterator<Item = (&'a str, String)>) -> String {
    let entries: Vec<String> = entries.map(|(name, value)| format!("\"{name}\":{value}")).collect();
    format!("{{{}}}", entries.join(","))
}

/// A value with so many decimals, without zeros at its end.
fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Reads objects one after the other, whatever lies between them in an array or in lines.
fn read(path: &Path, bytes: &[u8]) -> Result<PoseSequence, IoError> {
    let mut sequence: Option<PoseSequence> = None;
    let (mut byte, mut number) = (0, 1);
    let is_between = |byte: &u8| byte.is_ascii_whitespace() || b",[]".contains(byte);
    loop {
        let skipped = bytes[byte..].iter().take_while(|byte| is_between(byte)).count();
        number += lines_in(&bytes[byte..byte + skipped]);
        byte += skipped;
        let mut objects = serde_json::Deserializer::from_slice(&bytes[byte..]).into_iter();
        let Some(value) = objects.next() else { break };
        let rows = sequence.as_ref().map_or(0, |sequence| sequence.poses.len());
        let fault = |reason: String| row_fault(path, number, byte as u64, reason, rows);
        let value: Map<String, Value> = value.map_err(|error| fault(error.to_string()))?;
        // Where an object does not show its kind, that of those before gives a better message.
        let known = sequence.as_ref().map(|sequence| sequence.kind);
        let kind = kind_of(&value, known).or(known);
        // A file is of persons or of hands, not of both.
        let kind = kind.filter(|kind| known.is_none_or(|known| known == *kind));
        let kind = kind.ok_or_else(|| fault("neither of a person nor of a hand".to_owned()))?;
        let pose = pose_of(&value, kind).map_err(|e| fault(e.to_string()))?;
        let sequence =
            sequence.get_or_insert_with(|| PoseSequence { frame: None, ..PoseSequence::new(kind) });
        let frame = value.get("frame").and_then(Value::as_str);
        sequence.frame = JointFrame::ALL.into_iter().find(|known| Some(known.name()) == frame);
        sequence.poses.push(pose);
        let end = byte + objects.byte_offset();
        number += lines_in(&bytes[byte..end]);
        byte = end;
    }
    let sequence = sequence.ok_or_else(|| row_fault(path, 1, 0, "no poses".to_owned(), 0))?;
    // Unlike lines, an array shows where it was cut between two objects.
    let text = bytes.trim_ascii();
    if text.starts_with(b"[") && !text.ends_with(b"]") {
        let reason = "the array has no end: the file is cut".to_owned();
        return Err(row_fault(path, number, byte as u64, reason, sequence.poses.len()));
    }
    Ok(sequence)
}

/// Ends of lines.
fn lines_in(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|byte| **byte == b'\n').count() as u64
}

/// The kind that a line shows. One without joints is of the lines before, or else of a hand if it has the
/// frame of those, and of a body.
fn kind_of(line: &Map<String, Value>, known: Option<PoseKind>) -> Option<PoseKind> {
    if line.contains_key("params") {
        return Some(PoseKind::Hand);
    }
    if let Some(values) = line.get("values") {
        return PoseLayout::of_names(|name| values.get(name).is_some()).map(PoseKind::Values);
    }
    let joints = line.get("joints")?.as_object()?;
    match joints.keys().next() {
        Some(name) => [PoseKind::Body, PoseKind::Hand]
            .into_iter()
            .find(|kind| kind.joint_names().contains(&name.as_str())),
        // Nobody is in view.
        None => {
            let camera = Some(JointFrame::Camera.name());
            let is_hand = line.get("frame").and_then(Value::as_str) == camera;
            known.or(Some(if is_hand { PoseKind::Hand } else { PoseKind::Body }))
        }
    }
}

fn pose_of(line: &Map<String, Value>, kind: PoseKind) -> Result<TimedPose, RowFault> {
    let t_us = line.get("t_us").and_then(Value::as_i64).ok_or(RowFault::NoWholeTime)?;
    let mut pose = TimedPose::empty(kind, Micros(t_us));
    let origin = line.get("origin").and_then(Value::as_str);
    pose.origin = PoseOrigin::ALL.into_iter().find(|known| Some(known.name()) == origin);
    pose.latency_ms = line.get("latency_ms").and_then(Value::as_f64);
    pose.score = line.get("score").and_then(Value::as_f64).map(|score| score as f32);
    pose.params = line.get("params").map(params_of).transpose()?;
    if let Some(values) = line.get("values") {
        let number = |name: &&str| Some(values.get(name)?.as_f64()? as f32);
        pose.values = kind.value_names().iter().map(number).collect();
    }
    let joints = line.get("joints").and_then(Value::as_object).ok_or(RowFault::NoJoints)?;
    for (name, value) in joints {
        let index = kind.joint_names().iter().position(|known| known == name);
        let index = index.ok_or_else(|| RowFault::NoJoint(name.clone(), kind))?;
        pose.joints[index] = joint_of(value).ok_or_else(|| RowFault::NoObject(name.clone()))?;
    }
    Ok(pose)
}

fn joint_of(value: &Value) -> Option<PoseJoint> {
    let value = value.as_object()?;
    let of = |name: &str| value.get(name).and_then(Value::as_f64).map(|value| value as f32);
    let position_m = of("x_m").zip(of("y_m")).zip(of("z_m"));
    Some(PoseJoint {
        image_px: of("u_px").zip(of("v_px")).map(|(u, v)| Vec2::new(u, v)),
        score: of("score"),
        position_m: position_m.map(|((x, y), z)| Vec3::new(x, y, z)),
    })
}

fn params_of(value: &Value) -> Result<HandParams, RowFault> {
    let mut values = [0.0; PARAMETERS];
    for (parameter, name) in values.iter_mut().zip(PARAMETER_NAMES) {
        let read = value.get(name).and_then(Value::as_f64);
        *parameter = read.ok_or(RowFault::NoParameter(name))?;
    }
    Ok(HandParams::from_f64(values))
}
