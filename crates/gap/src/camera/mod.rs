//! A camera from recordings whose light is not known.
//!
//! # Method
//! An effect that both halves of a recording show ([`test_recording`](crate::surrogate::scene_free::test_recording)) has
//! parameters, with intervals of 95 % by Student's t of the halves, and not below the resolution of the estimator. Rates
//! of pixels at rest are those of `evpose calibrate noise`. Values of the camera are pooled over its recordings; those
//! of the light stay with each of them. What is not known has a reason, and the recording that would show it.

mod pool;
mod preset;
mod recording;
mod threshold_ratio;

use evpose_core::stats::interval::Interval;
use serde::Serialize;

use crate::GapError;
pub use recording::{CameraRecording, Reading};

/// Source of a quantity.
#[derive(Debug, Clone, Copy)]
enum Source {
    /// Counts of events, by a method of its own.
    Counts,
    /// A parameter of an effect that halves of a recording show: names of both, and the resolution of the estimator,
    /// relative and absolute.
    Effect(&'static str, &'static str, [f64; 2]),
    /// Nothing that is recorded in unknown light, for this reason.
    Nothing(&'static str),
}

/// A quantity that is looked for.
struct Spec {
    name: &'static str,
    source: Source,
    /// Whether all recordings of a camera have one value.
    is_of_camera: bool,
    /// A recording that would show it.
    would_show: &'static str,
}

const fn of_camera(name: &'static str, source: Source, would_show: &'static str) -> Spec {
    Spec { name, source, is_of_camera: true, would_show }
}

const fn of_light(name: &'static str, source: Source, would_show: &'static str) -> Spec {
    Spec { name, source, is_of_camera: false, would_show }
}

const PAN: &str = "a slow pan over a printed page to and fro, with a second of rest";
const FAST: &str = "noisy pixels in the dark, or a fast pan over a printed page";
const STATIC: &str = "a static scene for a minute, in light that does not flicker";
const LONG: &str = "a static scene, long enough for five ON events of a pixel";
const FRAMES: &str = "frames of the scene beside the events, `evpose calibrate threshold`";
const SCENE: &str = "known light over the whole image, `evpose gap run --scene DIR`";
const LED: &str =
    "an LED that flashes at known times, at each light level, `evpose gap run --scene DIR`";

/// All quantities, in the order of a report.
static QUANTITIES: [Spec; 14] = [
    of_camera("threshold_ratio", Source::Counts, PAN),
    of_camera("leak_hz", Source::Counts, LONG),
    // The shortest of thirty intervals in a fifth of the period is up to 2 % above it.
    of_camera("refractory_us", Source::Effect("refractory", "period_us", [0.02, 1.0]), FAST),
    of_camera("scan_period_us", Source::Effect("scanned_readout", "period_us", [0.0, 0.01]), PAN),
    of_camera(
        "clock_period_us",
        Source::Effect("timestamp_quantisation", "period_us", [0.0, 0.01]),
        PAN,
    ),
    of_camera("hot_fraction", Source::Counts, STATIC),
    of_camera("hot_hz", Source::Effect("hot_pixels", "median_hz", [0.1, 0.0]), STATIC),
    of_camera("hot_on_share", Source::Effect("hot_pixels", "on_share", [0.0, 0.05]), STATIC),
    of_light("background_on_hz", Source::Counts, STATIC),
    of_light("background_off_hz", Source::Counts, STATIC),
    of_light(
        "lamp_hz",
        Source::Effect("lamp_flicker", "frequency_hz", [0.0, 1.0]),
        "a static scene near the lamp",
    ),
    of_camera(
        "thresholds",
        Source::Nothing("twice the contrast at twice the thresholds has the same events"),
        FRAMES,
    ),
    of_camera("mismatch", Source::Nothing("pixels with more events may have more contrast"), SCENE),
    of_light("bandwidth", Source::Nothing("times of the light are not known"), LED),
];

/// A quantity with its estimates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// Name, with its unit.
    pub name: &'static str,
    /// Whether recordings are pooled.
    pub is_of_camera: bool,
    /// Value of the camera with its interval of 95 %; none where it is not known.
    pub value: Option<Interval>,
    /// Reason why it is not known.
    pub why: Option<String>,
    /// A recording that would show it.
    pub would_show: &'static str,
    /// By recording, in their order.
    pub readings: Vec<Reading>,
}

/// A camera as its recordings show it.
#[derive(Debug, Clone, Serialize)]
pub struct CameraReport {
    /// The recordings.
    pub recordings: Vec<CameraRecording>,
    /// All quantities.
    pub quantities: Vec<Quantity>,
    /// Pixels (column, row) that are hot in every recording at rest that has hot pixels.
    pub hot_pixels: Vec<(u16, u16)>,
}

impl CameraReport {
    /// Estimates a camera from its recordings.
    ///
    /// # Errors
    /// No recordings, one of them twice, or those of different sensors.
    pub fn new(recordings: Vec<CameraRecording>) -> Result<Self, GapError> {
        let refused = |why: String| Err(GapError::Recording(why));
        let Some(first) = recordings.first() else { return refused("none".to_owned()) };
        let size = first.events.sensor();
        for (i, CameraRecording { name, events, .. }) in recordings.iter().enumerate() {
            if recordings[..i].iter().any(|one| one.name == *name) {
                return refused(format!("{name}: given twice"));
            }
            if events.sensor() != size {
                let sizes = format!("{name} {}", events.sensor());
                return refused(format!("{} is of {size}, {sizes}: set --sensor", first.name));
            }
        }
        let at_rest = recordings.iter().filter(|one| one.is_at_rest);
        let hot = at_rest.map(CameraRecording::hot_pixels).filter(|hot| !hot.is_empty());
        let hot = hot.reduce(|a, b| a.intersection(&b).copied().collect()).unwrap_or_default();
        // Pixels at rest have these events beside those of the light.
        let lent = recordings.iter().find_map(CameraRecording::rest_hz);
        let quantity = |spec: &Spec| {
            let readings = recordings.iter().map(|one| match spec.name {
                "threshold_ratio" => threshold_ratio::read(one, lent),
                _ => one.read(spec, hot.len()),
            });
            spec.pooled(readings.collect())
        };
        let quantities = QUANTITIES.iter().map(quantity).collect();
        Ok(Self { recordings, quantities, hot_pixels: hot.into_iter().collect() })
    }

    /// A quantity by its name.
    pub fn quantity(&self, name: &str) -> Option<&Quantity> {
        self.quantities.iter().find(|quantity| quantity.name == name)
    }
}
