//! Filters of the events of the four cameras: they remove hot pixels, events without
//! neighbours, and lamps of the motion-capture system.

use std::ops::Range;

use evpose_core::{Event, EventStream};

use super::background::{BackgroundFilter, keep_supported};
use super::{CAMERAS, SENSOR};

/// Options of the filters, in the order of their application.
///
/// # Source
/// The published `extract_from_aedat.m` and what it calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dhp19Filters {
    /// Events of a pixel in a movement from which all of them are removed, if given.
    pub hot_pixel_events: Option<u32>,
    /// Those that nothing near them supports.
    pub background: Option<BackgroundFilter>,
    /// Those of the lamps that two cameras see, at [`MASKS`].
    pub are_lamps_masked: bool,
}

impl Default for Dhp19Filters {
    fn default() -> Self {
        Self {
            hot_pixel_events: Some(10_000),
            background: Some(BackgroundFilter::default()),
            are_lamps_masked: true,
        }
    }
}

/// A rectangle of a camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraMask {
    /// Index of the camera.
    pub camera: usize,
    /// Its columns, from 0.
    pub columns: Range<u16>,
    /// Its rows, from 0.
    pub rows: Range<u16>,
}

/// Regions of lamps. The program counts columns of all cameras in one row from 1 on, and gives the
/// columns and rows around these.
pub const MASKS: [CameraMask; 2] = [
    CameraMask { camera: 2, columns: 88..117, rows: 115..144 },
    CameraMask { camera: 3, columns: 214..220, rows: 136..143 },
];

/// How many events were taken out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Removed {
    /// Of pixels that never stop.
    pub hot: usize,
    /// Without support.
    pub unsupported: usize,
    /// Of lamps.
    pub masked: usize,
}

impl Dhp19Filters {
    /// No event is taken out.
    pub const NONE: Self =
        Self { hot_pixel_events: None, background: None, are_lamps_masked: false };

    /// Takes events out of one movement as the four cameras saw it.
    ///
    /// # Panics
    /// If a stream is of another sensor.
    pub fn apply(&self, cameras: &mut [EventStream; CAMERAS]) -> Removed {
        assert!(cameras.iter().all(|camera| camera.sensor() == SENSOR), "of another sensor");
        let count = |cameras: &[EventStream]| cameras.iter().map(EventStream::len).sum::<usize>();
        let all = count(cameras);
        // First, since hot pixels would support the noise around them.
        if let Some(events) = self.hot_pixel_events {
            cameras.iter_mut().for_each(|camera| remove_hot_pixels(camera, events));
        }
        let without_hot = count(cameras);
        if let Some(background) = &self.background {
            keep_supported(cameras, background);
        }
        let supported = count(cameras);
        if self.are_lamps_masked {
            for mask in MASKS {
                let is_lamp = |e: Event| mask.columns.contains(&e.x) && mask.rows.contains(&e.y);
                cameras[mask.camera].retain(|event| !is_lamp(event));
            }
        }
        Removed {
            hot: all - without_hot,
            unsupported: without_hot - supported,
            masked: supported - count(cameras),
        }
    }
}

fn remove_hot_pixels(camera: &mut EventStream, events: u32) {
    let mut counts = vec![0_u32; SENSOR.pixels()];
    let pixel = |x: u16, y: u16| usize::from(y) * usize::from(SENSOR.width) + usize::from(x);
    for (&x, &y) in camera.x().iter().zip(camera.y()) {
        counts[pixel(x, y)] += 1;
    }
    camera.retain(|event| counts[pixel(event.x, event.y)] < events);
}

#[cfg(test)]
mod tests {
    use evpose_core::{Micros, Polarity};

    use super::*;

    fn event(t: i64, x: u16, y: u16) -> Event {
        Event { t: Micros(t), x, y, polarity: Polarity::On }
    }

    fn cameras(of: usize, events: impl IntoIterator<Item = Event>) -> [EventStream; CAMERAS] {
        let mut cameras = [(); CAMERAS].map(|()| EventStream::empty(SENSOR));
        cameras[of] = EventStream::from_events(SENSOR, events).unwrap();
        cameras
    }

    #[test]
    fn a_pixel_that_never_stops_is_removed_and_its_neighbour_is_not() {
        let filters = Dhp19Filters { hot_pixel_events: Some(10), ..Dhp19Filters::NONE };
        let events = (0..10).flat_map(|t| [event(t, 3, 4), event(t, 4, 4)]);
        let mut all = cameras(1, events.clone().chain([event(20, 3, 4)]).skip(1));
        // Ten events each: the first of (3, 4) is left out, and one more comes late.
        assert_eq!(filters.apply(&mut all).hot, 20);
        let mut all = cameras(1, events.skip(1));
        assert_eq!(filters.apply(&mut all), Removed { hot: 10, unsupported: 0, masked: 0 });
        assert!(all[1].iter().all(|event| event.x == 3));
    }

    #[test]
    fn lamps_are_masked_to_the_pixel_that_the_program_gives() {
        let filters = Dhp19Filters { are_lamps_masked: true, ..Dhp19Filters::NONE };
        // The program's limits, for a column X and a row Y from 1 on, all excluded.
        let limits = [(780, 810, 115, 145), (346 * 3 + 214, 346 * 3 + 221, 136, 144)];
        for camera in 0..CAMERAS {
            let pixels = (0..SENSOR.width).flat_map(|x| (0..SENSOR.height).map(move |y| (x, y)));
            let mut all = cameras(camera, pixels.clone().map(|(x, y)| event(0, x, y)));
            filters.apply(&mut all);
            let is_lamp = |x: u16, y: u16| {
                let (x, y) = (usize::from(x) + 1 + 346 * camera, usize::from(y) + 1);
                limits.iter().any(|&(x0, x1, y0, y1)| x0 < x && x < x1 && y0 < y && y < y1)
            };
            let left = pixels.filter(|&(x, y)| !is_lamp(x, y)).map(|(x, y)| event(0, x, y));
            assert!(all[camera].iter().eq(left), "camera {camera}");
        }
    }
}
