//! Files of calibrations: OpenCV's, ROS's, kalibr's, DSEC's and rpg's YAML, OpenCV's XML,
//! dv-processing's JSON, rpg's line of values, our TOML.

mod entry;

use std::path::Path;

use evpose_core::{LensCamera, SensorSize, without_bom};

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
    let malformed = |fault: CalibrationError| CalibrationError::Malformed {
        path: path.to_owned(),
        reason: fault.to_string(),
    };
    let text = without_bom(&text);
    // By content, which differs from format to format: the extension does not matter.
    let begin = text.trim_start();
    if begin.starts_with('{') {
        return dv_processing(text).map_err(malformed);
    }
    if begin.starts_with("<?xml") || begin.starts_with("<opencv_storage") {
        return entry::of_xml(begin).and_then(|entries| opencv(&entries)).map_err(malformed);
    }
    if let Some(values) = plain_values(text) {
        return of_values(&values).map_err(malformed);
    }
    if is_yaml(text) {
        return entry::of_yaml(text).and_then(|entries| opencv(&entries)).map_err(malformed);
    }
    // What is of no other format is taken for ours, whose errors name the fields.
    let file = CameraFile::load(path)?;
    Ok(CameraOfFile { sensor: Some(file.sensor), camera: file.camera()? })
}

/// The fault of a content, whose file [`read_file`] names.
fn invalid(reason: impl std::fmt::Display) -> CalibrationError {
    CalibrationError::Invalid { reason: reason.to_string() }
}

/// The values of a text that has nothing else.
fn plain_values(text: &str) -> Option<Vec<f64>> {
    let words = text.split([' ', '\t', ',', '\r', '\n']).filter(|word| !word.is_empty());
    let values: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
    values.filter(|values| !values.is_empty())
}

/// The `calib.txt` of the Event Camera Dataset and others of the Robotics and Perception Group.
fn of_values(values: &[f64]) -> Result<CameraOfFile, CalibrationError> {
    match values {
        // Eight may be those of a fisheye lens, as EVIMO's: nothing says so.
        [fx, fy, cx, cy, distortion @ ..] if [0, 5].contains(&distortion.len()) => {
            let lens = Lens { coefficients: distortion, is_fisheye: false };
            checked(
                None,
                [*fx, *fy, *cx, *cy],
                lens,
                ["", "the first two", "the next two", "the rest"],
            )
        }
        _ => Err(invalid(format!(
            "{} values, and `fx fy cx cy` or `fx fy cx cy k1 k2 p1 p2 k3` are read: name them in a TOML \
             file (sensor, focal_px, principal_px, distortion, fisheye)",
            values.len()
        ))),
    }
}

/// Coefficients of distortion, and the model of the lens.
#[derive(Debug, Clone, Copy)]
struct Lens<'a> {
    coefficients: &'a [f64],
    is_fisheye: bool,
}

/// The camera of OpenCV's intrinsics, whose pixel centres lie at whole numbers; `fields` are those of
/// the size, the focal lengths, the principal point and the distortion.
fn checked(
    sensor: Option<[f64; 2]>,
    [fx, fy, cx, cy]: [f64; 4],
    lens: Lens<'_>,
    [size, fields @ ..]: [&str; 4],
) -> Result<CameraOfFile, CalibrationError> {
    let is_side = |side: &f64| side.fract() == 0.0 && (1.0..=f64::from(u16::MAX)).contains(side);
    if let Some(sides) = sensor.filter(|sides| !sides.iter().all(is_side)) {
        return Err(invalid(format!("{size}: a sensor of {sides:?} pixels")));
    }
    let sensor =
        sensor.map(|[width, height]| SensorSize { width: width as u16, height: height as u16 });
    let of_file =
        if lens.is_fisheye { LensCamera::fisheye_from_file } else { LensCamera::from_file };
    // Files count from the centre of the first pixel, cameras here from its corner.
    let camera = of_file([fx, fy], [cx + 0.5, cy + 0.5], lens.coefficients);
    let camera = camera.map_err(|error| invalid(error.in_field(fields)))?;
    Ok(CameraOfFile { sensor, camera })
}

