//! Projection of world points to the images of the cameras.

use std::path::Path;

use evpose_pose::body::BodyPoints;
use glam::{DVec3, DVec4, Vec2};

use super::{PROJECTION_FILES, Pose, SENSOR};
use crate::DatasetError;

/// A 3x4 projection matrix from world points, in millimetres, to pixels.
///
/// # Model
/// `(a, b, c) = P (x, y, z, 1)`, column `u = a/c`, row `v = 260 - b/c`. On the image is what
/// has `0 < u <= 346` and `0 < v <= 260`.
///
/// # Source
/// The published tutorial of DHP19 and hpe-core, `datasets/dhp19/utils/parsing.py`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    rows: [DVec4; 3],
}

/// Rounding of fractions of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PixelRule {
    /// They stay.
    #[default]
    Exact,
    /// They are dropped, as in published labels.
    Truncated,
}

impl Projection {
    /// A matrix by its rows.
    pub fn new(rows: [[f64; 4]; 3]) -> Self {
        Self { rows: rows.map(DVec4::from) }
    }

    /// Reads the projection of a camera from the folder of projections.
    ///
    /// # Errors
    /// As [`Self::read`].
    ///
    /// # Panics
    /// If there is no such camera.
    pub fn of_camera(camera: usize, folder: &Path) -> Result<Self, DatasetError> {
        Self::read(&folder.join(PROJECTION_FILES[camera]))
    }

    /// Reads an array of NumPy.
    ///
    /// # Errors
    /// If it cannot be read, or is not of 3x4 finite values of 64 bits.
    pub fn read(path: &Path) -> Result<Self, DatasetError> {
        let bytes = std::fs::read(path).map_err(DatasetError::io(path, "read it"))?;
        parse(&bytes)
            .map_err(|(byte, reason)| DatasetError::malformed(path, format!("byte {byte}"), reason))
    }

    /// Column and row of a point, if it is on the image.
    pub fn project(&self, point_mm: DVec3) -> Option<Vec2> {
        let point = point_mm.extend(1.0);
        let [a, b, c] = self.rows.map(|row| row.dot(point));
        let (u, v) = (a / c, f64::from(SENSOR.height) - b / c);
        let is_on_image =
            0.0 < u && u <= f64::from(SENSOR.width) && 0.0 < v && v <= f64::from(SENSOR.height);
        is_on_image.then(|| Vec2::new(u as f32, v as f32))
    }

    /// Joints of a person on the image, in the order of networks.
    pub fn project_pose(&self, pose: &Pose, rule: PixelRule) -> BodyPoints {
        pose.map(|point| {
            let point = self.project(point?)?;
            Some(match rule {
                PixelRule::Exact => point,
                PixelRule::Truncated => point.trunc(),
            })
        })
    }
}

