//! Events of a sensor as events of a canonical view, and positions back.
//!
//! # Model
//! A pixel of the canonical view sees the mean logarithmic luminance of the sensor's pixels that it
//! covers. An event changes its pixel's by one contrast threshold, so the view's pixel changes by
//! the share of its area that the sensor's pixel covers. Where the change since its last event
//! reaches seven tenths of a threshold, it has an event itself, of that polarity, and one threshold
//! is taken off. An edge of some contrast then makes as many events per canonical pixel for every
//! resolution; noise that is independent among `n` pixels makes far fewer, and events of both
//! polarities cancel.
//!
//! At a whole threshold, edges that pass a part of a pixel, or have two sides in it, would be gone:
//! fingers before a sensor of 1280x720 were. Half a threshold lets more noise through; between, .7
//! was best for networks of hands and of bodies (docs/guide/networks.md).
//!
//! If polarities say nothing (all are one, or random: see [`ViewAdaptor::has_lost_polarities`]), an
//! event of any of them counts as a step in one direction: edges then pool as they should, and noise
//! does not cancel.
//!
//! If the sensor is coarser than the view, each event is one of all canonical pixels that its
//! pixel covers.
//!
//! # Source
//! Gruel et al., *Event Data Downscaling for Embedded Computer Vision*, VISAPP 2022: downscaling by
//! the log-luminance. Shares of areas and lens distortion are ours.

use evpose_core::{Event, EventStream, Polarity, SensorSize};
use glam::{DVec2, Vec2};

use crate::polarity::PolarityEvidence;
use crate::{Calibration, CanonicalView};

/// Steps of the iteration that inverts the lens distortion.
const INVERSE_STEPS: u32 = 20;
/// Largest error of a direction in pixels at which a sensor's pixel is used.
const MAX_ERROR_PX: f64 = 0.5;
/// Shares of a canonical pixel that are dropped: rounding.
const MIN_SHARE: f32 = 1e-3;
/// Change at which there is an event, in thresholds.
const THRESHOLD: f32 = 0.7;

/// Maps the events of one sensor to a canonical view.
#[derive(Debug, Clone)]
pub struct ViewAdaptor {
    calibration: Calibration,
    view: CanonicalView,
    /// Start of the canonical pixels of each sensor pixel in `covered`, and the end of the last.
    starts: Vec<u32>,
    /// Index of a canonical pixel, and the share of it that the sensor's pixel covers.
    covered: Vec<(u32, f32)>,
    /// Change of each canonical pixel since its last event, in contrast thresholds.
    change: Vec<f32>,
    polarity: PolarityEvidence,
    is_identity: bool,
}

impl ViewAdaptor {
    /// Prepares the map from a sensor to a view.
    pub fn new(calibration: &Calibration, view: &CanonicalView) -> Self {
        let sensor = calibration.sensor;
        // One list for all pixels, cut by `starts`: a `Vec` for each would miss the cache at
        // events.
        let mut starts = Vec::with_capacity(sensor.pixels() + 1);
        let mut covered = Vec::new();
        for y in 0..sensor.height {
            for x in 0..sensor.width {
                starts.push(covered.len() as u32);
                cover(calibration, view, [x, y], &mut covered);
            }
        }
        starts.push(covered.len() as u32);
        // Each pixel covers the one at its own place alone: events may pass unchanged.
        let is_identity = sensor == view.sensor
            && covered.len() == sensor.pixels()
            && covered.iter().enumerate().all(|(i, (cell, _))| i == *cell as usize);
        let change = vec![0.0; view.sensor.pixels()];
        let polarity = PolarityEvidence::new(sensor);
        let calibration = calibration.clone();
        Self { calibration, view: *view, starts, covered, change, polarity, is_identity }
    }

    /// The view.
    pub fn view(&self) -> &CanonicalView {
        &self.view
    }

    /// The camera whose events come in.
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// Whether events stay as they are: the sensor's pixels are those of the view.
    pub fn is_identity(&self) -> bool {
        self.is_identity
    }