/// The first camera of dv-processing's set of calibrations.
fn dv_processing(text: &str) -> Result<CameraOfFile, CalibrationError> {
    let root: serde_json::Value = serde_json::from_str(text).map_err(invalid)?;
    let camera = root.get("cameras").and_then(|cameras| cameras.get(0)).ok_or_else(|| {
        invalid("`cameras` with at least one camera is expected, as dv-processing writes it")
    })?;
    let list_of = |key: &str| -> Result<Vec<f64>, CalibrationError> {
        let list = camera.get(key).and_then(serde_json::Value::as_array);
        let list = list.ok_or_else(|| invalid(format!("cameras[0].{key}: a list is expected")))?;
        let no_number = || invalid(format!("cameras[0].{key}: no number"));
        list.iter().map(|value| value.as_f64().ok_or_else(no_number)).collect()
    };
    let pair = |key: &str| -> Result<[f64; 2], CalibrationError> {
        let list = list_of(key)?;
        list.try_into().map_err(|_| invalid(format!("cameras[0].{key}: two values are expected")))
    };
    let model = camera.get("distortionModel").and_then(serde_json::Value::as_str);
    let is_fisheye = match model.unwrap_or("none") {
        "radialTangential" | "none" => false,
        "equidistant" => true,
        other => {
            return Err(invalid(format!("cameras[0].distortionModel: `{other}` is not supported")));
        }
    };
    let sensor = pair("resolution")?;
    let [fx, fy] = pair("focalLength")?;
    let [cx, cy] = pair("principalPoint")?;
    let distortion =
        if camera.get("distortion").is_some() { list_of("distortion")? } else { vec![] };
    let fields = ["resolution", "focalLength", "principalPoint", "distortion"];
    let lens = Lens { coefficients: &distortion, is_fisheye };
    checked(Some(sensor), [fx, fy, cx, cy], lens, fields)
        .map_err(|fault| invalid(format!("cameras[0].{fault}")))
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
/// OpenCV's programs write the first three, ROS 1 and ROS 2 the next, kalibr the last but one, rpg's
/// the last, below `distortion`.
const DISTORTION: [&str; 7] = [
    "distortion_coefficients",
    "dist_coeffs",
    "distCoeffs",
    "D",
    "d",
    "distortion_coeffs",
    "distortion.parameters",
];
/// Keys that name a model of the lens, the words there for OpenCV's usual one, and those for fisheyes.
const MODELS: [(&str, &[&str], &[&str]); 6] = [
    (
        "distortion_model",
        &["plumb_bob", "rational_polynomial", "radtan", "radialTangential", "none", ""],
        &["equidistant", "equi", "fisheye", "kannala_brandt"],
    ),
    ("camera_model", &["pinhole"], &["fisheye", "kannala_brandt"]),
    ("type", &["pinhole", "camera"], &[]),
    ("distortion.type", &["radial-tangential", "none"], &["equidistant", "fisheye"]),
    ("fisheye_model", &["0", "false"], &["1", "true"]),
    ("use_fisheye_model", &["0", "false"], &["1", "true"]),
];

/// A camera in the keys of OpenCV's calibration, of ROS's and of kalibr's: at the top of the file, or
/// else the first in an entry of its own, as kalibr and DV write it.
fn opencv(entries: &[Entry]) -> Result<CameraOfFile, CalibrationError> {
    let camera = entries
        .iter()
        .filter(|entry| INTRINSICS.contains(&&*entry.key))
        .map(|entry| &entry.above)
        // Of equals `min_by_key` returns the first: a camera at the top wins, else the first entry.
        .min_by_key(|above| !above.is_empty())
        .ok_or_else(|| {
            invalid("no `camera_matrix`, `K` or `intrinsics`, as OpenCV, ROS and kalibr write them")
        })?;
    // A key may have a level of its own above it: `distortion.type`.
    let is_at = |entry: &Entry, above: &str, key: &str| match key.rsplit_once('.') {
        None => entry.above == above && entry.key == key,
        Some((level, key)) => {
            let dot = if above.is_empty() { "" } else { "." };
            entry.above == format!("{above}{dot}{level}") && entry.key == key
        }
    };
    let mut is_fisheye = false;
    for (key, usual, fisheyes) in MODELS {
        let is_own = entries.iter().any(|entry| is_at(entry, camera, key));
        let above = if is_own { camera } else { "" };
        for entry in entries.iter().filter(|entry| is_at(entry, above, key)) {
            let [word] = &entry.words[..] else { continue };
            let is_among = |known: &[&str]| known.iter().any(|k| k.eq_ignore_ascii_case(word));
            match (is_among(usual), is_among(fisheyes)) {
                (false, false) => {
                    return Err(invalid(format!("{entry}: `{word}` is not supported")));
                }
                (_, fisheye) => is_fisheye |= fisheye,
            }
        }
    }
    // The values under the first of `keys` that is there, and their place.
    let list = |keys: &[&str]| -> Result<(String, Vec<f64>), CalibrationError> {
        let find = |above: &str| {
            keys.iter().find_map(|key| entries.iter().find(|entry| is_at(entry, above, key)))
        };
        let Some(entry) = find(camera).or_else(|| find("")) else { return Ok(Default::default()) };
        let number = |word: &String| {
            let refused = |_| invalid(format!("{entry}: `{word}` where a number is expected"));
            word.parse().map_err(refused)
        };
        Ok((entry.to_string(), entry.words.iter().map(number).collect::<Result<_, _>>()?))
    };
    let (at, values) = list(&INTRINSICS)?;
    // OpenCV and ROS write the whole 3x3 matrix by rows, kalibr the four values alone.
    let intrinsics = match values[..] {
        [fx, _, cx, _, fy, cy, _, _, _] | [fx, fy, cx, cy] => [fx, fy, cx, cy],
        _ => return Err(invalid(format!("{at}: {} values instead of 9 or 4", values.len()))),
    };
    // `resolution` has both values in one list, the other keys have one each.
    let (width_at, mut size) = list(&["image_width", "width", "resolution"])?;
    let (height_at, height) = list(&["image_height", "height"])?;
    let size_at = if size.is_empty() { height_at } else { width_at };
    size.extend(height);
    let sensor = match size[..] {
        [] => None,
        [width, height] => Some([width, height]),
        _ => {
            let count = size.len();
            return Err(invalid(format!("{size_at}: {count} values for width and height")));
        }
    };
    let (distortion_at, distortion) = list(&DISTORTION)?;
    let lens = Lens { coefficients: &distortion, is_fisheye };
    checked(sensor, intrinsics, lens, [&size_at, &at, &at, &distortion_at])
}

#[cfg(test)]
mod tests;
