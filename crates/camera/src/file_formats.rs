//! Files of calibrations: OpenCV's and ROS's YAML, OpenCV's XML, dv-processing's JSON, our TOML.
//!
//! Of YAML and XML the few keys of a calibration are read: both are written by one library in one
//! shape, OpenCV's `FileStorage`, which ROS shares. Keys are found wherever they stand.

use std::path::Path;

use evpose_core::{LensCamera, SensorSize};

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
        return opencv(&xml_values(&text)).map_err(malformed);
    }
    if text.contains("camera_matrix") && text.contains(':') {
        return opencv(&yaml_values(&text)).map_err(malformed);
    }
    let file = CameraFile::parse(&text).map_err(malformed)?;
    let camera = file.camera().map_err(malformed)?;
    Ok(CameraOfFile { sensor: Some(file.sensor), camera })
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

/// Looks up the values of a key.
type Values<'a> = dyn Fn(&str) -> Option<Vec<f64>> + 'a;

/// A camera in the keys of OpenCV's calibration, and of ROS's.
fn opencv(values: &Values<'_>) -> Result<CameraOfFile, String> {
    let first = |names: &[&str]| names.iter().find_map(|name| values(name));
    // OpenCV's programs write the first two names, ROS's messages the last.
    let matrix = first(&["camera_matrix", "cameraMatrix", "K"])
        .ok_or("no `camera_matrix`: OpenCV's camera matrix is expected")?;
    let [fx, _, cx, _, fy, cy, _, _, _] = matrix[..] else {
        return Err(format!("camera_matrix: {} values instead of 9", matrix.len()));
    };
    let distortion = first(&["distortion_coefficients", "dist_coeffs", "distCoeffs", "D"]);
    let side = |names: &[&str]| first(names).and_then(|list| list.first().copied());
    let sensor = side(&["image_width", "width"])
        .zip(side(&["image_height", "height"]))
        .map(|(width, height)| [width, height]);
    let fields = ["image_width", "camera_matrix", "camera_matrix", "distortion_coefficients"];
    checked(sensor, [fx, fy, cx, cy], &distortion.unwrap_or_default(), fields)
}

/// The values behind a key of YAML: on its line, or in the `data` list below it.
fn yaml_values(text: &str) -> impl Fn(&str) -> Option<Vec<f64>> {
    move |key: &str| {
        let lines: Vec<&str> = text.lines().collect();
        let at = lines.iter().position(|line| {
            line.trim_start().strip_prefix(key).is_some_and(|rest| rest.starts_with(':'))
        })?;
        let own = lines[at].split_once(':')?.1.trim();
        if let Ok(number) = own.parse::<f64>() {
            return Some(vec![number]);
        }
        let below = lines[at..].join(" ");
        let below = match below.find("data:") {
            Some(data) if !own.starts_with('[') => below[data..].to_owned(),
            _ => below,
        };
        let list = below.split_once('[')?.1.split_once(']')?.0;
        list.split(',').map(|word| word.trim().parse().ok()).collect()
    }
}

/// The values inside an element of XML, or inside the `data` element in it.
fn xml_values(text: &str) -> impl Fn(&str) -> Option<Vec<f64>> {
    move |key: &str| {
        let inside = |text: &str, key: &str| -> Option<String> {
            let open = text.find(&format!("<{key}>")).or_else(|| text.find(&format!("<{key} ")))?;
            let begin = open + text[open..].find('>')? + 1;
            let end = begin + text[begin..].find(&format!("</{key}>"))?;
            Some(text[begin..end].to_owned())
        };
        let element = inside(text, key)?;
        let data = inside(&element, "data").unwrap_or(element);
        data.split_whitespace().map(|word| word.parse().ok()).collect()
    }
}

#[cfg(test)]
mod tests;
