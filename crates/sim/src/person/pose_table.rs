//! Labels of a sequence: a table of joints over time, as CSV.

use std::fmt::Write as _;
use std::path::Path;

use evpose_core::{Micros, atomic_write};
use evpose_pose::body::{BODY_JOINTS, BodyPoints, JOINT_NAMES};
use glam::{Vec2, Vec3};

use super::joints::BodyJoints3;
use crate::SimError;

/// Joint positions of a person at one time stamp.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseRow {
    /// Time stamp.
    pub t: Micros,
    /// Image positions in pixels; none outside of the image.
    pub joints_px: BodyPoints,
    /// World positions in metres.
    pub joints_m: BodyJoints3,
}

/// The labels of a sequence, in order of time: columns `t_us`, then `u_px`, `v_px`, `x_m`, `y_m`
/// and `z_m` of every joint. The first two are empty for a joint outside of the image, all five
/// where nobody is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PoseTable {
    /// Rows, in order of time.
    pub rows: Vec<PoseRow>,
}

/// Column suffixes of a joint.
const COLUMNS: [&str; 5] = ["u_px", "v_px", "x_m", "y_m", "z_m"];

impl PoseTable {
    /// Header line.
    fn header() -> String {
        let joints =
            JOINT_NAMES.iter().flat_map(|name| COLUMNS.map(|column| format!(",{name}_{column}")));
        std::iter::once("t_us".to_owned()).chain(joints).collect()
    }

    /// Writes the table; the file appears when it is complete.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), SimError> {
        let mut text = Self::header();
        text.push('\n');
        for row in &self.rows {
            let _ = write!(text, "{}", row.t.0);
            for (px, m) in row.joints_px.iter().zip(&row.joints_m) {
                let _ = match px {
                    Some(px) => write!(text, ",{:.3},{:.3}", px.x, px.y),
                    None => write!(text, ",,"),
                };
                let _ = if m.is_finite() {
                    write!(text, ",{:.5},{:.5},{:.5}", m.x, m.y, m.z)
                } else {
                    write!(text, ",,,")
                };
            }
            text.push('\n');
        }
        atomic_write(path, text.as_bytes()).map_err(|source| SimError::file(path, "write", source))
    }

    /// Reads a table.
    ///
    /// # Errors
    /// If it cannot be read, or a line is not one of such a table.
    pub fn read(path: &Path) -> Result<Self, SimError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| SimError::file(path, "read", source))?;
        let fault =
            |line: usize, reason: String| SimError::Poses { path: path.to_owned(), line, reason };
        let mut lines = text.lines();
        if lines.next() != Some(Self::header().as_str()) {
            return Err(fault(1, "not the columns of poses: t_us, head_u_px, ...".to_owned()));
        }
        let rows =
            lines.enumerate().map(|(k, line)| parse(line).map_err(|reason| fault(k + 2, reason)));
        Ok(Self { rows: rows.collect::<Result<_, _>>()? })
    }
}

fn parse(line: &str) -> Result<PoseRow, String> {
    let cells: Vec<&str> = line.split(',').collect();
    let expected = 1 + COLUMNS.len() * BODY_JOINTS;
    if cells.len() != expected {
        return Err(format!("{} columns where {expected} are expected", cells.len()));
    }
    let t = cells[0].parse().map_err(|_| format!("`{}` is no time in microseconds", cells[0]))?;
    let number = |cell: &str| match cell.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{cell}` is no number")),
    };
    let mut row = PoseRow {
        t: Micros(t),
        joints_px: [None; BODY_JOINTS],
        joints_m: [Vec3::ZERO; BODY_JOINTS],
    };
    for (joint, cells) in cells[1..].as_chunks::<5>().0.iter().enumerate() {
        let [u, v, x, y, z] = cells;
        if !(u.is_empty() && v.is_empty()) {
            row.joints_px[joint] = Some(Vec2::new(number(u)?, number(v)?));
        }
        let is_absent = x.is_empty() && y.is_empty() && z.is_empty();
        row.joints_m[joint] =
            if is_absent { Vec3::NAN } else { Vec3::new(number(x)?, number(y)?, number(z)?) };
    }
    Ok(row)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn what_was_written_is_read_back() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("0000.poses.csv");
        let mut row = PoseRow {
            t: Micros(20_000),
            joints_px: [Some(Vec2::new(1.5, 260.125)); BODY_JOINTS],
            joints_m: [Vec3::new(-0.5, 1.25, 0.0); BODY_JOINTS],
        };
        row.joints_px[3] = None;
        let table = PoseTable { rows: vec![row.clone(), PoseRow { t: Micros(30_000), ..row }] };
        table.write(&path).unwrap();
        assert_eq!(PoseTable::read(&path).unwrap(), table);
    }

    #[test]
    fn nobody_has_neither_positions_on_the_image_nor_in_the_world() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("0000.poses.csv");
        let joints_m = [Vec3::NAN; BODY_JOINTS];
        let row = PoseRow { t: Micros(0), joints_px: [None; BODY_JOINTS], joints_m };
        PoseTable { rows: vec![row] }.write(&path).unwrap();
        let read = PoseTable::read(&path).unwrap();
        assert!(read.rows[0].joints_px.iter().all(Option::is_none));
        assert!(read.rows[0].joints_m.iter().all(|joint_m| joint_m.is_nan()));
    }

    #[test]
    fn damage_is_named_with_its_line() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("poses.csv");
        std::fs::write(&path, format!("{}\n10,1\n", PoseTable::header())).unwrap();
        let message = PoseTable::read(&path).unwrap_err().to_string();
        assert!(message.contains("line 2") && message.contains("2 columns"), "{message}");
        std::fs::write(&path, "something else").unwrap();
        assert!(PoseTable::read(&path).unwrap_err().to_string().contains("line 1"));
    }
}
