//! Pixels and rectangles of a sensor that are not to be trusted, and the file they are kept in.
//!
//! ```toml
//! sensor = { width = 346, height = 260 }
//! # Column, row.
//! pixels = [[12, 7], [300, 259]]
//! # The first column and row, then how many of them.
//! rectangles = [{ x = 88, y = 115, width = 29, height = 29 }]
//! ```

use std::fs;
use std::path::Path;

use evpose_core::{SensorSize, atomic_write};
use serde::{Deserialize, Serialize};

use crate::CleanError;

/// Part of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// First column.
    pub x: u16,
    /// First row.
    pub y: u16,
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
}

impl Rectangle {
    /// Whether a pixel lies in it.
    pub fn contains(self, x: u16, y: u16) -> bool {
        x.checked_sub(self.x).is_some_and(|x| x < self.width)
            && y.checked_sub(self.y).is_some_and(|y| y < self.height)
    }
}

/// Pixels of a sensor that are left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mask {
    /// Size of the sensor that the pixels are counted on.
    pub sensor: SensorSize,
    /// Columns and rows of single pixels.
    #[serde(default)]
    pub pixels: Vec<(u16, u16)>,
    /// Parts of the image.
    #[serde(default)]
    pub rectangles: Vec<Rectangle>,
}

impl Mask {
    /// A mask of nothing.
    pub fn new(sensor: SensorSize) -> Self {
        Self { sensor, pixels: Vec::new(), rectangles: Vec::new() }
    }

    /// Whether a pixel is left out.
    pub fn contains(&self, x: u16, y: u16) -> bool {
        self.pixels.contains(&(x, y)) || self.rectangles.iter().any(|r| r.contains(x, y))
    }

    /// Whether each pixel is left out, row by row from the top. What lies beyond the sensor is not
    /// there.
    pub fn flags(&self) -> Vec<bool> {
        let SensorSize { width, height } = self.sensor;
        let mut flags = vec![false; self.sensor.pixels()];
        for &(x, y) in self.pixels.iter().filter(|(x, y)| self.sensor.contains(*x, *y)) {
            flags[usize::from(y) * usize::from(width) + usize::from(x)] = true;
        }
        for r in &self.rectangles {
            // Corner and side together may exceed 16 bits in a mask that was not read from a file.
            for y in r.y.min(height)..r.y.saturating_add(r.height).min(height) {
                let row = &mut flags[usize::from(y) * usize::from(width)..][..usize::from(width)];
                let (start, end) = (r.x.min(width), r.x.saturating_add(r.width).min(width));
                row[usize::from(start)..usize::from(end)].fill(true);
            }
        }
        flags
    }

    /// Reads the mask of a sensor from a file.
    ///
    /// # Errors
    /// If it cannot be read, is no mask, is one of another sensor, or holds what lies beyond it.
    pub fn load(path: &Path, sensor: SensorSize) -> Result<Self, CleanError> {
        let text = fs::read_to_string(path)
            .map_err(|error| CleanError::File { path: path.to_owned(), error })?;
        let bad = |reason: String| CleanError::BadFile { path: path.to_owned(), reason };
        let mask: Self = toml::from_str(&text).map_err(|error| bad(error.to_string()))?;
        if mask.sensor != sensor {
            let what = format!("the mask {}", path.display());
            return Err(CleanError::OtherSensor { what, actual: mask.sensor, sensor });
        }
        if let Some((x, y)) = mask.pixels.iter().find(|(x, y)| !sensor.contains(*x, *y)) {
            return Err(bad(format!("pixel ({x}, {y}) lies outside the {sensor} sensor")));
        }
        // In 32 bits, as corner and side together may exceed 16.
        let fits = |r: &Rectangle| {
            u32::from(r.x) + u32::from(r.width) <= u32::from(sensor.width)
                && u32::from(r.y) + u32::from(r.height) <= u32::from(sensor.height)
        };
        if let Some(r) = mask.rectangles.iter().find(|r| !fits(r)) {
            let reason = format!(
                "the rectangle of {}x{} at ({}, {}) reaches beyond the {sensor} sensor",
                r.width, r.height, r.x, r.y
            );
            return Err(bad(reason));
        }
        Ok(mask)
    }

    /// Writes it to a file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), CleanError> {
        let text = toml::to_string(self)
            .map_err(|e| CleanError::BadFile { path: path.to_owned(), reason: e.to_string() })?;
        atomic_write(path, text.as_bytes())
            .map_err(|error| CleanError::File { path: path.to_owned(), error })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 9, height: 7 };

    fn load(text: &str) -> Result<Mask, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.toml");
        fs::write(&path, text).unwrap();
        Mask::load(&path, SENSOR)
            .map_err(|e| e.to_string().replace(&path.display().to_string(), "F"))
    }

    #[test]
    fn a_mask_by_hand_is_read_and_a_faulty_one_says_what_is_wrong() {
        let text = "sensor = { width = 9, height = 7 }\npixels = [[8, 6]]\n";
        assert_eq!(load(text), Ok(Mask { pixels: vec![(8, 6)], ..Mask::new(SENSOR) }));
        let outside = load("sensor = { width = 9, height = 7 }\npixels = [[9, 6]]\n");
        assert_eq!(outside, Err("F: pixel (9, 6) lies outside the 9x7 sensor".to_owned()));
        let other = load("sensor = { width = 65535, height = 65535 }\n").unwrap_err();
        assert_eq!(
            other,
            "the mask F is for a 65535x65535 sensor, the events come from one of 9x7"
        );
        let text = "sensor = { width = 9, height = 7 }\n\
                    rectangles = [{ x = 8, y = 0, width = 2, height = 1 }]\n";
        let reach = "F: the rectangle of 2x1 at (8, 0) reaches beyond the 9x7 sensor";
        assert_eq!(load(text), Err(reach.to_owned()));
        assert!(load("pixels = 3").is_err());
    }

    proptest! {
        #[test]
        fn masks_come_back_from_their_files_and_flags_are_what_they_contain(
            pixels in prop::collection::vec((0..SENSOR.width, 0..SENSOR.height), 0..5),
            corners in prop::collection::vec((0u16..9, 0u16..7, 0u16..9, 0u16..7), 0..3),
        ) {
            let rectangle = |&(x, y, width, height): &(u16, u16, u16, u16)| Rectangle {
                x,
                y,
                width: width.min(SENSOR.width - x),
                height: height.min(SENSOR.height - y),
            };
            let rectangles = corners.iter().map(rectangle).collect();
            let mask = Mask { sensor: SENSOR, pixels, rectangles };
            let folder = tempfile::tempdir()?;
            let path = folder.path().join("mask.toml");
            mask.save(&path).unwrap();
            prop_assert_eq!(&Mask::load(&path, SENSOR).unwrap(), &mask);
            for (i, is_masked) in mask.flags().into_iter().enumerate() {
                let (x, y) = ((i % 9) as u16, (i / 9) as u16);
                prop_assert_eq!(is_masked, mask.contains(x, y));
            }
        }
    }
}
