//! The calibration of a camera: size, focal length, principal point, distortion.

use std::path::Path;

use evpose_core::{Distortion, LensCamera, Registry, SensorSize, registry_entry};
use glam::DVec2;

use crate::CalibrationError;
use crate::file_formats::{CameraOfFile, read_file};

/// Vertical field of view that is assumed where nothing is known, in degrees: a lens of 5 to 6 mm
/// before the chip of a DAVIS346 or DVXplorer, and that of the published hands.
const GUESSED_FOV_DEG: f64 = 45.0;
/// Largest relative difference of aspect ratios at which a calibration of another size is scaled.
const SAME_ASPECT: f64 = 0.02;

/// A camera whose field of view is known by its name, with the lens it is sold with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedCamera {
    /// Name on the command line.
    pub name: &'static str,
    /// Its sensor.
    pub sensor: SensorSize,
    /// Pitch of its pixels, in micrometres.
    pub pitch_um: f64,
    /// Focal length of the lens it is sold with, in millimetres.
    pub lens_mm: f64,
}

const fn camera(
    name: &'static str,
    [width, height]: [u16; 2],
    pitch_um: f64,
    lens_mm: f64,
) -> NamedCamera {
    NamedCamera { name, sensor: SensorSize { width, height }, pitch_um, lens_mm }
}

/// Cameras known by name. Pixel pitches are of the makers' data sheets, focal lengths those of the
/// lenses of their kits; whoever mounts another lens should calibrate it.
pub static NAMED_CAMERAS: Registry<NamedCamera> = Registry::new(&[
    &camera("dvs128", [128, 128], 40.0, 4.5),
    &camera("davis240c", [240, 180], 18.5, 4.5),
    &camera("davis346", [346, 260], 18.5, 6.0),
    &camera("dvxplorer", [640, 480], 9.0, 6.0),
    &camera("dvxplorer-mini", [640, 480], 9.0, 3.6),
    &camera("evk3-hd", [1280, 720], 4.86, 5.0),
    &camera("evk4", [1280, 720], 4.86, 5.0),
]);

registry_entry!(NamedCamera, "camera");

/// Origin of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub enum CalibrationSource {
    /// A file.
    File(String),
    /// The camera of a rig, or of a simulation.
    Lens,
    /// The name of a camera.
    Named(&'static str),
    /// A vertical field of view in degrees.
    FieldOfView(f64),
    /// Nothing: a field of view of 45 degrees, without distortion.
    Guessed,
}

/// A camera with its sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The sensor.
    pub sensor: SensorSize,
    /// Focal lengths, principal point and distortion.
    pub camera: LensCamera,
    /// Origin of these values.
    pub source: CalibrationSource,
    /// Assumptions, for the user.
    pub note: Option<String>,
}

impl Calibration {
    /// The camera that `choice` describes: a calibration file, the name of a camera, a vertical
    /// field of view such as `45deg`; guessed without one. `sensor` is that of the recording.
    ///
    /// A calibration of another resolution with the same aspect ratio is scaled; of another aspect
    /// ratio it is replaced by a guess. Both leave a note.
    ///
    /// # Errors
    /// If a file cannot be read, or the text is none of these.
    pub fn choose(choice: Option<&str>, sensor: SensorSize) -> Result<Self, CalibrationError> {
        let Some(text) = choice else { return Ok(Self::guessed(sensor)) };
        if let Some(named) = NAMED_CAMERAS.find(text) {
            let focal_px = named.lens_mm * 1e3 / named.pitch_um;
            let source = CalibrationSource::Named(named.name);
            return Ok(Self::ideal(named.sensor, focal_px, source).fitted_to(sensor));
        }
        let degrees = text.strip_suffix("deg").and_then(|text| text.trim().parse::<f64>().ok());
        if let Some(degrees) = degrees.filter(|degrees| (1.0..179.0).contains(degrees)) {
            return Ok(Self::from_vertical_fov(sensor, degrees));
        }
        let path = Path::new(text);
        // Neither an ending nor a file: a name that is not known.
        if path.extension().is_none() && !path.exists() {
            let known = NAMED_CAMERAS.names();
            return Err(CalibrationError::Unknown { text: text.to_owned(), known });
        }
        Ok(Self::of_file(path, sensor)?.fitted_to(sensor))
    }

