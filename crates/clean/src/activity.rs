//! How often each pixel fires, and which of them are hot.
//!
//! # Model
//! Two rules. *Neighbours*: a pixel with `n` events is hot if that is clearly more than
//! `m = factor` times the median of the pixels around it, `2 (√(n + 3/8) - √(m + 3/8)) > 5`, and at
//! least one a second. The left side is Anscombe's transform: a difference of Poisson counts in
//! standard deviations, so that less than one pixel in a million is hot by chance. The median of a
//! square of five by five stands firm with eleven hot pixels in it. *Count*: a pixel is hot from so
//! many events in the recording on, however long it is; DHP19's rule, with 10,000.
//!
//! The scene may move: an edge passes over neighbours as well. What lights up a single pixel again
//! and again, as a distant lamp that blinks, looks like a hot pixel and is one here.
//!
//! # Source
//! The factor of 5 is that of `evpose calibrate` for scenes at rest; rates of hot pixels begin at
//! about one a second. Anscombe, *The transformation of Poisson, binomial and negative-binomial
//! data*, Biometrika 35, 1948.

use evpose_core::{EventStream, Micros, SensorSize};

use crate::Mask;

/// Standard deviations beyond which a count is not chance.
const CLEAR: f64 = 5.0;
/// Event rate, per second, below which a pixel is never hot.
const MIN_HZ: f64 = 1.0;
/// Pixels to each side that are neighbours.
const REACH: usize = 2;

/// When a pixel is hot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HotRule {
    /// More events than this multiple of the median of the neighbours.
    Neighbours {
        /// How many times.
        factor: f64,
    },
    /// This many events or more.
    Count(u32),
}

impl HotRule {
    /// That of DHP19.
    pub const DHP19: Self = Self::Count(10_000);
}

impl Default for HotRule {
    fn default() -> Self {
        Self::Neighbours { factor: 5.0 }
    }
}

/// A pixel that fires without a cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HotPixel {
    /// Column.
    pub x: u16,
    /// Row.
    pub y: u16,
    /// Events that it has.
    pub events: u32,
    /// The same a second; infinite for a recording without length.
    pub rate_hz: f64,
}

/// Events of each pixel of a recording.
#[derive(Debug, Clone)]
pub struct PixelActivity {
    sensor: SensorSize,
    counts: Vec<u32>,
    span: Option<(Micros, Micros)>,
}

impl PixelActivity {
    /// Counts of zero.
    pub fn new(sensor: SensorSize) -> Self {
        Self { sensor, counts: vec![0; sensor.pixels()], span: None }
    }

