//! Tables of the rotations of all joints of hands.

use std::fmt::Write as _;
use std::path::Path;

use evpose_core::Micros;
use evpose_pose::{DIGIT_JOINTS, EVALUATION_JOINTS, HandParams};
use glam::Vec3;

use super::format::write_lines;
use crate::IoError;

/// A full MANO pose at a time stamp: position and rotation of the wrist, and the rotations of the joints of the digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandRotationRow {
    /// Time stamp.
    pub t: Micros,
    /// Position and rotation of the wrist; the articulation is not written.
    pub wrist: HandParams,
    /// Axis-angles of the joints relative to their parents, in radians.
    pub rotations: [Vec3; DIGIT_JOINTS],
}

/// Writes a table: the wrist's position in metres and its axis-angle in radians, then 45 values.
///
/// # Errors
/// If the file cannot be written.
pub fn write_hand_rotations(
    path: &Path,
    rows: impl Iterator<Item = HandRotationRow>,
) -> Result<(), IoError> {
    let mut header = "t_us".to_owned();
    let joints = &EVALUATION_JOINTS[EVALUATION_JOINTS.len() - DIGIT_JOINTS..];
    let wrist = ["wrist"].into_iter();
    for (name, unit) in [("wrist", "m")]
        .into_iter()
        .chain(wrist.chain(joints.iter().copied()).map(|name| (name, "rad")))
    {
        for axis in ["x", "y", "z"] {
            let _ = write!(header, ",{name}_{axis}_{unit}");
        }
    }
    let line = |row: HandRotationRow| {
        let mut line = row.t.0.to_string();
        let HandParams { translation_m, rotation, .. } = row.wrist;
        for value in
            [translation_m, rotation].into_iter().chain(row.rotations).flat_map(|v| v.to_array())
        {
            let _ = write!(line, ",{value:.5}");
        }
        line + "\n"
    };
    write_lines(path, std::iter::once(header + "\n").chain(rows.map(line)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_column_for_every_value() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("rotations.csv");
        let row = HandRotationRow {
            t: Micros(7_000),
            wrist: HandParams { translation_m: Vec3::new(0.1, 0.2, -0.5), ..HandParams::default() },
            rotations: [Vec3::new(0.0, 0.25, 1.0); DIGIT_JOINTS],
        };
        write_hand_rotations(&path, [row].into_iter()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(lines.len(), 2);
        assert_eq!((lines[0].len(), lines[1].len()), (1 + 6 + 45, 1 + 6 + 45));
        assert_eq!(lines[0][..2], ["t_us", "wrist_x_m"]);
        assert_eq!((lines[0][7], lines[0][51]), ("index1_x_rad", "thumb3_z_rad"));
        assert_eq!((lines[1][3], lines[1][8]), ("-0.50000", "0.25000"));
    }
}