    /// The camera of a calibration file, as it stands there; `sensor` where the file does not state it.
    ///
    /// # Errors
    /// If the file cannot be read, or is of none of the formats.
    pub fn of_file(path: &Path, sensor: SensorSize) -> Result<Self, CalibrationError> {
        let CameraOfFile { sensor: calibrated, camera } = read_file(path)?;
        let source = CalibrationSource::File(path.display().to_string());
        Ok(Self { sensor: calibrated.unwrap_or(sensor), camera, source, note: None })
    }

    /// A camera without distortion of a vertical field of view in degrees.
    pub fn from_vertical_fov(sensor: SensorSize, degrees: f64) -> Self {
        let focal_px = focal_of_fov(sensor, degrees);
        Self::ideal(sensor, focal_px, CalibrationSource::FieldOfView(degrees))
    }

    /// A calibrated camera.
    pub fn of_lens(sensor: SensorSize, camera: LensCamera) -> Self {
        Self { sensor, camera, source: CalibrationSource::Lens, note: None }
    }

    /// A camera of which nothing is known.
    pub fn guessed(sensor: SensorSize) -> Self {
        let focal_px = focal_of_fov(sensor, GUESSED_FOV_DEG);
        let note = format!(
            "no calibration: a vertical field of view of {GUESSED_FOV_DEG} degrees is assumed; \
             distances in metres are in proportion to the true focal length (--camera)"
        );
        let guess = Self::ideal(sensor, focal_px, CalibrationSource::Guessed);
        Self { note: Some(note), ..guess }
    }

    fn ideal(sensor: SensorSize, focal_px: f64, source: CalibrationSource) -> Self {
        let camera = LensCamera {
            focal_px: DVec2::splat(focal_px),
            principal_px: 0.5 * size_px(sensor),
            distortion: Distortion::default(),
        };
        Self { sensor, camera, source, note: None }
    }

    /// The same camera read out at another resolution.
    fn fitted_to(self, sensor: SensorSize) -> Self {
        if self.sensor == sensor {
            return self;
        }
        let (from, to) = (size_px(self.sensor), size_px(sensor));
        let scale = to / from;
        // Of another shape it is a crop, and nobody knows of which part.
        if (scale.x / scale.y - 1.0).abs() > SAME_ASPECT {
            let note = format!(
                "the calibration is of a sensor of {}, the recording of {sensor}: a field of view \
                 of {GUESSED_FOV_DEG} degrees is assumed instead",
                self.sensor
            );
            return Self { note: Some(note), ..Self::guessed(sensor) };
        }
        let note = format!("the calibration of a sensor of {} is scaled to {sensor}", self.sensor);
        // Coordinates count from the corner of the first pixel: the principal point scales alike.
        let camera = LensCamera {
            focal_px: self.camera.focal_px * scale,
            principal_px: self.camera.principal_px * scale,
            ..self.camera
        };
        Self { sensor, camera, note: Some(note), ..self }
    }
}

/// Width and height in pixels.
pub(crate) fn size_px(sensor: SensorSize) -> DVec2 {
    DVec2::new(f64::from(sensor.width), f64::from(sensor.height))
}

fn focal_of_fov(sensor: SensorSize, vertical_deg: f64) -> f64 {
    0.5 * f64::from(sensor.height) / (0.5 * vertical_deg.to_radians()).tan()
}

#[cfg(test)]
mod tests {
    use super::*;

    const VGA: SensorSize = SensorSize { width: 640, height: 480 };

