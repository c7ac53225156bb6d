//! The sixteen ways in which columns, rows and polarities can be mixed up.
//!
//! # Method
//! ON minus OFF events of 20 ms, smoothed over three by three pixels, are an image. The score of a
//! symmetry is the cosine between all images of the recording, transformed by it, and those of the
//! reference events of the scene. Since an effect may delay events, the recording as it is counts
//! with its best score at lags of -40 to 100 ms. A symmetry is clear if its score is much larger,
//! by five standard errors over parts of image and time, and if the rates of ON minus OFF events
//! do not speak against its polarity.

use std::fmt;

use evpose_core::{Event, EventStream, Polarity, SensorSize};

/// Length of a slice.
const SLICE_US: i64 = 20_000;
/// Five seconds; longer recordings do not change the result.
const MAX_SLICES: usize = 250;
/// Slices by which a recording may be late or early.
const LAGS: std::ops::RangeInclusive<i64> = -2..=5;
/// Fewer events say nothing of the orientation.
const MIN_EVENTS: usize = 200;
/// A score must be larger than that of the recording as it is by this much, ...
const MIN_ADVANTAGE: f64 = 0.05;
/// ... by this factor, ...
const MIN_RATIO: f64 = 1.5;
/// ... and by this many standard errors.
const MIN_Z: f64 = 5.0;
/// Scores that are as good as the best.
const AS_GOOD: f64 = 0.98;
/// Tiles along each side of the image, for standard errors.
const TILES: usize = 4;

/// A mix-up: columns and rows exchanged, then columns and rows mirrored; polarities exchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Symmetry {
    /// Columns are rows.
    pub transposes: bool,
    /// The first column is the last.
    pub mirrors_columns: bool,
    /// The first row is the last.
    pub mirrors_rows: bool,
    /// ON is OFF.
    pub swaps_polarity: bool,
}

impl Symmetry {
    /// All sixteen, the simplest first.
    pub fn all() -> [Self; 16] {
        let mut all = std::array::from_fn(|i| Self {
            transposes: i & 8 > 0,
            mirrors_columns: i & 1 > 0,
            mirrors_rows: i & 2 > 0,
            swaps_polarity: i & 4 > 0,
        });
        all.sort_by_key(|symmetry: &Self| symmetry.changes());
        all
    }

    fn changes(self) -> usize {
        [self.transposes, self.mirrors_columns, self.mirrors_rows, self.swaps_polarity]
            .iter()
            .filter(|does| **does)
            .count()
    }

    /// The sensor behind it.
    pub fn size(self, size: SensorSize) -> SensorSize {
        if self.transposes { SensorSize { width: size.height, height: size.width } } else { size }
    }

    /// Transformed position of a pixel of a sensor of this size.
    pub fn place(self, size: SensorSize, (x, y): (u16, u16)) -> (u16, u16) {
        let (x, y) = if self.transposes { (y, x) } else { (x, y) };
        let size = self.size(size);
        let x = if self.mirrors_columns { size.width - 1 - x } else { x };
        let y = if self.mirrors_rows { size.height - 1 - y } else { y };
        (x, y)
    }

    /// The recording behind it.
    pub fn apply(self, events: &EventStream) -> EventStream {
        let size = events.sensor();
        let put = |event: Event| {
            let (x, y) = self.place(size, (event.x, event.y));
            let was = event.polarity;
            let polarity = if self.swaps_polarity { was.flipped() } else { was };
            Event { x, y, polarity, ..event }
        };
        EventStream::from_events(self.size(size), events.iter().map(put))
            .unwrap_or_else(|_| unreachable!("pixels go to pixels, times stay"))
    }

    /// The inverse transformation.
    #[must_use]
    pub fn inverse(self) -> Self {
        if !self.transposes {
            return self;
        }
        // Mirrors follow the exchange of axes, so that undoing them in reverse exchanges them.
        Self { mirrors_columns: self.mirrors_rows, mirrors_rows: self.mirrors_columns, ..self }
    }
}

/// Symmetry that aligns a recording with its reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Orientation {
    /// The simplest of the best.
    pub best: Symmetry,
    /// Others that the scene does not distinguish from it.
    pub as_good: Vec<Symmetry>,
    /// Its score, at most one.
    pub score: f64,
    /// The score of the recording as it is; none if its sensor does not fit.
    pub as_it_is: Option<f64>,
    /// The difference of the two in standard errors.
    pub advantage_z: f64,
    /// Correlation of the rates of ON minus OFF events.
    pub rate_correlation: f64,
    /// Whether the recording should be transformed.
    pub is_clear: bool,
}

