//! Undistortion: every event moves to the pixel at which a camera without distortion, but
//! otherwise the same, would have seen it.
//!
//! The destination of each pixel is computed once, see [`LensCamera`]; an event costs one table
//! lookup. Pixels keep the time and the number of their events: where the lens magnifies, gaps
//! remain, and where it shrinks, several pixels meet in one.
//!
//! The inverse of the lens is an iteration. It has converged where its result, distorted again, is
//! seen within [`TOLERANCE_PX`] of the pixel. Events of the others are removed and counted
//! ([`Inverse::Converged`]), or go to where a given number of steps leads ([`Inverse::Steps`];
//! OpenCV takes five) and their pixels are counted.
//!
//! The preset `davis240c-eventhands` is what EventHands does with real recordings: its camera, five
//! steps, events beyond the image put on its border, coordinates cut off at the point.

use evpose_camera::{Calibration, CameraFile};
use evpose_core::{EventStream, FileSpec, LensCamera, Parameter, SensorSize, WordSpec};
use glam::DVec2;

use crate::{CleanError, Cleaner, CleanerSpec, Note};

const PRESET: Parameter = Parameter::Word(WordSpec {
    name: "preset",
    allowed: &["davis240c-eventhands"],
    default: None,
    doc: "davis240c-eventhands: its camera, clipped and cut off as published",
});
const FILE: Parameter = Parameter::File(FileSpec {
    name: "file",
    unit: "",
    doc: "a calibration as --camera takes it: of OpenCV, ROS, kalibr, DSEC, rpg, dv-processing, or a TOML file",
});
const OUTSIDE: Parameter = Parameter::Word(WordSpec {
    name: "outside",
    allowed: &["drop", "clip"],
    default: Some("drop"),
    doc: "what becomes of events beyond the image: removed, or put on its border",
});

pub(crate) static SPEC: CleanerSpec = CleanerSpec {
    name: "undistort",
    summary: "moves events to where a camera without distortion would see them",
    params: &[PRESET, FILE, OUTSIDE],
    displaces: true,
    build: |settings, sensor| {
        let (what, camera, options) = if settings.word(&PRESET).is_some() {
            SPEC.alone(settings, &PRESET)?;
            let file = CameraFile::davis240c_eventhands();
            let camera = Calibration::of_lens(file.sensor, file.camera()?);
            ("the camera of EventHands".to_owned(), camera, UndistortOptions::EVENTHANDS)
        } else {
            let needs = "a file or a preset";
            let path = settings.file(&FILE);
            let path = path.ok_or(CleanError::Missing { cleaner: "undistort", needs })?;
            let clips = settings.word(&OUTSIDE) == Some("clip");
            let outside = if clips { Outside::Clip } else { Outside::Drop };
            let options = UndistortOptions { outside, ..UndistortOptions::default() };
            let camera = Calibration::of_file(path, sensor)?;
            (format!("the camera {}", path.display()), camera, options)
        };
        if camera.sensor != sensor {
            return Err(CleanError::OtherSensor { what, actual: camera.sensor, sensor });
        }
        Ok(Box::new(Undistort::new(sensor, &camera.camera, options)))
    },
};

/// The iteration has converged where it is as close as this.
pub const TOLERANCE_PX: f64 = 0.01;
/// Steps for [`Inverse::Converged`]: halving the error with each would take forty.
const MAX_STEPS: u32 = 500;

/// How the lens is inverted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inverse {
    /// Until nothing moves. Events of pixels where it does not converge are removed.
    Converged,
    /// This number of steps, converged or not.
    Steps(u32),
}

/// Treatment of events beyond the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// They are removed.
    Drop,
    /// They are put on its border.
    Clip,
}

/// Rounding of a position to a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rounding {
    /// The one with the nearest centre.
    Nearest,
    /// Coordinates, counted from the centre of the first pixel, are cut off at the point.
    Truncate,
}

/// How events are moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UndistortOptions {
    /// How the lens is inverted.
    pub inverse: Inverse,
    /// Treatment of events beyond the image.
    pub outside: Outside,
    /// Rounding of a position to a pixel.
    pub rounding: Rounding,
}

impl UndistortOptions {
    /// The options of EventHands.
    pub const EVENTHANDS: Self =
        Self { inverse: Inverse::Steps(5), outside: Outside::Clip, rounding: Rounding::Truncate };
}

impl Default for UndistortOptions {
    fn default() -> Self {
        Self { inverse: Inverse::Converged, outside: Outside::Drop, rounding: Rounding::Nearest }
    }
}

/// Destination of the events of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    Moved = 0,
    Clipped = 1,
    Outside = 2,
    Unsettled = 3,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    x: u16,
    y: u16,
    fate: Fate,
}