    #[test]
    fn names_fields_of_view_and_nothing_are_taken() {
        let fov = Calibration::choose(Some("90deg"), VGA).unwrap();
        assert!((fov.camera.focal_px.y - 240.0).abs() < 1e-9);
        let named = Calibration::choose(Some("davis240c"), SensorSize::DAVIS240C).unwrap();
        assert!((named.camera.focal_px.x - 243.2).abs() < 0.1 && named.note.is_none());
        let guessed = Calibration::choose(None, VGA).unwrap();
        assert_eq!(guessed.source, CalibrationSource::Guessed);
        assert!(guessed.note.unwrap().contains("--camera"));
        let error = Calibration::choose(Some("dvs129"), VGA).unwrap_err().to_string();
        assert!(error.contains("dvs128") && error.contains("45deg"), "{error}");
    }

    #[test]
    fn named_cameras_have_the_focal_length_of_their_lens_over_the_pitch_of_their_pixels() {
        for named in &NAMED_CAMERAS {
            let camera = Calibration::choose(Some(named.name), named.sensor).unwrap();
            let focal_px = named.lens_mm / (1e-3 * named.pitch_um);
            assert!((camera.camera.focal_px - focal_px).abs().max_element() < 1e-9);
            assert_eq!(camera.camera.principal_px, 0.5 * size_px(named.sensor));
            assert_eq!(camera.source, CalibrationSource::Named(named.name));
            assert_eq!((camera.sensor, camera.note), (named.sensor, None));
        }
    }

    #[test]
    fn fields_of_view_are_taken_from_one_degree_to_below_a_half_turn() {
        for (degrees, is_taken) in [(0.9, false), (1.0, true), (178.9, true), (179.0, false)] {
            let camera = Calibration::choose(Some(&format!("{degrees}deg")), VGA);
            assert_eq!(camera.is_ok(), is_taken, "{degrees}");
            if let Ok(camera) = camera {
                let half = (240.0 / camera.camera.focal_px.y).atan().to_degrees();
                assert!((2.0 * half - degrees).abs() < 1e-9, "{half}");
                assert_eq!(camera.source, CalibrationSource::FieldOfView(degrees));
            }
        }
        let missing = Calibration::choose(Some("no/such.yaml"), VGA).unwrap_err();
        assert!(matches!(missing, CalibrationError::File { .. }), "{missing}");
    }

    #[test]
    fn a_calibration_of_nearly_the_same_shape_is_scaled_along_each_axis() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.toml");
        let text = "sensor = { width = 640, height = 480 }\nfocal_px = [600.0, 610.0]\n\
                    principal_px = [330.0, 250.0]\n";
        std::fs::write(&path, text).unwrap();
        let read = |width, height| {
            Calibration::choose(path.to_str(), SensorSize { width, height }).unwrap()
        };
        // 2 % of the shape is the limit: 326 instead of 320 columns are within, 328 beyond.
        let scaled = read(326, 240);
        assert_eq!(scaled.sensor, SensorSize { width: 326, height: 240 });
        let (across, down) = (326.0 / 640.0, 0.5);
        assert_eq!(scaled.camera.focal_px, DVec2::new(600.0 * across, 610.0 * down));
        assert_eq!(scaled.camera.principal_px, DVec2::new(330.0 * across, 250.0 * down));
        assert!(scaled.note.unwrap().contains("640x480 is scaled to 326x240"));
        for width in [328, 312] {
            let guessed = read(width, 240);
            assert_eq!(guessed.camera, Calibration::guessed(guessed.sensor).camera);
            assert!(guessed.note.unwrap().contains("640x480"));
        }
        let own = read(640, 480);
        assert_eq!((own.camera.focal_px, own.note), (DVec2::new(600.0, 610.0), None));
    }

    #[test]
    fn half_the_resolution_is_scaled_and_another_shape_is_guessed() {
        let half = SensorSize { width: 320, height: 240 };
        let scaled = Calibration::choose(Some("dvxplorer"), half).unwrap();
        assert!((scaled.camera.focal_px.x - 1000.0 / 3.0).abs() < 1e-9);
        assert!(scaled.note.unwrap().contains("scaled"));
        let other = Calibration::choose(Some("dvs128"), half).unwrap();
        assert_eq!(other.source, CalibrationSource::Guessed);
    }
}