/// Tries all sixteen symmetries against the reference events of the scene. None if there are too
/// few events, or if no symmetry makes the sensor fit.
pub fn find(recording: &EventStream, reference: &EventStream) -> Option<Orientation> {
    if recording.len() < MIN_EVENTS || reference.len() < MIN_EVENTS {
        return None;
    }
    let (size, target) = (recording.sensor(), reference.sensor());
    let slices = (reference.t()[reference.len() - 1].0 / SLICE_US + 1).max(1) as usize;
    let slices = slices.min(MAX_SLICES);
    let (seen, wanted) =
        (Images::from_events(recording, slices), Images::from_events(reference, slices));
    let norm = (seen.power() * wanted.power()).sqrt();
    let (seen_rate, wanted_rate) = (seen.rate(), wanted.rate());
    let rate_correlation = correlation(&seen_rate, &wanted_rate);
    // Without a pattern there is nothing to compare.
    if norm <= 0.0 {
        return None;
    }
    let mut scored: Vec<(Symmetry, f64, Vec<f64>)> = Vec::new();
    for symmetry in Symmetry::all() {
        // Sides exchanged, the sensor would have another shape.
        if symmetry.size(size) != target {
            continue;
        }
        let sign = if symmetry.swaps_polarity { -1.0 } else { 1.0 };
        // Summed by slice and tile: the parts give the error of the advantage.
        let mut parts = seen.products(&wanted, symmetry, 0);
        parts.iter_mut().for_each(|part| *part *= sign / norm);
        scored.push((symmetry, parts.iter().sum(), parts));
    }
    let top = scored.iter().map(|(_, score, _)| *score).fold(f64::NEG_INFINITY, f64::max);
    let good: Vec<usize> = (0..scored.len()).filter(|i| scored[*i].1 >= AS_GOOD * top).collect();
    let (best, score, parts) = &scored[*good.first()?];
    let as_good = good[1..].iter().map(|i| scored[*i].0).collect();
    let identity = scored.iter().find(|(symmetry, ..)| *symmetry == Symmetry::default());
    // A late recording is not mixed up: the best of several lags counts for it as it is.
    let as_it_is = identity.map(|_| {
        let at = |lag| seen.products(&wanted, Symmetry::default(), lag).iter().sum::<f64>() / norm;
        LAGS.map(at).fold(f64::NEG_INFINITY, f64::max)
    });
    let differences: Vec<f64> = match identity {
        Some((.., same)) => parts.iter().zip(same).map(|(a, b)| a - b).collect(),
        // A sensor that fits only when transposed has no score of its own to exceed.
        None => parts.clone(),
    };
    let advantage_z = standard_errors(&differences);
    let against = as_it_is.unwrap_or(0.0);
    // The net rate shows a swapped polarity; a correlation over n slices has the error 1/sqrt(n).
    let contradicts = if best.swaps_polarity { rate_correlation } else { -rate_correlation }
        > 3.0 / (slices as f64).sqrt();
    let is_clear = *best != Symmetry::default()
        && score - against >= MIN_ADVANTAGE
        && *score >= MIN_RATIO * against.max(0.0)
        && advantage_z >= MIN_Z
        && !contradicts;
    let (best, score) = (*best, *score);
    Some(Orientation { best, as_good, score, as_it_is, advantage_z, rate_correlation, is_clear })
}

/// The sum of parts over its standard error, as if parts were independent.
fn standard_errors(parts: &[f64]) -> f64 {
    let power: f64 = parts.iter().map(|part| part * part).sum();
    if power > 0.0 { parts.iter().sum::<f64>() / power.sqrt() } else { 0.0 }
}

/// Pearson's correlation; zero where one of the two does not vary.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - ma, y - mb);
        ab += x * y;
        aa += x * x;
        bb += y * y;
    }
    if aa * bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

/// Smoothed images of ON minus OFF events, slice after slice.
struct Images {
    size: SensorSize,
    values: Vec<f32>,
}

impl Images {
    fn from_events(events: &EventStream, slices: usize) -> Self {
        let size = events.sensor();
        let (width, pixels) = (usize::from(size.width), size.pixels());
        let mut values = vec![0f32; pixels * slices];
        for event in events.iter() {
            let slice = event.t.0.div_euclid(SLICE_US);
            if (0..slices as i64).contains(&slice) {
                let pixel = usize::from(event.y) * width + usize::from(event.x);
                let sign = if event.polarity == Polarity::On { 1.0 } else { -1.0 };
                values[slice as usize * pixels + pixel] += sign;
            }
        }
        // Smoothed, so that a shift of one pixel lowers a score little.
        values.chunks_exact_mut(pixels).for_each(|image| smooth(image, width));
        Self { size, values }
    }

