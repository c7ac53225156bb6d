//! A recording of somebody's hand with its camera.

use std::path::{Path, PathBuf};

use evpose_camera::{Calibration, CalibrationSource};
use evpose_core::SensorSize;
use evpose_io::{OpenOptions, Windows};
use evpose_pose::HandSide;
use serde::Deserialize;

use super::HandJointTable;
use crate::TrainError;
use crate::listing::{events_of, file_names};

/// Ending of the labels.
const JOINTS: &str = ".joints.csv";

/// A recording of a hand, with labels and calibration.
#[derive(Debug, Clone)]
pub struct ForeignHand {
    /// Name of its files without extension.
    pub name: String,
    /// The file of its events.
    pub path: PathBuf,
    /// Calibration of the camera.
    pub calibration: Calibration,
    /// Side of the hand.
    pub side: HandSide,
    /// Joints with their time stamps.
    pub labels: HandJointTable,
}

impl ForeignHand {
    /// Reads the events.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(super) fn windows(&self) -> Result<Windows, TrainError> {
        windows(&self.path, self.calibration.sensor)
    }
}

fn windows(path: &Path, sensor: SensorSize) -> Result<Windows, TrainError> {
    Ok(Windows::open(path, &OpenOptions { sensor: Some(sensor), ..OpenOptions::default() })?)
}

/// The fields that are read of the file of a recording; all others are for people.
#[derive(Debug, Deserialize)]
struct Info {
    sensor: SensorSize,
    camera: CameraInfo,
    #[serde(default = "right")]
    side: String,
}

/// The camera, its principal point counted from the corner of the image: OpenCV's own files,
/// whose pixel centres are at whole numbers, have 0.5 less.
#[derive(Debug, Deserialize)]
struct CameraInfo {
    fx_px: f64,
    fy_px: f64,
    cx_px: f64,
    cy_px: f64,
    #[serde(default)]
    distortion: Vec<f64>,
}

fn right() -> String {
    "right".to_owned()
}

/// Reads every recording of a directory, in order of name.
///
/// # Errors
/// If a file is missing, cannot be read, or contradicts another.
pub fn foreign_hands(directory: &Path) -> Result<Vec<ForeignHand>, TrainError> {
    let names = file_names(directory)?;
    let stems: Vec<&str> = names.iter().filter_map(|name| name.strip_suffix(JOINTS)).collect();
    if stems.is_empty() {
        let message = format!("no recording with a table of joints (00{JOINTS})");
        return Err(TrainError::Config { path: directory.to_owned(), message });
    }
    stems.into_iter().map(|stem| read(directory, stem, &names)).collect()
}

fn read(directory: &Path, stem: &str, names: &[String]) -> Result<ForeignHand, TrainError> {
    let path = |ending: &str| -> PathBuf { directory.join(format!("{stem}{ending}")) };
    let info_path = path(".toml");
    let wrong = |message: String| TrainError::Config { path: info_path.clone(), message };
    let text = std::fs::read_to_string(&info_path)
        .map_err(|source| TrainError::Io { path: info_path.clone(), source })?;
    let info: Info = toml::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    let events = events_of(names, stem)
        .ok_or_else(|| wrong(format!("no events beside it, such as {stem}.npz or {stem}.raw")))?;
    let recording = directory.join(events);
    // Camera parameters are in pixels: they hold for the sensor that they were measured with.
    let own = windows(&recording, info.sensor)?.sensor();
    if own != info.sensor {
        return Err(wrong(format!("sensor: {}, but {events} is of {own}", info.sensor)));
    }
    let CameraInfo { fx_px, fy_px, cx_px, cy_px, distortion } = &info.camera;
    let camera = evpose_core::LensCamera::from_file([*fx_px, *fy_px], [*cx_px, *cy_px], distortion)
        .map_err(|error| {
            wrong(error.in_field(["camera.fx_px", "camera.cx_px", "camera.distortion"]))
        })?;
    let side = match info.side.as_str() {
        "right" => HandSide::Right,
        "left" => HandSide::Left,
        other => return Err(wrong(format!("side: `{other}` is neither right nor left"))),
    };
    Ok(ForeignHand {
        name: stem.to_owned(),
        path: recording,
        calibration: Calibration {
            sensor: info.sensor,
            camera,
            source: CalibrationSource::File(info_path.display().to_string()),
            note: None,
        },
        side,
        labels: HandJointTable::read(&path(JOINTS))?,
    })
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream, Micros, Polarity};

    use super::*;

    #[test]
    fn the_camera_is_that_of_the_same_calibration_by_opencv() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
            folder.path().join(name).display().to_string()
        };
        let sensor = SensorSize { width: 346, height: 260 };
        let event = Event { t: Micros(5), x: 345, y: 259, polarity: Polarity::On };
        let events = EventStream::from_events(sensor, [event]).unwrap();
        let npz = evpose_io::FORMATS.find("npz").unwrap();
        npz.write(folder.path().join("00.npz"), &events).unwrap();
        let joints = evpose_pose::EVALUATION_JOINTS;
        let columns: String = joints.map(|joint| format!(",{joint}_u_px,{joint}_v_px")).concat();
        write("00.joints.csv", &format!("t_us{columns}\n0{}\n", ",".repeat(42)));
        let camera = "fx_px = 310\nfy_px = 311\ncx_px = 172.5\ncy_px = 129.5\n";
        let info = "sensor = { width = 346, height = 260 }\n[camera]\n";
        write("00.toml", &format!("{info}{camera}"));
        // OpenCV counts from the centre of the first pixel: its principal point is half a pixel
        // less.
        let opencv = write(
            "calibration.yaml",
            "image_width: 346\nimage_height: 260\ncamera_matrix:\n  data: [310, 0, 172, 0, 311, \
             129, 0, 0, 1]\n",
        );
        let hands = foreign_hands(folder.path()).unwrap();
        let calibrated = Calibration::choose(Some(&opencv), sensor).unwrap();
        assert_eq!(hands[0].calibration.camera, calibrated.camera);
        write("00.toml", &format!("{info}{}", camera.replace("310", "0")));
        let error = foreign_hands(folder.path()).unwrap_err().to_string();
        assert!(error.contains("camera.fx_px"), "{error}");
    }
}