    /// Counts a batch.
    ///
    /// # Panics
    /// If its sensor is another one.
    pub fn push(&mut self, events: &EventStream) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
        let width = usize::from(self.sensor.width);
        for (&x, &y) in events.x().iter().zip(events.y()) {
            let count = &mut self.counts[usize::from(y) * width + usize::from(x)];
            // A count that wraps around would make the hottest pixel a cold one.
            *count = count.saturating_add(1);
        }
        if let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) {
            self.span = Some((self.span.map_or(first, |(start, _)| start), last));
        }
    }

    /// Events of each pixel, row by row from the top.
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// Seconds from the first event to the last.
    pub fn seconds(&self) -> f64 {
        self.span.map_or(0.0, |(first, last)| last.as_seconds() - first.as_seconds())
    }

    /// The hot pixels, those with the most events first.
    pub fn hot(&self, rule: HotRule) -> Vec<HotPixel> {
        let width = usize::from(self.sensor.width);
        let seconds = self.seconds();
        let mut hot: Vec<HotPixel> = (0..self.counts.len())
            .filter(|&pixel| self.is_hot(pixel, rule))
            .map(|pixel| HotPixel {
                x: (pixel % width) as u16,
                y: (pixel / width) as u16,
                events: self.counts[pixel],
                rate_hz: f64::from(self.counts[pixel]) / seconds,
            })
            .collect();
        // Of as many events, in the order of rows: the same list every time.
        hot.sort_by_key(|pixel| (std::cmp::Reverse(pixel.events), pixel.y, pixel.x));
        hot
    }

    /// The mask of pixels that are hot.
    pub fn mask(&self, rule: HotRule) -> Mask {
        let pixels = self.hot(rule).iter().map(|pixel| (pixel.x, pixel.y)).collect();
        Mask { pixels, ..Mask::new(self.sensor) }
    }

    fn is_hot(&self, pixel: usize, rule: HotRule) -> bool {
        let count = self.counts[pixel];
        match rule {
            HotRule::Count(least) => count >= least,
            HotRule::Neighbours { factor } => {
                let spread = |n: f64| 2.0 * (n + 0.375).sqrt();
                let n = f64::from(count);
                // Most pixels are settled without their neighbours.
                n >= MIN_HZ * self.seconds()
                    && spread(n) - spread(0.0) > CLEAR
                    && spread(n) - spread(factor * self.around(pixel)) > CLEAR
            }
        }
    }

    /// The median of the pixels around one.
    fn around(&self, pixel: usize) -> f64 {
        let (width, height) = (usize::from(self.sensor.width), usize::from(self.sensor.height));
        let (x, y) = (pixel % width, pixel / width);
        let columns = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
        let rows = y.saturating_sub(REACH)..(y + REACH + 1).min(height);
        // A median, so that a second hot pixel nearby does not hide the first.
        let mut around: Vec<u32> = rows
            .flat_map(|row| columns.clone().map(move |column| row * width + column))
            .filter(|&neighbour| neighbour != pixel)
            .map(|neighbour| self.counts[neighbour])
            .collect();
        around.sort_unstable();
        match around.len() {
            0 => 0.0,
            n => 0.5 * (f64::from(around[(n - 1) / 2]) + f64::from(around[n / 2])),
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{CounterRng, Event, Polarity};

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 40, height: 30 };

    fn activity(counts: Vec<u32>, seconds: i64) -> PixelActivity {
        assert_eq!(counts.len(), SENSOR.pixels());
        PixelActivity {
            sensor: SENSOR,
            counts,
            span: Some((Micros(0), Micros(seconds * 1_000_000))),
        }
    }

    #[test]
    fn the_limit_is_where_the_formula_puts_it() {
        // 5 * 20 = 100: 2 (√(n + 3/8) - √100.375) > 5 from 157 on; with none around, from 10 on.
        for (level, limit) in [(20, 157), (0, 10)] {
            for n in [limit - 1, limit] {
                let mut counts = vec![level; SENSOR.pixels()];
                counts[15 * 40 + 20] = n;
                let hot = activity(counts, 4).hot(HotRule::default());
                assert_eq!(hot.len(), usize::from(n == limit), "{n} over {level}");
                if let [pixel] = hot[..] {
                    assert_eq!((pixel.x, pixel.y, pixel.events), (20, 15, n));
                    assert!((pixel.rate_hz - f64::from(n) / 4.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn neighbours_are_up_to_two_columns_and_two_rows_away() {
        let mut rng = CounterRng::new(4, "around", 0);
        let counts: Vec<u32> = (0..SENSOR.pixels()).map(|_| rng.below(1_000) as u32).collect();
        let all = activity(counts.clone(), 1);
        for pixel in 0..SENSOR.pixels() {
            let (x, y) = (pixel % 40, pixel / 40);
            let is_near = |other: &usize| {
                *other != pixel && (other % 40).abs_diff(x) <= 2 && (other / 40).abs_diff(y) <= 2
            };
            let near = (0..SENSOR.pixels()).filter(is_near);
            let mut near: Vec<f64> = near.map(|other| f64::from(counts[other])).collect();
            near.sort_by(f64::total_cmp);
            let half = near.len() / 2;
            let median = match near.len() % 2 {
                0 => f64::midpoint(near[half - 1], near[half]),
                _ => near[half],
            };
            assert_eq!(all.around(pixel), median, "({x}, {y})");
        }
    }

    #[test]
    fn hot_pixels_beside_each_other_and_in_corners_are_found_and_a_busy_edge_is_not_hot() {
        let mut counts: Vec<u32> = (0..SENSOR.pixels()).map(|i| 1 + (i % 3) as u32).collect();
        for row in counts.chunks_exact_mut(40) {
            row[10..13].fill(90);
        }
        let mut wanted = [(0, 0), (39, 29), (25, 10), (26, 10), (26, 11), (11, 20)];
        for (x, y) in wanted {
            counts[y * 40 + x] = 5_000;
        }
        let mut hot: Vec<(usize, usize)> = activity(counts, 10)
            .hot(HotRule::default())
            .iter()
            .map(|pixel| (usize::from(pixel.x), usize::from(pixel.y)))
            .collect();
        hot.sort_unstable();
        wanted.sort_unstable();
        assert_eq!(hot, wanted);
    }

    #[test]
    fn a_slow_pixel_hurts_nobody_and_the_rule_of_dhp19_counts() {
        let mut counts = vec![0; SENSOR.pixels()];
        counts[0] = 10_000;
        counts[7] = 9_999;
        // In 20,000 s this is half an event a second, below the least rate.
        let hours = activity(counts, 20_000);
        assert!(hours.hot(HotRule::default()).is_empty());
        assert_eq!(hours.mask(HotRule::DHP19).pixels, [(0, 0)]);
    }

    #[test]
    fn poisson_counts_alone_make_no_hot_pixel() {
        for seed in 0..20 {
            let mut rng = CounterRng::new(seed, "counts", 0);
            // Sums of many rare events.
            let counts = (0..SENSOR.pixels())
                .map(|_| (0..400).filter(|_| rng.chance(0.01)).count() as u32)
                .collect();
            assert!(activity(counts, 1).hot(HotRule::default()).is_empty(), "seed {seed}");
        }
    }

    #[test]
    fn batches_add_up() {
        let event = |t, x| Event { t: Micros(t), x, y: 2, polarity: Polarity::Off };
        let mut activity = PixelActivity::new(SENSOR);
        for batch in [[event(5, 1), event(7, 1)], [event(8, 1), event(2_000_005, 3)]] {
            activity.push(&EventStream::from_events(SENSOR, batch).unwrap());
        }
        assert_eq!(activity.counts()[2 * 40 + 1], 3);
        assert!((activity.seconds() - 2.0).abs() < 1e-9);
    }
}