    fn power(&self) -> f64 {
        self.values.iter().map(|value| f64::from(value * value)).sum()
    }

    /// The sum of each slice.
    fn rate(&self) -> Vec<f64> {
        let sum = |image: &[f32]| image.iter().map(|value| f64::from(*value)).sum();
        self.values.chunks_exact(self.size.pixels()).map(sum).collect()
    }

    /// Products with another recording's images, by slice and tile, when pixels go where the
    /// symmetry puts them and this recording is late by `lag` slices.
    fn products(&self, other: &Self, symmetry: Symmetry, lag: i64) -> Vec<f64> {
        let (pixels, width) = (self.size.pixels(), usize::from(self.size.width));
        let (across, down) = (usize::from(other.size.width), usize::from(other.size.height));
        // Once for all slices.
        let places: Vec<(usize, usize)> = (0..pixels)
            .map(|pixel| {
                let from = ((pixel % width) as u16, (pixel / width) as u16);
                let (x, y) = symmetry.place(self.size, from);
                let (x, y) = (usize::from(x), usize::from(y));
                // Tiles are those of the reference, so that the parts of all symmetries correspond.
                (y * across + x, y * TILES / down * TILES + x * TILES / across)
            })
            .collect();
        let slices = self.values.len() / pixels;
        let mut parts = vec![0.0; slices * TILES * TILES];
        for slice in 0..slices {
            let Some(then) = slice.checked_sub_signed(lag as isize).filter(|k| *k < slices) else {
                continue;
            };
            let mine = &self.values[slice * pixels..][..pixels];
            let theirs = &other.values[then * pixels..][..pixels];
            let tiles = &mut parts[slice * TILES * TILES..][..TILES * TILES];
            for (value, (place, tile)) in mine.iter().zip(&places) {
                tiles[*tile] += f64::from(value * theirs[*place]);
            }
        }
        parts
    }
}

/// Sums over three by three pixels, with nothing outside.
fn smooth(image: &mut [f32], width: usize) {
    // Rows and columns by themselves: three additions each instead of nine.
    let mut row = vec![0.0; width];
    for line in image.chunks_exact_mut(width) {
        row.copy_from_slice(line);
        for x in 0..width {
            line[x] = row[x.saturating_sub(1)..(x + 2).min(width)].iter().sum();
        }
    }
    let height = image.len() / width;
    let mut column = vec![0.0; height];
    for x in 0..width {
        for (y, value) in column.iter_mut().enumerate() {
            *value = image[y * width + x];
        }
        for y in 0..height {
            image[y * width + x] = column[y.saturating_sub(1)..(y + 2).min(height)].iter().sum();
        }
    }
}

