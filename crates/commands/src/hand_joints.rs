//! The table of a hand's 21 joints over time, as `evpose infer --joints` writes it.
//!
//! Each line holds `t_us` and for each joint `u_px,v_px,x_m,y_m,z_m`; pixels are empty where a
//! joint lies behind the camera.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_core::Micros;
use evpose_pose::EVALUATION_JOINTS;
use evpose_pose::metric::HandPoints;
use glam::Vec2;

/// Columns of a joint.
const COLUMNS_PER_JOINT: usize = 5;

/// Beginning of the header line.
const HEADER_START: &str = "t_us,";

/// The header line.
pub fn header() -> String {
    let mut header = "t_us".to_owned();
    for joint in EVALUATION_JOINTS {
        let _ = write!(header, ",{joint}_u_px,{joint}_v_px,{joint}_x_m,{joint}_y_m,{joint}_z_m");
    }
    header + "\n"
}

/// Appends the line of a time stamp.
pub fn push(csv: &mut String, t: Micros, points: &HandPoints) {
    let _ = write!(csv, "{}", t.0);
    for (image, world) in points.image_px.iter().zip(&points.world_m) {
        let _ = match image {
            Some(p) => write!(csv, ",{},{}", p.x, p.y),
            None => write!(csv, ",,"),
        };
        let _ = write!(csv, ",{},{},{}", world.x, world.y, world.z);
    }
    csv.push('\n');
}

/// Whether a file is such a table, by its header.
pub fn is_one(text: &str) -> bool {
    text.starts_with(HEADER_START)
}

/// Parses the joints in pixels of `text`, the contents of `path`; none for a hand with joints
/// behind the camera.
pub fn read(text: &str, path: &Path) -> Result<Vec<(Micros, Option<[Vec2; 21]>)>> {
    let line = |(number, line): (usize, &str)| {
        let row = || format!("{}: line {}", path.display(), number + 1);
        let cells: Vec<&str> = line.split(',').collect();
        let expected = 1 + COLUMNS_PER_JOINT * EVALUATION_JOINTS.len();
        if cells.len() != expected {
            bail!("{}: {} columns, expected {expected}", row(), cells.len());
        }
        let t = Micros(cells[0].parse().with_context(|| format!("{}: t_us", row()))?);
        let mut points_px = [Vec2::ZERO; 21];
        let mut in_front = true;
        for ((point, cells), joint) in
            points_px.iter_mut().zip(cells[1..].chunks(COLUMNS_PER_JOINT)).zip(EVALUATION_JOINTS)
        {
            in_front &= !cells[0].is_empty();
            if in_front {
                let pixel = |cell: &str, axis| {
                    let value: f32 =
                        cell.parse().with_context(|| format!("{}: {joint}_{axis}_px", row()))?;
                    anyhow::ensure!(value.is_finite(), "{}: {joint}_{axis}_px: {value}", row());
                    Ok(value)
                };
                *point = Vec2::new(pixel(cells[0], "u")?, pixel(cells[1], "v")?);
            }
        }
        Ok((t, in_front.then_some(points_px)))
    };
    text.lines().enumerate().skip(1).map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn tables_round_trip_and_damage_is_reported() {
        let points = |u: f32| HandPoints {
            world_m: [Vec3::ONE; 21],
            image_px: std::array::from_fn(|k| Some(Vec2::new(u, k as f32))),
        };
        let mut text = header();
        push(&mut text, Micros(5), &points(2.5));
        let mut behind = points(1.0);
        behind.image_px[20] = None;
        push(&mut text, Micros(9), &behind);
        assert!(is_one(&text));
        let path = Path::new("joints.csv");
        let read_back = read(&text, path).expect("as written");
        assert_eq!(read_back.len(), 2);
        assert_eq!(read_back[0].0, Micros(5));
        assert_eq!(read_back[0].1.expect("in front")[20], Vec2::new(2.5, 20.0));
        assert_eq!(read_back[1], (Micros(9), None));

        let error = read(&text[..text.len() - 9], path).expect_err("cut").to_string();
        assert!(error.contains("joints.csv: line 3"), "{error}");
        let error =
            format!("{:#}", read(&text.replace("2.5,", "x,"), path).expect_err("no number"));
        assert!(error.contains("wrist_u_px"), "{error}");
    }
}
