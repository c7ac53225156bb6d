//! Whether the polarities of a recording say anything.
//!
//! # Model
//! An edge passes a row of pixels in one polarity, and fine texture in both in turn, so that an event
//! soon after one of a pixel beside it is far more often, or more seldom, of the same polarity than
//! the share `p² + q²` that chance makes of shares `p` and `q` of ON and OFF. Where it is not,
//! polarities were lost: written as one, or as noise. Pairs are evaluated [`PAIRS`] at a time, and only
//! where there are many among the events, or many more than events make that lie anywhere: noise of the
//! sensor is alone, and its polarities are true though they do not agree. What has once said something
//! is believed from then on.

use evpose_core::{Event, Micros, SensorSize};

/// How long after its neighbour an event makes a pair with it, on a sensor of [`NEAR_WIDTH`] and less.
/// The same edge takes a wider sensor's pixels, which see smaller angles, in as much less time as they
/// follow each other later.
const NEAR: Micros = Micros(5_000);
/// Pixels of a row for [`NEAR`].
const NEAR_WIDTH: u16 = 346;
/// Pairs of an evaluation: chance moves their share by 0.5 %.
const PAIRS: u32 = 10_000;
/// Rate of a pixel of which noise is not taken for edges, wherever it is.
const NOISE_HZ: f32 = 25.0;
/// The word of a pixel without an event.
const NEVER: i64 = i64::MIN / 2;
/// Pairs for one that as many events would make that lie anywhere on the sensor: one in ten is then of
/// noise.
const CROWDED: f32 = 10.0;
/// Deviation from chance that says something, relative to what is left beyond it: simulated people
/// come to 0.06 to 0.97, and to -0.16 before a texture; the standard deviation of chance is 0.01.
const DEVIATION: f32 = 0.05;

/// A verdict on polarities, event by event.
#[derive(Debug, Clone)]
pub(crate) struct PolarityEvidence {
    width: usize,
    near: Micros,
    /// When the events of this evaluation begin.
    since: Micros,
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
        let last = vec![NEVER; sensor.pixels()];
        // sooner.
        let near = NEAR.0 * i64::from(sensor.width.max(NEAR_WIDTH)) / i64::from(NEAR_WIDTH);
        let (width, near) = (sensor.width.into(), Micros(near));
        Self {
            width,
            near,
            since: Micros(0),
            last,
            events: 0,
            pairs: 0,
            agreeing: 0,
            on: 0,
            is_lost: false,
        }
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
        if self.events == 0 {
            self.since = event.t;
        }
        self.events += 1;
        // The later of both: an edge comes from one side.
        let left = if event.x > 0 { self.last[pixel - 1] } else { NEVER };
        let is_last = usize::from(event.x) + 1 == self.width;
        let beside = left.max(if is_last { NEVER } else { self.last[pixel + 1] });
        if event.t.0.saturating_sub(beside >> 1) <= self.near.0 {
            self.pairs += 1;
            self.agreeing += u32::from(beside & 1 == on);
            self.on += on as u32;
        }
        let was_lost = self.is_lost;
        if self.pairs == PAIRS {
            self.evaluate(event.t);
        }
        self.is_lost && !was_lost
    }

    /// Whether there are more pairs than noise of the sensor makes, of the events up to a time.
    fn are_of_edges(&self, end: Micros) -> bool {
        let (events, near_s) = (self.events as f32, 1e-6 * self.near.0 as f32);
        let duration_s = 1e-6 * (end.0 - self.since.0).max(1) as f32;
        // Pairs of an event among events of this rate that lie anywhere: it has two neighbours.
        let pairs_at = |rate_hz: f32| 2.0 * rate_hz * near_s;
        let rate_hz = events / (self.last.len() as f32 * duration_s);
        PAIRS as f32 >= events * (CROWDED * pairs_at(rate_hz)).min(pairs_at(NOISE_HZ))
    }

    fn evaluate(&mut self, end: Micros) {
        let share = |count: u32| count as f32 / PAIRS as f32;
        if self.are_of_edges(end) {
            let on = share(self.on);
            // Independent polarities agree if both are ON or both are OFF.
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
