//! A camera that has been calibrated, in a file.
//!
//! ```toml
//! sensor = { width = 240, height = 180 }
//! # fx and fy of OpenCV's camera matrix.
//! focal_px = [252.9, 253.1]
//! # From the corner of the image, as all positions in pixels: cx + 0.5 and cy + 0.5 of OpenCV, whose pixel
//! # centres lie at whole numbers.
//! principal_px = [130.1, 90.2]
//! # In OpenCV's order: k1 k2 p1 p2, k3, k4 k5 k6, s1 s2 s3 s4, tx ty; 0, 4, 5, 8, 12 or 14 of them.
//! distortion = [-0.36, 0.16, 0.0, 0.0]
//! # Of a fisheye lens (equidistant, Kannala and Brandt), distortion is k1 k2 k3 k4.
//! fisheye = false
//! ```

use std::fs;
use std::path::Path;

use evpose_core::{LensCamera, SensorSize};
use serde::{Deserialize, Serialize};

use crate::CalibrationError;

/// A camera as OpenCV calibrates it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraFile {
    /// Its sensor.
    pub sensor: SensorSize,
    /// Focal lengths in pixels.
    pub focal_px: [f64; 2],
    /// Principal point, in pixels from the top-left corner of the image.
    pub principal_px: [f64; 2],
    /// Coefficients of the distortion in OpenCV's order.
    #[serde(default)]
    pub distortion: Vec<f64>,
    /// Whether these are the four of a fisheye lens.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fisheye: bool,
}

impl CameraFile {
    /// The DAVIS240C that EventHands' real recordings were made with, as published.
    pub fn davis240c_eventhands() -> Self {
        Self {
            sensor: SensorSize::DAVIS240C,
            focal_px: [252.912_940_04, 253.082_705_35],
            // Published for OpenCV, which puts centres of pixels at whole numbers.
            principal_px: [129.631_818_08 + 0.5, 89.725_985_11 + 0.5],
            distortion: vec![
                -33.078_311_8,
                340.196_626,
                -3.194_916_18e-4,
                -6.280_585_71e-4,
                167.319_020,
                -32.743_698_1,
                329.048_638,
                285.123_812,
            ],
            fisheye: false,
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read or is no camera.
    pub fn load(path: &Path) -> Result<Self, CalibrationError> {
        let text = fs::read_to_string(path)
            .map_err(|source| CalibrationError::File { path: path.to_owned(), source })?;
        let malformed = |reason| CalibrationError::Malformed { path: path.to_owned(), reason };
        let file: Self = toml::from_str(&text).map_err(|error| malformed(error.to_string()))?;
        file.camera().map_err(|error| malformed(error.to_string()))?;
        Ok(file)
    }

    /// The camera.
    ///
    /// # Errors
    /// If values are those of no camera.
    pub fn camera(&self) -> Result<LensCamera, CalibrationError> {
        let invalid = |reason| CalibrationError::Invalid { reason };
        if self.sensor.pixels() == 0 {
            return Err(invalid(format!("sensor: {} has no pixels", self.sensor)));
        }
        let of_file =
            if self.fisheye { LensCamera::fisheye_from_file } else { LensCamera::from_file };
        of_file(self.focal_px, self.principal_px, &self.distortion)
            .map_err(|error| invalid(error.in_field(["focal_px", "principal_px", "distortion"])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_as_it_was_written_and_a_faulty_one_says_what_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.toml");
        let camera = CameraFile::davis240c_eventhands();
        fs::write(&path, toml::to_string(&camera).unwrap()).unwrap();
        assert_eq!(CameraFile::load(&path).unwrap(), camera);
        type Spoil = fn(&mut CameraFile);
        let faults: [(Spoil, &str); 5] = [
            (|c| c.principal_px[0] = f64::NAN, "principal_px: "),
            (|c| c.distortion.truncate(3), "3 coefficients of distortion"),
            (|c| c.focal_px[1] = 0.0, "focal_px: focal lengths of [252.91294004, 0.0] pixels"),
            (|c| c.sensor.width = 0, "sensor: 0x180 has no pixels"),
            (|c| c.distortion[0] = f64::NAN, "distortion: coefficients"),
        ];
        for (spoil, reason) in faults {
            let mut camera = camera.clone();
            spoil(&mut camera);
            fs::write(&path, toml::to_string(&camera).unwrap()).unwrap();
            let error = CameraFile::load(&path).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
    }
}
