//! Tables of poses with a header: the columns of [`PoseColumns`], by name.
//!
//! Tables of labels (`.poses.csv`, `.joints.csv`), of `evpose infer` and of `evpose live` differ in the
//! columns that they have.

use std::path::Path;

use evpose_core::{Micros, bytes_without_bom};
use evpose_pose::{HandParams, JointFrame, PARAMETER_NAMES, PoseLayout, PoseOrigin};
use glam::{Vec2, Vec3};

use super::columns::{METRES, PIXELS, SCORE};
use super::format::{PoseFormat, RowFault, row_fault};
use super::{PoseColumns, PoseJoint, PoseKind, PoseSequence, TimedPose};
use crate::IoError;

/// The format.
pub(super) static FORMAT: PoseFormat = PoseFormat {
    name: "table",
    summary: "CSV with a header: t_us, score, JOINT_u_px, JOINT_v_px, …",
    endings: &["csv"],
    detect: |start| {
        let header = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let header = String::from_utf8_lossy(header);
        let mut names = header.split(',');
        names.any(|name| name.trim().trim_matches('"') == "t_us")
    },
    read,
    write: Some(|path, kind, frame, poses| PoseColumns::of_frame(kind, frame).write(path, poses)),
};

/// Reads a table with a header.
///
/// # Errors
/// If it cannot be read, a column is missing or of no joint, or a cell is not a value.
pub fn read_pose_table(path: &Path) -> Result<PoseSequence, IoError> {
    let bytes = std::fs::read(path).map_err(|source| IoError::file(path, "read", source))?;
    read(path, bytes_without_bom(&bytes))
}

/// Indices of columns.
struct Columns {
    kind: PoseKind,
    t: usize,
    origin: Option<usize>,
    latency_ms: Option<usize>,
    score: Option<usize>,
    frame: Option<usize>,
    params: Option<[usize; PARAMETER_NAMES.len()]>,
    values: Vec<usize>,
    joints: Vec<JointColumns>,
    count: usize,
}

#[derive(Default, Clone)]
struct JointColumns {
    image_px: Option<[usize; 2]>,
    score: Option<usize>,
    position_m: Option<[usize; 3]>,
}

impl Columns {
    fn of(names: &[&str]) -> Result<Self, RowFault> {
        // Of two columns with one name, the second would never be read.
        for (index, name) in names.iter().enumerate() {
            if names[..index].contains(name) {
                return Err(RowFault::Twice((*name).to_owned()));
            }
        }
        let at = |name: &str| names.iter().position(|known| *known == name);
        let kinds = [PoseKind::Body, PoseKind::Hand];
        let is_of = |kind: &PoseKind| names.iter().any(|name| joint_of(*kind, name).is_some());
        let params = together(names, "", PARAMETER_NAMES)?;
        // A table of parameters alone is one of hands: bodies have none.
        let kind = kinds.into_iter().find(is_of).or(params.map(|_| PoseKind::Hand));
        let own = || PoseLayout::of_names(|name| names.contains(&name)).map(PoseKind::Values);
        let kind = kind.or_else(own);
        let kind = kind.ok_or(RowFault::NoPose)?;
        let coordinates = || PIXELS.iter().chain(&METRES);
        let is_coordinate = |name: &str| coordinates().any(|suffix| name.ends_with(suffix));
        let values = kind.value_names();
        let is_value = |name: &str| PARAMETER_NAMES.contains(&name) || values.contains(&name);
        // A misspelt joint is an error; columns of other meanings are left alone.
        let mut unknown = names.iter().filter(|name| is_coordinate(name) && !is_value(name));
        if let Some(name) = unknown.find(|name| joint_of(kind, name).is_none()) {
            return Err(RowFault::NoSuchJoint { name: (*name).to_owned(), kind });
        }
        let joint = |joint: &&str| {
            Ok(JointColumns {
                image_px: together(names, joint, PIXELS)?,
                score: at(&format!("{joint}{SCORE}")),
                position_m: together(names, joint, METRES)?,
            })
        };
        let joints = kind.joint_names().iter().map(joint).collect::<Result<_, RowFault>>()?;
        Ok(Self {
            kind,
            t: at("t_us").ok_or_else(|| RowFault::NoColumn("t_us".to_owned()))?,
            origin: at("origin"),
            latency_ms: at("latency_ms"),
            score: at("score"),
            frame: at("frame"),
            params,
            values: values.iter().filter_map(|name| at(name)).collect(),
            joints,
            count: names.len(),
        })
    }

