//! Files of calibrations: OpenCV's, ROS's and kalibr's YAML, OpenCV's XML, dv-processing's JSON, our
//! TOML.

mod entry;

use std::path::Path;

use evpose_core::{LensCamera, SensorSize};

use self::entry::Entry;
use crate::{CalibrationError, CameraFile};

/// A camera as a file has it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CameraOfFile {
    /// Its sensor, where the file says it.
    pub(crate) sensor: Option<SensorSize>,
    pub(crate) camera: LensCamera,
}

/// Reads a calibration file of any of the formats, recognised by its content.
pub(crate) fn read_file(path: &Path) -> Result<CameraOfFile, CalibrationError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| CalibrationError::File { path: path.to_owned(), source })?;
    let malformed = |reason: String| CalibrationError::Malformed { path: path.to_owned(), reason };
    // By content, which differs from format to format: the extension does not matter.
    let begin = text.trim_start();
    if begin.starts_with('{') {
        return dv_processing(&text).map_err(malformed);
    }
    if begin.starts_with("<?xml") || begin.starts_with("<opencv_storage") {
        return entry::of_xml(begin).and_then(|entries| opencv(&entries)).map_err(malformed);
    }
    if is_yaml(&text) {
        return entry::of_yaml(&text).and_then(|entries| opencv(&entries)).map_err(malformed);
    }
    let file = CameraFile::load(path)?;
    Ok(CameraOfFile { sensor: Some(file.sensor), camera: file.camera()? })
}

/// The camera of OpenCV's intrinsics, whose pixel centres lie at whole numbers; `fields` are those of
/// the size, the focal lengths, the principal point and the distortion.
fn checked(
    sensor: Option<[f64; 2]>,
    [fx, fy, cx, cy]: [f64; 4],
    distortion: &[f64],
    [size, fields @ ..]: [&str; 4],
) -> Result<CameraOfFile, String> {
    let is_side = |side: &f64| side.fract() == 0.0 && (1.0..=f64::from(u16::MAX)).contains(side);
    if let Some(sides) = sensor.filter(|sides| !sides.iter().all(is_side)) {
        return Err(format!("{size}: a sensor of {sides:?} pixels"));
    }
    let sensor =
        sensor.map(|[width, height]| SensorSize { width: width as u16, height: height as u16 });
    let camera = LensCamera::from_file([fx, fy], [cx + 0.5, cy + 0.5], distortion);
    Ok(CameraOfFile { sensor, camera: camera.map_err(|error| error.in_field(fields))? })
}

/// The first camera of dv-processing's set of calibrations.
fn dv_processing(text: &str) -> Result<CameraOfFile, String> {
    let root: serde_json::Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let camera = root
        .get("cameras")
        .and_then(|cameras| cameras.get(0))
        .ok_or("`cameras` with at least one camera is expected, as dv-processing writes it")?;
    let list_of = |key: &str| -> Result<Vec<f64>, String> {
        let list = camera.get(key).and_then(serde_json::Value::as_array);
        let list = list.ok_or_else(|| format!("cameras[0].{key}: a list is expected"))?;
        list.iter()
            .map(|value| value.as_f64().ok_or_else(|| format!("cameras[0].{key}: no number")))
            .collect()
    };
    let pair = |key: &str| -> Result<[f64; 2], String> {
        let list = list_of(key)?;
        list.try_into().map_err(|_| format!("cameras[0].{key}: two values are expected"))
    };
    let model = camera.get("distortionModel").and_then(serde_json::Value::as_str);
    if let Some(other) = model.filter(|model| !["radialTangential", "none"].contains(model)) {
        return Err(format!("cameras[0].distortionModel: `{other}` is not supported"));
    }
    let sensor = pair("resolution")?;
    let [fx, fy] = pair("focalLength")?;
    let [cx, cy] = pair("principalPoint")?;
    let distortion =
        if camera.get("distortion").is_some() { list_of("distortion")? } else { vec![] };
    let fields = ["resolution", "focalLength", "principalPoint", "distortion"];
    checked(Some(sensor), [fx, fy, cx, cy], &distortion, fields)
        .map_err(|reason| format!("cameras[0].{reason}"))
}

