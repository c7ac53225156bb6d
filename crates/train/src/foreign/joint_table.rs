//! Joints of a hand over time, as CSV.

use std::path::Path;

use evpose_core::Micros;
use evpose_pose::EVALUATION_JOINTS;
use glam::{Vec2, Vec3};

use crate::TrainError;

/// Column suffixes of a joint.
const COLUMNS: [&str; 5] = ["u_px", "v_px", "x_m", "y_m", "z_m"];

/// The joints of a hand at one time stamp, in the order of [`EVALUATION_JOINTS`].
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
    /// Reads a table. Columns may stand in any order.
    ///
    /// # Errors
    /// If it cannot be read, lacks a column, or a cell is no number.
    pub fn read(path: &Path) -> Result<Self, TrainError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| TrainError::Io { path: path.to_owned(), source })?;
        let fault = |line: usize, message: String| TrainError::Config {
            path: path.to_owned(),
            message: format!("line {line}: {message}"),
        };
        let mut lines = text.lines();
        let columns = Columns::of(lines.next().unwrap_or_default()).map_err(|m| fault(1, m))?;
        let mut rows: Vec<HandJointRow> = Vec::new();
        for (k, line) in lines.enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let row = columns.row(line).map_err(|message| fault(k + 2, message))?;
            if rows.last().is_some_and(|last| last.t >= row.t) {
                return Err(fault(k + 2, "not later than the line before".to_owned()));
            }
            rows.push(row);
        }
        Ok(Self { rows })
    }
}

/// Positions of the columns of a table.
struct Columns {
    t: usize,
    image: [[usize; 2]; 21],
    camera: Option<[[usize; 3]; 21]>,
    count: usize,
}

impl Columns {
    fn of(header: &str) -> Result<Self, String> {
        let names: Vec<&str> = header.split(',').map(str::trim).collect();
        let at = |name: String| {
            let missing = || format!("no column `{name}`; there are {}", names.join(", "));
            names.iter().position(|known| **known == *name).ok_or_else(missing)
        };
        let of = |joint: &str, column: usize| at(format!("{joint}_{}", COLUMNS[column]));
        let has_metres = names.iter().any(|name| name.ends_with("_m"));
        let (mut image, mut camera) = ([[0; 2]; 21], [[0; 3]; 21]);
        for (k, joint) in EVALUATION_JOINTS.iter().enumerate() {
            image[k] = [of(joint, 0)?, of(joint, 1)?];
            if has_metres {
                camera[k] = [of(joint, 2)?, of(joint, 3)?, of(joint, 4)?];
            }
        }
        let camera = has_metres.then_some(camera);
        Ok(Self { t: at("t_us".to_owned())?, image, camera, count: names.len() })
    }

    fn row(&self, line: &str) -> Result<HandJointRow, String> {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() != self.count {
            return Err(format!("{} columns where {} are expected", cells.len(), self.count));
        }
        let number = |at: usize| -> Result<Option<f32>, String> {
            let cell = cells[at];
            // Programs write nothing for a joint that is not labelled, or `nan`.
            if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
                return Ok(None);
            }
            let value = cell.parse::<f32>().ok().filter(|value| value.is_finite());
            value.map(Some).ok_or_else(|| format!("`{cell}` is no number"))
        };
        let t = cells[self.t].parse().map_err(|_| format!("`{}` is no time", cells[self.t]))?;
        let mut image_px = [None; 21];
        for (point, [u, v]) in image_px.iter_mut().zip(self.image) {
            *point = number(u)?.zip(number(v)?).map(|(u, v)| Vec2::new(u, v));
        }
        let mut camera_m = self.camera.map(|_| [Vec3::ZERO; 21]);
        if let (Some(columns), Some(points)) = (&self.camera, &mut camera_m) {
            let mut is_whole = true;
            for (point, [x, y, z]) in points.iter_mut().zip(columns) {
                match (number(*x)?, number(*y)?, number(*z)?) {
                    (Some(x), Some(y), Some(z)) => *point = Vec3::new(x, y, z),
                    _ => is_whole = false,
                }
            }
            camera_m = camera_m.filter(|_| is_whole);
        }
        Ok(HandJointRow { t: Micros(t), image_px, camera_m })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

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
        for (text, want) in [
            (table(true, "x"), "line 2: `x` is no number"),
            (
                table(true, "1").replace("wrist_u_px", "wrist_u"),
                "no column `wrist_u_px`; there are t_us, wrist_u,",
            ),
            (table(true, "1").replace("10000,", "0,"), "line 3: not later"),
        ] {
            let error = read(&text).unwrap_err().to_string();
            assert!(error.contains(want), "{error}");
        }
    }
}
