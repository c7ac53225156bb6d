//! Whether the polarities of a recording say anything.
//!
//! # Model
//! An edge passes a row of pixels in one polarity, and fine texture in both in turn, so that an event
//! soon after one of the pixel to its left is far more often, or more seldom, of the same polarity than
//! the share `p² + q²` that chance makes of shares `p` and `q` of ON and OFF. Where it is not,
//! polarities were lost: written as one, or as noise. Pairs are evaluated [`PAIRS`] at a time, and only
//! where there are many among the events: noise of the sensor is alone, and its polarities are true
//! though they do not agree. What has once said something is believed from then on.

use evpose_core::{Event, Micros, SensorSize};

/// How long after its neighbour an event makes a pair with it.
const NEAR: Micros = Micros(5_000);
/// Pairs of an evaluation: chance moves their share by 0.5 %.
const PAIRS: u32 = 10_000;
/// Most events for so many pairs: noise of 25 Hz at every pixel has more.
const MAX_EVENTS: u32 = 8 * PAIRS;
/// Deviation from chance that says something, relative to what is left beyond it: simulated people
/// come to 0.06 to 0.97, and to -0.16 before a texture; the standard deviation of chance is 0.01.
const DEVIATION: f32 = 0.05;

/// A verdict on polarities, event by event.
#[derive(Debug, Clone)]
pub(crate) struct PolarityEvidence {
    width: usize,
    /// The last event of each pixel: twice its time, and 1 of ON. Empty once they are believed.
    last: Vec<i64>,
    events: u32,
    pairs: u32,
    agreeing: u32,
    on: u32,
    is_lost: bool,
}

impl PolarityEvidence {
    pub(crate) fn new(sensor: SensorSize) -> Self {
        let last = vec![i64::MIN / 2; sensor.pixels()];
        let width = sensor.width.into();
        Self { width, last, events: 0, pairs: 0, agreeing: 0, on: 0, is_lost: false }
    }

    /// Whether polarities say nothing, as far as events have shown.
    pub(crate) fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Takes the next event. Returns whether it is the one after which polarities say nothing.
    pub(crate) fn push(&mut self, event: &Event) -> bool {
        if self.last.is_empty() {
            return false;
        }
        let pixel = usize::from(event.y) * self.width + usize::from(event.x);
        let on = i64::from(event.polarity.is_on());
        // Time and polarity share a word: an event costs one store and one load.
        self.last[pixel] = (event.t.0 << 1) | on;
        self.events += 1;
        if event.x > 0 {
            let left = self.last[pixel - 1];
            if event.t.0.saturating_sub(left >> 1) <= NEAR.0 {
                self.pairs += 1;
                self.agreeing += u32::from(left & 1 == on);
                self.on += on as u32;
            }
        }
        let was_lost = self.is_lost;
        if self.pairs == PAIRS {
            self.evaluate();
        }
        self.is_lost && !was_lost
    }

    fn evaluate(&mut self) {
        let share = |count: u32| count as f32 / PAIRS as f32;
        if self.events <= MAX_EVENTS {
            let on = share(self.on);
            let chance = on * on + (1.0 - on) * (1.0 - on);
            let deviation = (share(self.agreeing) - chance).abs();
            self.is_lost = deviation <= DEVIATION * (1.0 - chance);
            if !self.is_lost {
                self.last = Vec::new();
            }
        }
        (self.events, self.pairs, self.agreeing, self.on) = (0, 0, 0, 0);
    }
}