/// Whether the first line with content is YAML's: TOML has `=` before any colon.
fn is_yaml(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim_start);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or_default();
    first.starts_with(['%', '-'])
        || first.split_once(':').is_some_and(|(key, _)| !key.contains('='))
}

/// OpenCV's programs write the first two, ROS 1 and ROS 2 the next, kalibr the last.
const INTRINSICS: [&str; 5] = ["camera_matrix", "cameraMatrix", "K", "k", "intrinsics"];
/// OpenCV's programs write the first three, ROS 1 and ROS 2 the next, kalibr the last.
const DISTORTION: [&str; 6] =
    ["distortion_coefficients", "dist_coeffs", "distCoeffs", "D", "d", "distortion_coeffs"];
/// Keys that name a model of the lens, and the words there for OpenCV's, the one that is read.
const MODELS: [(&str, &[&str]); 4] = [
    (
        "distortion_model",
        &["plumb_bob", "rational_polynomial", "radtan", "radialTangential", "none", ""],
    ),
    ("camera_model", &["pinhole"]),
    ("fisheye_model", &["0", "false"]),
    ("use_fisheye_model", &["0", "false"]),
];

/// A camera in the keys of OpenCV's calibration, of ROS's and of kalibr's: at the top of the file, or
/// else the first in an entry of its own, as kalibr and DV write it.
fn opencv(entries: &[Entry]) -> Result<CameraOfFile, String> {
    let camera = entries
        .iter()
        .filter(|entry| INTRINSICS.contains(&&*entry.key))
        .map(|entry| &entry.above)
        .min_by_key(|above| !above.is_empty())
        .ok_or("no `camera_matrix`, `K` or `intrinsics`, as OpenCV, ROS and kalibr write them")?;
    let is_here = |entry: &&Entry| entry.above == *camera || entry.above.is_empty();
    for entry in entries.iter().filter(is_here) {
        let model = MODELS.iter().find(|(key, _)| *key == entry.key);
        if let (Some((_, read)), [word]) = (model, &entry.words[..])
            && !read.iter().any(|known| known.eq_ignore_ascii_case(word))
        {
            return Err(format!("{entry}: `{word}` is not supported"));
        }
    }
    // The values under the first of `keys` that is there, and their place.
    let list = |keys: &[&str]| -> Result<(String, Vec<f64>), String> {
        let find = |above: &str| {
            keys.iter().find_map(|key| entries.iter().find(|e| e.above == above && e.key == *key))
        };
        let Some(entry) = find(camera).or_else(|| find("")) else { return Ok(Default::default()) };
        let number = |word: &String| {
            word.parse().map_err(|_| format!("{entry}: `{word}` where a number is expected"))
        };
        Ok((entry.to_string(), entry.words.iter().map(number).collect::<Result<_, _>>()?))
    };
    let (at, values) = list(&INTRINSICS)?;
    let intrinsics = match values[..] {
        [fx, _, cx, _, fy, cy, _, _, _] | [fx, fy, cx, cy] => [fx, fy, cx, cy],
        _ => return Err(format!("{at}: {} values instead of 9 or 4", values.len())),
    };
    let (width_at, mut size) = list(&["image_width", "width", "resolution"])?;
    let (height_at, height) = list(&["image_height", "height"])?;
    let size_at = if size.is_empty() { height_at } else { width_at };
    size.extend(height);
    let sensor = match size[..] {
        [] => None,
        [width, height] => Some([width, height]),
        _ => return Err(format!("{size_at}: {} values for width and height", size.len())),
    };
    let (distortion_at, distortion) = list(&DISTORTION)?;
    checked(sensor, intrinsics, &distortion, [&size_at, &at, &at, &distortion_at])
}

#[cfg(test)]
mod tests;