    fn pose(&self, cells: &[&str]) -> Result<TimedPose, RowFault> {
        if cells.len() != self.count {
            return Err(RowFault::Columns { count: cells.len(), expected: self.count });
        }
        let t = cells[self.t].parse();
        let t = t.map_err(|_| RowFault::NoTime(cells[self.t].to_owned()))?;
        let mut pose = TimedPose::empty(self.kind, Micros(t));
        let name = self.origin.map(|column| cells[column]);
        pose.origin = PoseOrigin::ALL.into_iter().find(|known| Some(known.name()) == name);
        pose.latency_ms = self.latency_ms.map_or(Ok(None), |column| value(cells[column]))?;
        pose.score = self.score.map_or(Ok(None), |column| narrow(cells[column]))?;
        if let Some(columns) = self.params {
            let values = all(cells, columns)?;
            pose.params = values.map(HandParams::from_array);
        }
        if !self.values.is_empty() {
            let values = self.values.iter().map(|column| narrow(cells[*column]));
            pose.values = values.collect::<Result<Option<_>, RowFault>>()?;
        }
        for (joint, columns) in pose.joints.iter_mut().zip(&self.joints) {
            *joint = PoseJoint {
                image_px: columns.image_px.map_or(Ok(None), |at| all(cells, at))?.map(Vec2::from),
                score: columns.score.map_or(Ok(None), |column| narrow(cells[column]))?,
                position_m: columns
                    .position_m
                    .map_or(Ok(None), |at| all(cells, at))?
                    .map(Vec3::from_array),
            };
        }
        Ok(pose)
    }
}

/// The joint of a column with coordinates.
fn joint_of(kind: PoseKind, column: &str) -> Option<&str> {
    let suffix = PIXELS.iter().chain(&METRES).find(|suffix| column.ends_with(**suffix))?;
    let joint = column.strip_suffix(suffix)?;
    kind.joint_names().contains(&joint).then_some(joint)
}

/// Columns of the parameters or of a joint's coordinates, none of them or all.
fn together<const N: usize>(
    names: &[&str],
    joint: &str,
    suffixes: [&str; N],
) -> Result<Option<[usize; N]>, RowFault> {
    let wanted = suffixes.map(|suffix| format!("{joint}{suffix}"));
    let at = |name: &String| names.iter().position(|known| known == name);
    if wanted.iter().all(|name| at(name).is_none()) {
        return Ok(None);
    }
    let mut indices = [0; N];
    for (index, name) in indices.iter_mut().zip(&wanted) {
        // Some without the others are more likely misspelt than left out.
        *index = at(name).ok_or_else(|| RowFault::NoColumn(name.clone()))?;
    }
    Ok(Some(indices))
}

/// The value of a cell; none if it is missing: empty or `nan`.
fn value(cell: &str) -> Result<Option<f64>, RowFault> {
    if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
        return Ok(None);
    }
    let value = cell.parse::<f64>().ok().filter(|value| value.is_finite());
    value.map(Some).ok_or_else(|| RowFault::NoNumber(cell.to_owned()))
}

fn narrow(cell: &str) -> Result<Option<f32>, RowFault> {
    Ok(value(cell)?.map(|value| value as f32))
}

/// The values of cells; none if one is missing.
fn all<const N: usize>(cells: &[&str], columns: [usize; N]) -> Result<Option<[f32; N]>, RowFault> {
    let mut values = [0.0; N];
    let mut is_whole = true;
    for (out, column) in values.iter_mut().zip(columns) {
        match narrow(cells[column])? {
            Some(value) => *out = value,
            // A position with a missing coordinate is none.
            None => is_whole = false,
        }
    }
    Ok(is_whole.then_some(values))
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<PoseSequence, IoError> {
    let text =
        str::from_utf8(bytes).map_err(|_| row_fault(path, 1, 0, "it is not text".to_owned(), 0))?;
    let cells = |line: &'_ str| -> Vec<String> {
        line.split(',').map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
    };
    let (mut columns, mut byte) = (None, 0);
    let mut sequence = PoseSequence::new(PoseKind::Body);
    for (number, line) in (1..).zip(text.split_inclusive('\n')) {
        let rows = sequence.poses.len();
        // Lines are counted from one, as in editors.
        let fault = |reason: String| row_fault(path, number, byte, reason, rows);
        let cells = cells(line.trim_end());
        let cells: Vec<&str> = cells.iter().map(String::as_str).collect();
        match &columns {
            None => {
                let known = Columns::of(&cells).map_err(|e| fault(e.to_string()))?;
                sequence = PoseSequence { frame: None, ..PoseSequence::new(known.kind) };
                columns = Some(known);
            }
            Some(_) if line.trim().is_empty() => {}
            Some(columns) => {
                sequence.poses.push(columns.pose(&cells).map_err(|e| fault(e.to_string()))?);
                if let Some(column) = columns.frame {
                    let frame = JointFrame::ALL.into_iter().find(|f| f.name() == cells[column]);
                    let frame = frame.ok_or_else(|| {
                        fault(format!("frame: `{}` is neither camera nor world", cells[column]))
                    })?;
                    if sequence.frame.replace(frame).is_some_and(|before| before != frame) {
                        return Err(fault("frame: not that of the line before".to_owned()));
                    }
                }
            }
        }
        byte += line.len() as u64;
    }
    if columns.is_none() {
        return Err(row_fault(path, 1, 0, "no header: expected t_us, …".to_owned(), 0));
    }
    Ok(sequence)
}