/// The table of a camera.
#[derive(Debug, Clone)]
pub struct Undistort {
    sensor: SensorSize,
    places: Vec<Place>,
    unsettled_pixels: usize,
    /// Events by fate.
    events: [u64; 4],
}

impl Undistort {
    /// Computes where each pixel goes.
    pub fn new(sensor: SensorSize, camera: &LensCamera, options: UndistortOptions) -> Self {
        let mut unsettled_pixels = 0;
        let mut places = Vec::with_capacity(sensor.pixels());
        for y in 0..sensor.height {
            for x in 0..sensor.width {
                let (position, is_settled) = undistorted(camera, options.inverse, x, y);
                unsettled_pixels += usize::from(!is_settled);
                places.push(place(sensor, options, position, is_settled));
            }
        }
        Self { sensor, places, unsettled_pixels, events: [0; 4] }
    }

    /// Destination of the events of a pixel, if they are kept.
    pub fn destination(&self, x: u16, y: u16) -> Option<(u16, u16)> {
        let pixel = usize::from(y) * usize::from(self.sensor.width) + usize::from(x);
        let place = self.places.get(pixel).filter(|_| self.sensor.contains(x, y))?;
        (place.fate as usize <= Fate::Clipped as usize).then_some((place.x, place.y))
    }

    /// Pixels at which the iteration does not converge.
    pub fn unsettled_pixels(&self) -> usize {
        self.unsettled_pixels
    }
}

/// Undistorted position of a pixel, counted from the centre of the first pixel, and whether the
/// iteration converges.
fn undistorted(camera: &LensCamera, inverse: Inverse, x: u16, y: u16) -> (DVec2, bool) {
    let steps = match inverse {
        Inverse::Converged => MAX_STEPS,
        Inverse::Steps(steps) => steps,
    };
    // The lens counts from the corner of the image, a table from the centre of its first pixel.
    let seen_px = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
    let sight = camera.direction_from_image(seen_px, steps);
    let position = camera.pinhole_image_from_direction(sight.direction) - 0.5;
    (position, sight.error_px <= TOLERANCE_PX)
}

fn place(
    sensor: SensorSize,
    options: UndistortOptions,
    position: DVec2,
    is_settled: bool,
) -> Place {
    let nowhere = |fate| Place { x: 0, y: 0, fate };
    // An inverse that has not settled is no place, unless a fixed number of steps is wanted.
    if !position.is_finite() || (!is_settled && options.inverse == Inverse::Converged) {
        return nowhere(Fate::Unsettled);
    }
    let most = DVec2::new(f64::from(sensor.width) - 1.0, f64::from(sensor.height) - 1.0);
    // In this order, as the program does it: clipped first, then cut off.
    let (clipped, rounded) = match options.rounding {
        Rounding::Nearest => {
            let nearest = position.round();
            (nearest.clamp(DVec2::ZERO, most), nearest)
        }
        Rounding::Truncate => {
            let clipped = position.clamp(DVec2::ZERO, most);
            (clipped.floor(), position.floor())
        }
    };
    let is_outside = clipped != rounded;
    if is_outside && options.outside == Outside::Drop {
        return nowhere(Fate::Outside);
    }
    let fate = if is_outside { Fate::Clipped } else { Fate::Moved };
    Place { x: clipped.x as u16, y: clipped.y as u16, fate }
}

impl Cleaner for Undistort {
    fn clean(&mut self, events: &mut EventStream) {
        let taken = std::mem::replace(events, EventStream::empty(self.sensor));
        let (mut t, mut x, mut y, mut polarity) = taken.into_columns();
        let width = usize::from(self.sensor.width);
        let mut kept = 0;
        for i in 0..t.len() {
            let place = self.places[usize::from(y[i]) * width + usize::from(x[i])];
            // Written in any case and overwritten unless it stays: the loop has no branch.
            self.events[place.fate as usize] += 1;
            (t[kept], x[kept]) = (t[i], place.x);
            (y[kept], polarity[kept]) = (place.y, polarity[i]);
            kept += usize::from(place.fate as usize <= Fate::Clipped as usize);
        }
        t.truncate(kept);
        x.truncate(kept);
        y.truncate(kept);
        polarity.truncate(kept);
        *events = EventStream::from_columns(self.sensor, t, x, y, polarity)
            .unwrap_or_else(|_| unreachable!("the table holds pixels of the sensor"));
    }

    fn reset(&mut self) {
        self.events = [0; 4];
    }

    fn notes(&self) -> Vec<Note> {
        let [_, clipped, outside, unsettled] = self.events;
        vec![
            Note { what: "events put on the border", count: clipped },
            Note { what: "events beyond the image", count: outside },
            Note { what: "events of pixels where the lens has no inverse", count: unsettled },
            Note {
                what: "pixels where the lens has no inverse",
                count: self.unsettled_pixels as u64,
            },
        ]
    }
}

#[cfg(test)]
mod tests;
