//! The event image: the brightness of ON and OFF events of every cell, which decays with time.

use evpose_core::SensorSize;

use super::event_counts::Cells;

/// Time constant of the decay in seconds: about one frame and a half at 30 frames/s.
const FADE_S: f64 = 0.045;

/// Brightness of one event, large enough for the integer decay.
const EVENT_BRIGHTNESS: u16 = 64;

/// Maximum of the 16 levels.
const MAX_LEVEL: u32 = 15;

const MEAN_LEVEL: u32 = 9;

/// Weight of a new frame in the moving average of the brightness.
const MEAN_UPDATE: f32 = 0.1;

pub(super) struct EventImage {
    cells: Cells,
    /// OFF and ON of every cell.
    levels: Vec<u16>,
    /// Moving average of the brightness of cells with new events.
    mean: f32,
}

impl EventImage {
    pub(super) fn new(sensor: SensorSize) -> Self {
        let cells = Cells::for_sensor(sensor);
        Self { cells, levels: vec![0; 2 * cells.len()], mean: f32::from(EVENT_BRIGHTNESS) }
    }

    /// Decays by `passed_s` seconds, then adds `counts` and sets them to 0.
    pub(super) fn add(&mut self, counts: &mut [u8], passed_s: f64) {
        let left = ((-passed_s / FADE_S).exp() * 65536.0) as u32;
        let (mut sum, mut bright) = (0_u64, 0_u64);
        for (level, count) in self.levels.iter_mut().zip(&mut *counts) {
            let faded = (u32::from(*level) * left) >> 16;
            let new = faded + u32::from(EVENT_BRIGHTNESS) * u32::from(*count);
            *level = new.min(u32::from(u16::MAX)) as u16;
            // Decaying cells carry no information about the rate of events.
            let counted = u64::from(*count > 0);
            sum += u64::from(*level) * counted;
            bright += counted;
        }
        counts.fill(0);
        if bright > 0 {
            let mean = (sum as f32 / bright as f32).max(f32::from(EVENT_BRIGHTNESS));
            self.mean += MEAN_UPDATE * (mean - self.mean);
        }
    }

    /// The image as a message: width and height in cells, each 16 bits little endian; then row by
    /// row a byte for every cell, its upper four bits the level of ON, its lower four that of OFF.
    /// A run of dark cells is a 0 and its length, up to 255.
    pub(super) fn message(&self) -> Vec<u8> {
        // In fixed point: one division a frame instead of one a cell.
        let scale = ((MEAN_LEVEL << 16) as f32 / self.mean) as u32;
        let step = |level: u16| ((u32::from(level) * scale) >> 16).min(MAX_LEVEL) as u8;
        let mut out = Vec::with_capacity(4 + self.cells.len() / 4);
        out.extend_from_slice(&self.cells.width.to_le_bytes());
        out.extend_from_slice(&self.cells.height.to_le_bytes());
        let mut dark = 0_u8;
        for cell in self.levels.chunks_exact(2) {
            let byte = step(cell[1]) << 4 | step(cell[0]);
            // A run has room for 255 cells, then another begins.
            if byte == 0 && dark < u8::MAX {
                dark += 1;
                continue;
            }
            if dark > 0 {
                out.extend_from_slice(&[0, std::mem::take(&mut dark)]);
            }
            match byte {
                0 => dark = 1,
                _ => out.push(byte),
            }
        }
        if dark > 0 {
            out.extend_from_slice(&[0, dark]);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 30, height: 20 };

    /// The cells of a message, as the page decodes them.
    fn decoded(message: &[u8]) -> Vec<u8> {
        let size = |at: usize| usize::from(u16::from_le_bytes([message[at], message[at + 1]]));
        let mut cells = Vec::new();
        let mut rest = message[4..].iter();
        while let Some(&byte) = rest.next() {
            match byte {
                0 => cells.extend(std::iter::repeat_n(0, usize::from(*rest.next().unwrap()))),
                _ => cells.push(byte),
            }
        }
        assert_eq!(cells.len(), size(0) * size(2));
        cells
    }

    #[test]
    fn an_event_is_bright_in_its_polarity_and_fades() {
        let mut image = EventImage::new(SENSOR);
        let mut counts = vec![0; 1200];
        (counts[0], counts[1199]) = (1, 1);
        image.add(&mut counts, 1.0 / 30.0);
        assert!(counts.iter().all(|&count| count == 0), "ready for the next frame");
        let cells = decoded(&image.message());
        assert_eq!((cells[0], cells[599]), (MEAN_LEVEL as u8, (MEAN_LEVEL as u8) << 4), "OFF, ON");
        assert!(cells[1..599].iter().all(|&cell| cell == 0));
        image.add(&mut counts, FADE_S);
        let third = decoded(&image.message())[0];
        assert_eq!(third, (f64::from(MEAN_LEVEL) / 1_f64.exp()) as u8);
        image.add(&mut counts, 10.0);
        assert_eq!(image.message(), [30, 0, 20, 0, 0, 255, 0, 255, 0, 90]);
    }

    #[test]
    fn many_events_do_not_dazzle_for_long() {
        let mut image = EventImage::new(SENSOR);
        for _ in 0..100 {
            image.add(&mut [200; 1200], 1.0 / 30.0);
        }
        let usual = decoded(&image.message())[0] & 15;
        assert!((MEAN_LEVEL as u8 - 1..=MEAN_LEVEL as u8).contains(&usual), "{usual}");
    }

    proptest! {
        #[test]
        fn every_cell_comes_back(bright in proptest::collection::vec(0_u8..4, 600)) {
            let mut image = EventImage::new(SENSOR);
            let mut counts: Vec<u8> = bright.iter().flat_map(|&n| [n & 1, n >> 1]).collect();
            image.add(&mut counts, 0.0);
            for (cell, n) in decoded(&image.message()).into_iter().zip(bright) {
                prop_assert_eq!((cell & 15 > 0, cell >> 4 > 0), (n & 1 == 1, n >> 1 == 1));
            }
        }
    }
}
