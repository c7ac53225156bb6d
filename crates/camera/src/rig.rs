//! Several cameras and their places, as a TOML file.
//!
//! ```toml
//! [[camera]]
//! focal_px = [310.2, 310.9]
//! principal_px = [173.0, 130.0]
//! distortion = [-0.31, 0.12, 0.0, 0.0]
//! opencv_camera_from_world = [[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 1.2], [0.0, 0.0, -1.0, 3.0]]
//!
//! [[camera]]
//! projection = "P3.npy"
//! unit_m = 0.001
//! rows_from_bottom_of = 260
//! ```
//!
//! `opencv_camera_from_world` are the rows of rotation and translation, in metres, to a camera whose
//! axes are OpenCV's. `projection` is a matrix from the world to pixels, as rows or as a file of NumPy
//! beside the TOML file; `unit_m` is the unit of its world, by default a metre, and
//! `rows_from_bottom_of` the height of the image where its rows count from the bottom, as DHP19's.

use std::path::Path;

use evpose_core::PlacedCamera;
use serde::Deserialize;

use crate::CalibrationError;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RigFile {
    camera: Vec<CameraEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum CameraEntry {
    Projection(ProjectionEntry),
    Placed(PlacedCamera),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ProjectionEntry {
    projection: Projection,
    #[serde(default = "one")]
    unit_m: f64,
    rows_from_bottom_of: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Projection {
    Rows([[f64; 4]; 3]),
    File(String),
}

fn one() -> f64 {
    1.0
}

/// Reads the cameras of a rig, in the order of the file.
///
/// # Errors
/// If the file cannot be read, an entry is of neither form, or a matrix is that of no camera; the
/// message has the number of the camera.
pub fn read_rig(path: &Path) -> Result<Vec<PlacedCamera>, CalibrationError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| CalibrationError::File { path: path.to_owned(), source })?;
    let malformed = |reason: String| CalibrationError::Malformed { path: path.to_owned(), reason };
    let file: RigFile = toml::from_str(&text).map_err(|error| {
        malformed(format!(
            "{error}each [[camera]] has focal_px, principal_px and opencv_camera_from_world, or a \
             projection"
        ))
    })?;
    let camera = |(index, entry): (usize, CameraEntry)| {
        let at = |fault| malformed(format!("camera {}: {fault}", index + 1));
        match entry {
            CameraEntry::Placed(camera) => Ok(camera),
            CameraEntry::Projection(entry) => of_projection(&entry, path).map_err(at),
        }
    };
    file.camera.into_iter().enumerate().map(camera).collect()
}

fn of_projection(entry: &ProjectionEntry, rig: &Path) -> Result<PlacedCamera, CalibrationError> {
    let mut rows = match &entry.projection {
        Projection::Rows(rows) => *rows,
        Projection::File(name) => {
            let file = rig.parent().unwrap_or(Path::new("")).join(name);
            read_matrix(&file)?
        }
    };
    for row in &mut rows {
        // The matrix takes the world's unit.
        for value in &mut row[..3] {
            *value /= entry.unit_m;
        }
    }
    if let Some(height) = entry.rows_from_bottom_of {
        let [_, row, depth] = rows;
        // A row is the quotient of both: from the bottom it is `height` less that.
        rows[1] = std::array::from_fn(|k| height * depth[k] - row[k]);
    }
    PlacedCamera::from_projection(rows)
        .ok_or_else(|| CalibrationError::Invalid { reason: "no projection of a camera".to_owned() })
}

fn read_matrix(path: &Path) -> Result<[[f64; 4]; 3], CalibrationError> {
    let malformed = |reason: String| CalibrationError::Malformed { path: path.to_owned(), reason };
    let unread = |error: std::io::Error| malformed(error.to_string());
    let file = std::fs::File::open(path).map_err(unread)?;
    let array = npyz::NpyFile::new(std::io::BufReader::new(file)).map_err(unread)?;
    let (shape, order) = (array.shape().to_vec(), array.order());
    if shape != [3, 4] {
        return Err(malformed(format!("an array of shape {shape:?} instead of [3, 4]")));
    }
    let values: Vec<f64> = array.into_vec().map_err(unread)?;
    // Values come as they are stored, which may be column by column.
    let by_columns = order == npyz::Order::Fortran;
    let at = |row: usize, column: usize| match by_columns {
        true => values[3 * column + row],
        false => values[4 * row + column],
    };
    Ok(std::array::from_fn(|row| std::array::from_fn(|column| at(row, column))))
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    const PLACED: &str = "[[camera]]\nfocal_px = [300.0, 300.0]\nprincipal_px = [173.0, 130.0]\n\
        opencv_camera_from_world = [[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 1.0], [0.0, 0.0, -1.0, 3.0]]\n";

    fn read(text: &str) -> Result<Vec<PlacedCamera>, String> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("rig.toml");
        std::fs::write(&path, text).unwrap();
        read_rig(&path).map_err(|error| error.to_string())
    }

    /// The same camera as intrinsics and place, and as a matrix from millimetres with rows from the
    /// bottom.
    #[test]
    fn both_forms_of_a_camera_project_alike() {
        let projection = "[[camera]]\nprojection = [[300.0, 0.0, -173.0, 519000.0], \
            [0.0, 300.0, -130.0, 90000.0], [0.0, 0.0, -1.0, 3000.0]]\n\
            unit_m = 0.001\nrows_from_bottom_of = 260\n";
        let cameras = read(&format!("{PLACED}{projection}")).unwrap();
        for point in [DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.4, 1.7, 0.5)] {
            let [a, b] = [0, 1].map(|k| cameras[k].image_from_world(point).unwrap());
            assert!(a.distance(b) < 1e-9, "{a} {b}");
        }
        let middle = cameras[0].image_from_world(DVec3::new(0.0, 1.0, 0.0)).unwrap();
        assert_eq!(middle, DVec2::new(173.0, 130.0));
    }

    #[test]
    fn matrices_of_numpy_are_read_in_either_order_of_memory() {
        use npyz::WriterBuilder as _;
        let rows = [[300.0, 2.0, 173.0, 519.0], [1.0, 310.0, 130.0, 90.0], [0.0, 0.1, 1.0, 3.0]];
        let read = |order, shape: &[u64], values: Vec<f64>| {
            let directory = tempfile::tempdir().unwrap();
            let file = std::fs::File::create(directory.path().join("P.npy")).unwrap();
            let options = npyz::WriteOptions::new().default_dtype().order(order).shape(shape);
            let mut npy = options.writer(file).begin_nd().unwrap();
            npy.extend(values).unwrap();
            npy.finish().unwrap();
            let rig = directory.path().join("rig.toml");
            std::fs::write(&rig, "[[camera]]\nprojection = \"P.npy\"\n").unwrap();
            read_rig(&rig).map_err(|error| error.to_string())
        };
        let columns = (0..4).flat_map(|column| rows.map(|row| row[column])).collect();
        let wanted = vec![PlacedCamera::from_projection(rows).unwrap()];
        assert_eq!(read(npyz::Order::C, &[3, 4], rows.concat()).unwrap(), wanted);
        assert_eq!(read(npyz::Order::Fortran, &[3, 4], columns).unwrap(), wanted);
        let other = read(npyz::Order::C, &[4, 3], rows.concat()).unwrap_err();
        assert!(other.contains("[4, 3] instead of [3, 4]"), "{other}");
    }

    #[test]
    fn faults_name_the_camera_and_the_keys() {
        let flat = "[[camera]]\nprojection = [[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], \
            [1.0, 0.0, 0.0, 0.0]]\n";
        let message = read(&format!("{PLACED}{flat}")).unwrap_err();
        assert!(message.contains("camera 2"), "{message}");
        let message = read("[[camera]]\nfocal = 3\n").unwrap_err();
        assert!(message.contains("opencv_camera_from_world"), "{message}");
        let message = read("[[camera]]\nprojection = \"P9.npy\"\n").unwrap_err();
        assert!(message.contains("P9.npy"), "{message}");
    }
}
