//! Joints of a hand over time, as CSV.

use std::path::Path;

use evpose_core::Micros;
use evpose_io::poses::{PoseKind, PoseSequence, TimedPose, read_pose_table};
use evpose_pose::JointFrame;
use glam::{Vec2, Vec3};

use crate::TrainError;

/// The joints of a hand at one time stamp, in the order of
/// [`EVALUATION_JOINTS`](evpose_pose::EVALUATION_JOINTS).
#[derive(Debug, Clone, PartialEq)]
pub struct HandJointRow {
    /// Time stamp.
    pub t: Micros,
    /// Positions on the sensor in pixels; none where they are not labelled.
    pub image_px: [Option<Vec2>; 21],
    /// Positions in the camera's frame in metres, x right, y down, z forwards; none where there
    /// are labels in 2D alone.
    pub camera_m: Option<[Vec3; 21]>,
}

/// A table of them, in order of time: columns `t_us`, then `wrist_u_px`, `wrist_v_px`,
/// `wrist_x_m`, `wrist_y_m`, `wrist_z_m` and so on for every joint. Cells of what is not labelled are
/// empty or `nan`; the columns of metres may be missing altogether.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HandJointTable {
    /// Rows, in order of time.
    pub rows: Vec<HandJointRow>,
}

impl HandJointTable {
    /// Reads a table of poses of a hand ([`evpose_io::poses`]).
    ///
    /// # Errors
    /// If it cannot be read, is of a person or in the world's frame, or a time is not later than the one
    /// before.
    pub fn read(path: &Path) -> Result<Self, TrainError> {
        let fault = |message: String| TrainError::Config { path: path.to_owned(), message };
        let PoseSequence { kind, frame, poses } = read_pose_table(path)?;
        if kind != PoseKind::Hand {
            return Err(fault("of a person, not of a hand".to_owned()));
        }
        if frame == Some(JointFrame::World) {
            return Err(fault("joints are in the world's frame, not the camera's".to_owned()));
        }
        // The first line is a header, and lines count from 1.
        for (line, pair) in (3..).zip(poses.windows(2)) {
            if pair[1].t <= pair[0].t {
                return Err(fault(format!("line {line}: not later than the line before")));
            }
        }
        Ok(Self { rows: poses.iter().map(row).collect() })
    }
}

fn row(pose: &TimedPose) -> HandJointRow {
    let mut image_px = [None; 21];
    for (point, joint) in image_px.iter_mut().zip(&pose.joints) {
        *point = joint.image_px;
    }
    // Errors in space need all joints; a hand that lacks one is scored on the image alone.
    let camera_m: Option<Vec<Vec3>> = pose.joints.iter().map(|joint| joint.position_m).collect();
    let camera_m = camera_m.and_then(|points| points.try_into().ok());
    HandJointRow { t: pose.t, image_px, camera_m }
}

#[cfg(test)]
mod tests {
    use evpose_pose::EVALUATION_JOINTS;

    use super::*;

    const COLUMNS: [&str; 5] = ["u_px", "v_px", "x_m", "y_m", "z_m"];

    fn table(with_metres: bool, cell: &str) -> String {
        let count = if with_metres { 5 } else { 2 };
        let names = EVALUATION_JOINTS.iter().flat_map(|joint| {
            COLUMNS[..count].iter().map(move |column| format!("{joint}_{column}"))
        });
        let header: Vec<String> = std::iter::once("t_us".to_owned()).chain(names).collect();
        let row = |t: u32| format!("{t}{}", format!(",{cell}").repeat(21 * count));
        format!("{}\n{}\n{}\n", header.join(","), row(0), row(10_000))
    }

    fn read(text: &str) -> Result<HandJointTable, TrainError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("00.joints.csv");
        std::fs::write(&path, text).unwrap();
        HandJointTable::read(&path)
    }

    #[test]
    fn joints_are_read_in_two_and_in_three_dimensions() {
        let both = read(&table(true, "1.5")).unwrap();
        assert_eq!(both.rows[1].t, Micros(10_000));
        assert_eq!(both.rows[0].image_px[20], Some(Vec2::splat(1.5)));
        assert_eq!(both.rows[0].camera_m.unwrap()[20], Vec3::splat(1.5));
        assert_eq!(read(&table(false, "1.5")).unwrap().rows[0].camera_m, None);
        for missing in ["", "nan"] {
            assert_eq!(read(&table(true, missing)).unwrap().rows[0].image_px, [None; 21]);
        }
    }

    #[test]
    fn faults_name_line_and_column() {
        let in_world = table(true, "1").replace("t_us,", "t_us,frame,");
        let in_world = in_world.replace("\n0,", "\n0,world,").replace("\n10000,", "\n10000,world,");
        for (text, want) in [
            (table(true, "x"), "`x` is no number"),
            (table(true, "1").replace("wrist_u_px", "wrist_u"), "no column `wrist_u_px`"),
            (table(true, "1").replace("10000,", "0,"), "line 3: not later"),
            (in_world, "world's frame"),
        ] {
            let error = read(&text).unwrap_err().to_string();
            assert!(error.contains(want), "{error}");
        }
    }
}