impl fmt::Display for Symmetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts: Vec<&str> = [
            (self.transposes, "columns and rows exchanged"),
            (self.mirrors_columns, "columns mirrored"),
            (self.mirrors_rows, "rows mirrored"),
            (self.swaps_polarity, "ON and OFF exchanged"),
        ]
        .into_iter()
        .filter_map(|(does, words)| does.then_some(words))
        .collect();
        if parts.is_empty() { f.pad("as it is") } else { f.pad(&parts.join(", ")) }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{CounterRng, Micros};

    use super::*;

    const SIZE: SensorSize = SensorSize { width: 40, height: 30 };

    /// A bright spot that grows brighter while it moves and dims where it was, without any
    /// symmetry.
    fn reference() -> EventStream {
        let mut rng = CounterRng::new(5, "spot", 0);
        let event = |k: i64| {
            let along = k as f32 / 20_000.0;
            let on = k % 3 > 0;
            let behind = if on { 0.0 } else { 4.0 };
            let x = 4.0 + 25.0 * along - behind + rng.uniform(0.0, 3.0);
            let y = 3.0 + 9.0 * along * along + rng.uniform(0.0, 2.0);
            let polarity = Polarity::from_on(on);
            Event { t: Micros(40 * k), x: x.max(0.0) as u16, y: y as u16, polarity }
        };
        EventStream::from_events(SIZE, (0..20_000).map(event)).unwrap()
    }

    #[test]
    fn each_mix_up_is_detected_by_a_recording_of_the_same_scene() {
        let reference = reference();
        for symmetry in Symmetry::all() {
            let orientation = find(&symmetry.apply(&reference), &reference).unwrap();
            assert_eq!(orientation.best, symmetry.inverse(), "{symmetry}");
            assert_eq!(orientation.is_clear, symmetry != Symmetry::default());
            assert!((orientation.score - 1.0).abs() < 1e-6, "{orientation:?}");
            if symmetry == Symmetry::default() {
                let as_it_is = orientation.as_it_is.unwrap();
                assert!((as_it_is - 1.0).abs() < 1e-6, "{orientation:?}");
            }
        }
    }

    #[test]
    fn the_sixteen_differ_the_simplest_first_and_inverses_undo_them() {
        let (all, reference) = (Symmetry::all(), reference());
        let simple = |symmetry: &Symmetry| {
            let words = format!("{symmetry}");
            if words == "as it is" { 0 } else { words.split(", ").count() }
        };
        assert!(all[0] == Symmetry::default() && all.is_sorted_by_key(simple));
        for (i, symmetry) in all.into_iter().enumerate() {
            assert!(!all[..i].contains(&symmetry), "{symmetry}");
            assert_eq!(symmetry.inverse().apply(&symmetry.apply(&reference)), reference);
        }
    }

    #[test]
    fn products_are_of_their_slice_and_tile() {
        // Tiles of 10 by 8 pixels, an event in the middle of one.
        let size = SensorSize { width: 40, height: 32 };
        let spot = |slice: i64, x, y| {
            let event = Event { t: Micros(20_000 * slice + 3), x, y, polarity: Polarity::On };
            Images::from_events(&EventStream::from_events(size, [event]).unwrap(), 3)
        };
        let mirrored = Symmetry { mirrors_columns: true, ..Symmetry::default() };
        for (slice, tile) in (1..3_i64).flat_map(|slice| (0..16_u16).map(move |tile| (slice, tile)))
        {
            let (x, y) = (10 * (tile % 4) + 5, 8 * (tile / 4) + 4);
            let images = spot(slice, x, y);
            // Smoothing makes nine ones of one event.
            assert_eq!((images.power(), images.rate()[slice as usize]), (9.0, 9.0));
            let mut wanted = vec![0.0; 3 * 16];
            wanted[16 * slice as usize + usize::from(tile)] = 9.0;
            assert_eq!(images.products(&images, Symmetry::default(), 0), wanted);
            assert_eq!(images.products(&spot(slice - 1, x, y), Symmetry::default(), 1), wanted);
            assert_eq!(spot(slice, 39 - x, y).products(&images, mirrored, 0), wanted);
        }
    }

    #[test]
    fn correlations_are_pearsons() {
        // Deviations -1.5, -0.5, 0.5, 1.5 and -0.5, -1.5, 1.5, 0.5: 3 of 5.
        let (a, b) = ([1.0, 2.0, 3.0, 4.0], [12.0, 11.0, 14.0, 13.0]);
        assert!((correlation(&a, &b) - 0.6).abs() < 1e-12);
        let scaled = b.map(|value| 5.0 - 7.0 * value);
        assert!((correlation(&scaled, &a) + 0.6).abs() < 1e-12);
        assert_eq!(correlation(&a, &[3.0; 4]), 0.0);
        assert_eq!(
            (standard_errors(&[3.0, 4.0, -2.0]), standard_errors(&[])),
            (5.0 / 29f64.sqrt(), 0.0)
        );
    }

    #[test]
    fn smoothing_sums_three_by_three_pixels() {
        let (width, height) = (5, 4);
        for lit in 0..width * height {
            let mut image = vec![0.0; width * height];
            image[lit] = 2.0;
            smooth(&mut image, width);
            for (pixel, value) in image.into_iter().enumerate() {
                let is_near = (pixel % width).abs_diff(lit % width) <= 1
                    && (pixel / width).abs_diff(lit / width) <= 1;
                assert_eq!(value, if is_near { 2.0 } else { 0.0 }, "{pixel} of {lit}");
            }
        }
    }

    #[test]
    fn too_few_events_decide_nothing() {
        let few = EventStream::from_events(SIZE, reference().iter().take(199)).unwrap();
        assert_eq!(find(&few, &reference()), None);
        let enough = EventStream::from_events(SIZE, reference().iter().take(200)).unwrap();
        assert!(find(&enough, &enough).is_some());
    }
}
