//! Scene directories: `scene.json`, and luminance frames in `frames.npy` or `frames/`.

use std::path::{Path, PathBuf};

use evpose_core::{Plane, SensorSize};
use evpose_io::{Encoding, FrameSource};

use super::{Description, Nominal};
use crate::{GapError, LightSequence};

/// A scene with its provenance and notes.
#[derive(Debug, Clone)]
pub struct LoadedScene {
    /// Luminance over time.
    pub scene: LightSequence,
    /// Nominal values of the sensor.
    pub nominal: Option<Nominal>,
    /// Stated length of the recording, seconds.
    pub duration_s: f64,
    /// Path of the frames.
    pub frames_path: PathBuf,
    /// Provenance, a line per file.
    pub provenance: Vec<String>,
    /// Notes for the user, a line each.
    pub notes: Vec<String>,
}

/// Tolerance of the number of frames: some programs count both ends, and some round the rate.
const SPARE_FRAMES: f64 = 1.5;

/// Reads a scene directory. Frames are linear luminance.
///
/// # Errors
/// A file or field that is missing or invalid, and frames that contradict the fields.
pub fn load_scene(dir: impl AsRef<Path>) -> Result<LoadedScene, GapError> {
    let dir = dir.as_ref();
    let json = dir.join("scene.json");
    let description = Description::read(&json)?;
    let field = |field: &str, problem: String| GapError::Field {
        path: json.clone(),
        field: field.to_owned(),
        problem,
    };
    let mut notes = Vec::new();
    for key in &description.unknown {
        notes.push(format!("{}: `{key}` is not used", json.display()));
    }
    let frames_path = frames_of(dir, &mut notes)?;
    let mut source = FrameSource::open(&frames_path, Encoding::Linear, description.white)?;
    let (got, size) = (source.size(), description.size);
    if got != size {
        let name = if got.width == size.width { "height" } else { "width" };
        let turned = SensorSize { width: size.height, height: size.width };
        let hint = if got == turned { ": width and height are swapped" } else { "" };
        let frames = frames_path.display();
        return Err(field(name, format!("{size}, but frames of {frames} are {got}{hint}")));
    }
    let expected = description.fps * description.duration_s;
    let frames = source.frames();
    let spare = frames as f64 - expected;
    if spare.abs() > SPARE_FRAMES {
        let problem = format!(
            "{} s at {} frames per second are {expected:.1} frames, but {} has {frames}",
            description.duration_s,
            description.fps,
            frames_path.display()
        );
        return Err(field("duration_s", problem));
    }
    // A sequence of n frames may be meant to last n or n - 1 intervals: both are taken.
    if spare < 0.5 {
        let last_s = (frames as f64 - 1.0) / description.fps;
        notes.push(format!(
            "the last of {frames} frames is seen at {last_s:.4} s: the rest of {} s is not compared",
            description.duration_s
        ));
    }
    notes.extend(source.note().map(str::to_owned));
    let planes = read_all(&mut source, &mut notes)?;
    let provenance = vec![
        format!(
            "{}: {size}, {} frames per second, {} s",
            json.display(),
            description.fps,
            description.duration_s
        ),
        format!(
            "{}: {frames} frames, {}, white {}",
            frames_path.display(),
            source.depth(),
            source.white()
        ),
    ];
    let scene = LightSequence::new(description.fps, planes)?;
    let (nominal, duration_s) = (description.nominal, description.duration_s);
    Ok(LoadedScene { scene, nominal, duration_s, frames_path, provenance, notes })
}

fn frames_of(dir: &Path, notes: &mut Vec<String>) -> Result<PathBuf, GapError> {
    let (array, folder) = (dir.join("frames.npy"), dir.join("frames"));
    match (array.is_file(), folder.is_dir()) {
        (true, both) => {
            if both {
                notes.push(format!("{} is not used beside frames.npy", folder.display()));
            }
            Ok(array)
        }
        (false, true) => Ok(folder),
        (false, false) => Err(GapError::Scene(format!(
            "{}: neither frames.npy nor a folder frames/",
            dir.display()
        ))),
    }
}

/// Maximum pixels times frames that are compared: what is computed of them takes about 4 GB.
const MAX_PIXEL_FRAMES: usize = 200_000_000;

fn read_all(
    source: &mut FrameSource,
    notes: &mut Vec<String>,
) -> Result<Vec<Plane<f32>>, GapError> {
    let (frames, pixels) = (source.frames() as usize, source.size().pixels());
    let most = (MAX_PIXEL_FRAMES / pixels.max(1)).max(2);
    if frames > most {
        notes.push(format!(
            "{}: of {frames} frames the first {most} are compared: more do not fit into 4 GB",
            source.path().display()
        ));
    }
    let mut planes = Vec::new();
    let mut frame = Plane::for_sensor(source.size(), 0.0);
    let (mut repaired, mut brightest) = (0usize, 0f32);
    while planes.len() < most && source.next_into(&mut frame)? {
        for light in frame.data_mut() {
            // What follows takes logarithms of light.
            if !(light.is_finite() && *light >= 0.0) {
                *light = 0.0;
                repaired += 1;
            }
            brightest = brightest.max(*light);
        }
        planes.push(frame.clone());
    }
    let path = source.path().display();
    if repaired > 0 {
        notes
            .push(format!("{path}: {repaired} values that are negative or no number are darkness"));
    }
    if brightest <= 0.0 {
        return Err(GapError::Scene(format!("{path}: there is no light in any frame")));
    }
    // Codes without a stated white come out hundreds of times too bright, or too dark.
    if !(0.02..=4.0).contains(&brightest) {
        notes.push(format!(
            "{path}: the brightest light is {brightest:.3} of white ({}); is `white` right?",
            source.white()
        ));
    }
    Ok(planes)
}