    /// Writes the events of the view to `out`, which loses what it held.
    ///
    /// # Panics
    /// If `events` or `out` are of other sensors than were given.
    pub fn push(&mut self, events: &EventStream, out: &mut EventStream) {
        let sensor = self.calibration.sensor;
        assert!(events.sensor() == sensor, "events of another sensor");
        assert!(out.sensor() == self.view.sensor, "memory for another view");
        out.clear();
        let (width, view_width) = (usize::from(sensor.width), u32::from(self.view.sensor.width));
        for event @ Event { t, x, y, polarity } in events.iter() {
            if self.polarity.push(&event) {
                // Steps so far were as many, in whichever direction.
                self.change.iter_mut().for_each(|change| *change = change.abs());
            }
            let pixel = usize::from(y) * width + usize::from(x);
            let (start, end) = (self.starts[pixel], self.starts[pixel + 1]);
            let is_up = polarity == Polarity::On || self.polarity.is_lost();
            let sign = if is_up { 1.0 } else { -1.0 };
            for &(cell, share) in &self.covered[start as usize..end as usize] {
                let change = &mut self.change[cell as usize];
                *change += sign * share;
                if sign * *change >= THRESHOLD {
                    // One for each threshold of change, on average.
                    *change -= sign;
                    let (x, y) = ((cell % view_width) as u16, (cell / view_width) as u16);
                    // In the view and in order, as the events themselves.
                    let _ = out.push(Event { t, x, y, polarity });
                }
            }
        }
    }

    /// Whether polarities say nothing, as far as events have shown: they are all the same, or noise.
    pub fn has_lost_polarities(&self) -> bool {
        self.polarity.is_lost()
    }

    /// Forgets all events.
    pub fn reset(&mut self) {
        self.change.fill(0.0);
        self.polarity = PolarityEvidence::new(self.calibration.sensor);
    }

    /// Position on the sensor, in pixels, of a position in the view.
    pub fn sensor_from_view(&self, view_px: Vec2) -> Vec2 {
        let pinhole = &self.view.pinhole;
        let direction = (view_px - pinhole.principal_px) / pinhole.focal_px;
        self.calibration.camera.image_from_direction(direction.as_dvec2()).as_vec2()
    }

    /// Position in the view, in pixels, of a position on the sensor; none where the inverse of the
    /// distortion does not converge.
    pub fn view_from_sensor(&self, sensor_px: Vec2) -> Option<Vec2> {
        view_position(&self.calibration, &self.view, sensor_px.as_dvec2()).map(DVec2::as_vec2)
    }

    /// Size of the sensor.
    pub fn sensor(&self) -> SensorSize {
        self.calibration.sensor
    }
}

/// Position in a view of a position on a sensor.
fn view_position(calibration: &Calibration, view: &CanonicalView, at_px: DVec2) -> Option<DVec2> {
    let ray = calibration.camera.direction_from_image(at_px, INVERSE_STEPS);
    (ray.error_px <= MAX_ERROR_PX).then(|| {
        let pinhole = &view.pinhole;
        pinhole.principal_px.as_dvec2() + ray.direction * f64::from(pinhole.focal_px)
    })
}

/// Adds the canonical pixels that a sensor's pixel covers, with their shares.
///
/// The pixel's image is taken as the upright rectangle around its corners.
fn cover(
    calibration: &Calibration,
    view: &CanonicalView,
    [x, y]: [u16; 2],
    covered: &mut Vec<(u32, f32)>,
) {
    let corner = DVec2::new(f64::from(x), f64::from(y));
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for offset in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] {
        // A corner at which the inverse of the distortion fails: its pixel covers nothing.
        let Some(at) = view_position(calibration, view, corner + offset) else { return };
        (low, high) = (low.min(at), high.max(at));
    }
    let size = [view.sensor.width, view.sensor.height].map(f64::from);
    // Beyond the view the range is empty.
    let cells = |low: f64, high: f64, side: f64| {
        (low.floor().max(0.0) as u32)..(high.ceil().clamp(0.0, side) as u32)
    };
    let overlap = |low: f64, high: f64, cell: u32| {
        let cell = f64::from(cell);
        (high.min(cell + 1.0) - low.max(cell)).max(0.0)
    };
    for row in cells(low.y, high.y, size[1]) {
        for column in cells(low.x, high.x, size[0]) {
            let share = overlap(low.x, high.x, column) * overlap(low.y, high.y, row);
            if share as f32 >= MIN_SHARE {
                covered.push((row * u32::from(view.sensor.width) + column, share as f32));
            }
        }
    }
}

#[cfg(test)]
mod tests;
