//! Leaves masked pixels out.
//!
//! The presets are DHP19's masks: of its third camera (number 2) a square in which another camera's
//! lamp blinks, of its fourth a smaller one. They are stated in the published coordinates, which
//! count from 1 over four images side by side, columns mirrored and rows from below, and hold the
//! pixels strictly inside 780 to 810 by 115 to 145 and 1252 to 1259 by 136 to 144. `dhp19-camera2`
//! and `dhp19-camera3` are for events with coordinates as the data set exports them (those, less
//! one and less the images to the left); `dhp19-camera2-raw` and `dhp19-camera3-raw` for the
//! addresses in its `.aedat` files, with `column = 346 - x` and `row = 260 - y`.

use evpose_core::{EventStream, FileSpec, Parameter, SensorSize, WordSpec};

use crate::{CleanError, Cleaner, CleanerSpec, Mask, Rectangle};

const FILE: Parameter = Parameter::File(FileSpec {
    name: "file",
    unit: "",
    doc: "a TOML file of pixels and rectangles",
});
const PRESET: Parameter = Parameter::Word(WordSpec {
    name: "preset",
    allowed: &["dhp19-camera2", "dhp19-camera3", "dhp19-camera2-raw", "dhp19-camera3-raw"],
    default: None,
    doc: "the masks of DHP19, for its exported coordinates or for raw addresses",
});

pub(crate) static SPEC: CleanerSpec = CleanerSpec {
    name: "mask",
    summary: "removes events of given pixels and rectangles",
    params: &[FILE, PRESET],
    displaces: false,
    build: |settings, sensor| {
        let mask = match (settings.file(&FILE), settings.word(&PRESET)) {
            (Some(path), None) => Mask::load(path, sensor)?,
            (None, Some(preset)) => dhp19(preset, sensor)?,
            (None, None) => {
                return Err(CleanError::Missing { cleaner: "mask", needs: "a file or a preset" });
            }
            (Some(_), Some(_)) => {
                return Err(CleanError::Conflict { cleaner: "mask", key: "file", other: "preset" });
            }
        };
        Ok(Box::new(Masking::new(mask)))
    },
};

/// The sensors of DHP19.
const DAVIS346: SensorSize = SensorSize { width: 346, height: 260 };

fn dhp19(preset: &str, sensor: SensorSize) -> Result<Mask, CleanError> {
    if sensor != DAVIS346 {
        let what = format!("the mask `{preset}`");
        return Err(CleanError::OtherSensor { what, actual: DAVIS346, sensor });
    }
    let (camera, is_raw) = match preset.strip_suffix("-raw") {
        Some(camera) => (camera, true),
        None => (preset, false),
    };
    // Columns and rows strictly between these, from 1 on, over four images side by side.
    let (camera, columns, rows) = match camera {
        "dhp19-camera2" => (2, (780, 810), (115, 145)),
        _ => (3, (1252, 1259), (136, 144)),
    };
    // Less the images to the left: columns within the camera's own image.
    let left = DAVIS346.width * camera;
    let (first, last) = (columns.0 + 1 - left, columns.1 - 1 - left);
    let (top, bottom) = (rows.0 + 1, rows.1 - 1);
    // Raw addresses count both axes from the opposite ends.
    let (x, y) = if is_raw {
        (DAVIS346.width - last, DAVIS346.height - bottom)
    } else {
        (first - 1, top - 1)
    };
    let rectangle = Rectangle { x, y, width: last + 1 - first, height: bottom + 1 - top };
    Ok(Mask { rectangles: vec![rectangle], ..Mask::new(DAVIS346) })
}

/// Removes the events of masked pixels.
#[derive(Debug, Clone)]
pub struct Masking {
    mask: Mask,
    flags: Vec<bool>,
}

impl Masking {
    /// Leaves the pixels of a mask out.
    pub fn new(mask: Mask) -> Self {
        let flags = mask.flags();
        Self { mask, flags }
    }
}

impl Cleaner for Masking {
    fn clean(&mut self, events: &mut EventStream) {
        let width = usize::from(self.mask.sensor.width);
        let flags = &self.flags;
        events.retain(|event| !flags[usize::from(event.y) * width + usize::from(event.x)]);
    }

    fn reset(&mut self) {}

    fn mask(&self) -> Option<&Mask> {
        Some(&self.mask)
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Micros, Polarity};

    use super::*;

    /// The published rule, on raw addresses.
    fn dhp19_removes(camera: i32, x: i32, y: i32) -> bool {
        let (column, row) = (346 - x + 346 * camera, 260 - y);
        (780 < column && column < 810 && 115 < row && row < 145)
            || (1252 < column && column < 1259 && 136 < row && row < 144)
    }

    #[test]
    fn the_masks_of_dhp19_are_those_of_its_rule_in_both_coordinates() {
        for camera in [2, 3] {
            let exported = dhp19(&format!("dhp19-camera{camera}"), DAVIS346).unwrap();
            let raw = dhp19(&format!("dhp19-camera{camera}-raw"), DAVIS346).unwrap();
            let mut masked = 0;
            for y in 0..260_u16 {
                for x in 0..346_u16 {
                    let removes = dhp19_removes(camera, x.into(), y.into());
                    masked += usize::from(removes);
                    assert_eq!(raw.contains(x, y), removes, "camera {camera} at {x}, {y}");
                    let (column, row) = (346 - x - 1, 260_u16.wrapping_sub(y).wrapping_sub(1));
                    assert_eq!(exported.contains(column, row), removes, "{camera}: {x}, {y}");
                }
            }
            assert_eq!(masked, if camera == 2 { 29 * 29 } else { 6 * 7 });
        }
        assert!(dhp19("dhp19-camera2", SensorSize::DAVIS240C).is_err());
    }

    #[test]
    fn events_of_masked_pixels_are_removed_and_no_others() {
        let sensor = SensorSize { width: 3, height: 3 };
        let rectangles = vec![Rectangle { x: 1, y: 1, width: 2, height: 1 }];
        let mask = Mask { sensor, pixels: vec![(0, 2)], rectangles };
        let all = (0..9).map(|i| Event {
            t: Micros(i64::from(i)),
            x: i % 3,
            y: i / 3,
            polarity: Polarity::On,
        });
        let mut events = EventStream::from_events(sensor, all).unwrap();
        Masking::new(mask).clean(&mut events);
        let left: Vec<i64> = events.t().iter().map(|t| t.0).collect();
        assert_eq!(left, [0, 1, 2, 3, 7, 8]);
    }
}
