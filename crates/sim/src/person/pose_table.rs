//! Labels of a sequence: a table of joints over time, as CSV.

use std::fmt::Write as _;
use std::path::Path;

use evpose_core::{Micros, atomic_write};
use evpose_io::poses::{PoseKind, PoseSequence, TimedPose, read_pose_table};
use evpose_pose::body::{BODY_JOINTS, BodyPoints, JOINT_NAMES};
use glam::Vec3;

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
/// and `z_m` of every joint, the latter three in the world. The first two are empty for a joint outside
/// of the image, all five where nobody is.
///
/// The names are those of [`evpose_io::poses`], by which tables are read; this one is written with fewer
/// columns, as it always was.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PoseTable {
    /// Rows, in order of time.
    pub rows: Vec<PoseRow>,
}

/// Column suffixes of a joint.
const COLUMNS: [&str; 5] = ["u_px", "v_px", "x_m", "y_m", "z_m"];

impl PoseTable {
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
                // Writing to a string cannot fail. Joints behind the camera have empty columns.
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

    /// Reads a table; columns are found by their names.
    ///
    /// # Errors
    /// If it cannot be read, or is no table of a person.
    pub fn read(path: &Path) -> Result<Self, SimError> {
        let PoseSequence { kind, poses, .. } = read_pose_table(path)?;
        if kind != PoseKind::Body {
            let reason = "not the columns of a person: t_us, head_u_px, ...".to_owned();
            return Err(SimError::Poses { path: path.to_owned(), line: 1, reason });
        }
        let row = |pose: TimedPose| {
            let mut joints_m = [Vec3::NAN; BODY_JOINTS];
            for (at_m, joint) in joints_m.iter_mut().zip(&pose.joints) {
                *at_m = joint.position_m.unwrap_or(Vec3::NAN);
            }
            PoseRow { t: pose.t, joints_px: pose.body_px(), joints_m }
        };
        Ok(Self { rows: poses.into_iter().map(row).collect() })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

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
        std::fs::write(&path, "t_us,wrist_u_px,wrist_v_px\n").unwrap();
        let message = PoseTable::read(&path).unwrap_err().to_string();
        assert!(message.contains("of a person"), "{message}");
    }

    #[test]
    fn columns_are_found_by_name() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("poses.csv");
        std::fs::write(&path, "head_v_px,score,t_us,head_u_px\n2,0.5,7,1\n").unwrap();
        let row = &PoseTable::read(&path).unwrap().rows[0];
        assert_eq!((row.t, row.joints_px[0]), (Micros(7), Some(Vec2::new(1.0, 2.0))));
        assert!(row.joints_px[1..].iter().all(Option::is_none));
    }
}