/// The array that `bytes` are, or the byte that is wrong and why.
fn parse(bytes: &[u8]) -> Result<Projection, (usize, String)> {
    const MATRIX_BYTES: usize = 12 * 8;
    let no_array = || (0, "no array of NumPy, of version 1 of its format".to_owned());
    let rest = bytes.strip_prefix(b"\x93NUMPY\x01\x00").ok_or_else(no_array)?;
    // The length of the header, two bytes in version 1.
    let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(no_array)?;
    let length = u16::from_le_bytes(*length).into();
    let (header, values) = rest.split_at_checked(length).ok_or_else(no_array)?;
    // As NumPy writes it, but for blanks.
    let header: String =
        String::from_utf8_lossy(header).chars().filter(|c| !c.is_whitespace()).collect();
    let has = |entry: &str| header.contains(entry);
    let (is_little, is_big) = (has("'descr':'<f8'"), has("'descr':'>f8'"));
    if !has("'shape':(3,4)") || is_little == is_big {
        let reason = format!("float64 of shape (3, 4) is expected, this is {header}");
        return Err((10, reason));
    }
    // Offsets in messages are those of the file.
    let at = bytes.len() - values.len();
    if values.len() != MATRIX_BYTES {
        let reason =
            format!("{MATRIX_BYTES} bytes are expected from here on, {} follow", values.len());
        return Err((at, reason));
    }
    let values = values.as_chunks::<8>().0.iter().map(|&value| {
        if is_little { f64::from_le_bytes(value) } else { f64::from_be_bytes(value) }
    });
    let is_by_columns = has("'fortran_order':True");
    let mut rows = [[0.0; 4]; 3];
    for (index, value) in values.enumerate() {
        if !value.is_finite() {
            return Err((at + 8 * index, format!("{value} where a number is expected")));
        }
        // Columns first, as Fortran stores them.
        let (row, column) =
            if is_by_columns { (index % 3, index / 3) } else { (index / 4, index % 4) };
        rows[row][column] = value;
    }
    Ok(Projection::new(rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A camera at the origin that looks along z: 300 pixels of focal length, middle at (173, 130).
    const PLAIN: [[f64; 4]; 3] =
        [[300.0, 0.0, 173.0, 0.0], [0.0, 300.0, 130.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

    fn array(order: &str, values: impl Iterator<Item = f64>) -> Vec<u8> {
        let header =
            format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': (3, 4), }}      \n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.bytes());
        bytes.extend(values.flat_map(f64::to_le_bytes));
        bytes
    }

    #[test]
    fn rows_count_from_the_top_and_what_is_off_the_image_is_nowhere() {
        let camera = Projection::new(PLAIN);
        assert_eq!(camera.project(DVec3::new(0.0, 0.0, 1000.0)), Some(Vec2::new(173.0, 130.0)));
        // 30 pixels up in the room's y is 30 rows less.
        assert_eq!(camera.project(DVec3::new(100.0, 100.0, 1000.0)), Some(Vec2::new(203.0, 100.0)));
        for x in [-173.0, 173.5] {
            assert_eq!(camera.project(DVec3::new(x, 0.0, 300.0)), None, "{x}");
        }
        assert!(camera.project(DVec3::new(173.0, 0.0, 300.0)).is_some());
        for point in [DVec3::ZERO, DVec3::NAN, DVec3::new(0.0, 130.0, 300.0)] {
            assert_eq!(camera.project(point), None, "{point}");
        }
    }

    #[test]
    fn fractions_are_dropped_where_that_is_asked_for() {
        let camera = Projection::new(PLAIN);
        let mut pose: Pose = [None; 13];
        pose[7] = Some(DVec3::new(2.5, -2.5, 1000.0));
        let exact = camera.project_pose(&pose, PixelRule::Exact);
        assert_eq!(exact[7], Some(Vec2::new(173.75, 130.75)));
        let truncated = camera.project_pose(&pose, PixelRule::Truncated);
        assert_eq!(truncated[7], Some(Vec2::new(173.0, 130.0)));
        assert_eq!(truncated.iter().flatten().count(), 1);
    }

    #[test]
    fn arrays_are_read_in_either_order_and_refused_with_the_byte() {
        let by_rows = PLAIN.into_iter().flatten();
        let by_columns = (0..12).map(|i| PLAIN[i % 3][i / 3]);
        let bytes = array("False", by_rows.clone());
        for bytes in [&bytes, &array("True", by_columns)] {
            assert_eq!(parse(bytes).unwrap(), Projection::new(PLAIN));
        }
        for cut in 0..bytes.len() {
            assert!(parse(&bytes[..cut]).is_err(), "{cut}");
        }
        let (byte, reason) = parse(&array("False", by_rows.map(|n| 1.0 / n))).unwrap_err();
        // The second of twelve values is 0, whose inverse is infinite.
        assert_eq!(byte, bytes.len() - 96 + 8);
        assert!(reason.contains("inf"), "{reason}");
        let other = bytes.iter().map(|&b| if b == b'8' { b'4' } else { b }).collect::<Vec<_>>();
        assert!(parse(&other).unwrap_err().1.contains("<f4"));
    }
}
