//! Differences between pixels, and whether they stay.

use super::value::Value;
use crate::View;

/// Length of the parts of time that alternate between two halves.
const ALTERNATING_US: i64 = 50_000;
/// Fewest events that the ideal sensor has in a pixel and half.
const MIN_EXPECTED: f64 = 1.0;
/// Largest logarithm of a count over what is expected that counts: beyond it a pixel is dead or hot.
const MAX_LOG: f64 = 1.0;
/// Fewest pixels of a pattern.
const ENOUGH_PIXELS: usize = 200;
/// Events that the ideal sensor has of a pixel, from which one without any is silent.
const CERTAIN_EVENTS: usize = 8;
/// Neighbours of a silent pixel that have events: pixels die one by one.
const LIVE_NEIGHBOURS: usize = 5;
/// Events by which, and factors by which, a hot pixel exceeds the median and the largest of its
/// neighbours.
const HOT_EXCESS: f64 = 8.0;
const HOT_FACTORS: [f64; 2] = [4.0, 2.0];
/// Rate below which nobody would call a pixel hot, Hz.
pub(crate) const MIN_HOT_HZ: f64 = 3.0;

/// Logarithms of counts per pixel over those of the ideal sensor, in two halves of the time.
struct Halves {
    residuals: [Vec<f64>; 2],
    expected: [Vec<f64>; 2],
}

impl Halves {
    fn new(view: &View<'_>, half: impl Fn(i64) -> usize) -> Self {
        let pixels = view.size().pixels();
        let zeros = || [vec![0.0; pixels], vec![0.0; pixels]];
        let (mut residuals, mut expected) = (zeros(), zeros());
        for event in view.events() {
            residuals[half(view.since_start_us(event.t_us))][event.pixel as usize] += 1.0;
        }
        let channels = (0..pixels).flat_map(|pixel| [(pixel, false), (pixel, true)]);
        for (pixel, is_on) in channels {
            for t_us in view.reference_scene.expected.times(pixel, is_on) {
                expected[half(view.since_start_us(*t_us))][pixel] += 1.0;
            }
        }
        for (counts, expected) in residuals.iter_mut().zip(&expected) {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (count, expected) in counts.iter_mut().zip(expected) {
                // The logarithm: a threshold is a factor, and one pixel that has many is not all.
                *count = f64::ln((*count + 0.5) / (expected + 0.5));
                if *expected >= MIN_EXPECTED {
                    sum += expected * *count;
                    weights += expected;
                }
            }
            // Without the gain of all pixels, which is no difference between them.
            let gain = sum / f64::max(weights, 1.0);
            counts.iter_mut().for_each(|log| *log = (*log - gain).clamp(-MAX_LOG, MAX_LOG));
        }
        Self { residuals, expected }
    }

    /// Weight of a pixel: what is expected in the half that has less; zero of too few.
    fn weight(&self, pixel: usize) -> f64 {
        let least = self.expected[0][pixel].min(self.expected[1][pixel]);
        if least >= MIN_EXPECTED { least } else { 0.0 }
    }
}

/// Weighted mean of products of both halves; `shared` is the factor on its error by terms that are
/// not independent. None of too few.
fn mean_product(terms: impl Iterator<Item = (f64, f64)>, shared: f64) -> Option<Value> {
    let (mut sum, mut squares, mut weights, mut count) = (0.0, 0.0, 0.0, 0);
    for (term, weight) in terms.filter(|(_, weight)| *weight > 0.0) {
        sum += weight * term;
        squares += (weight * term).powi(2);
        weights += weight;
        count += 1;
    }
    (count >= ENOUGH_PIXELS).then(|| Value::new(sum / weights, shared * squares.sqrt() / weights))
}

/// Variance of pixels that both halves of the recording, the first and the last, agree on, of
/// differences between neighbours: what is smooth in the image is no mismatch.
pub(super) fn fixed_pattern(view: &View<'_>) -> Option<Value> {
    let middle_us = view.window.length().0 / 2;
    let halves = Halves::new(view, |us| usize::from(us >= middle_us));
    let (width, height) = (usize::from(view.size().width), usize::from(view.size().height));
    let pairs = (0..width * height).flat_map(|pixel| {
        let right = (pixel % width + 1 < width).then_some((pixel, pixel + 1));
        let below = (pixel / width + 1 < height).then_some((pixel, pixel + width));
        [right, below].into_iter().flatten()
    });
    let terms = pairs.map(|(one, other)| {
        let [first, last] = halves.residuals.each_ref().map(|half| half[one] - half[other]);
        // A difference of two pixels has twice the variance of one.
        (0.5 * first * last, halves.weight(one).min(halves.weight(other)))
    });
    mean_product(terms, 2.0)
}

/// Variance of pixels that alternating parts of the time agree on: also of what drifts, and of what
/// neighbours share.
pub(super) fn lasting_pattern(view: &View<'_>) -> Option<Value> {
    let halves = Halves::new(view, |us| (us.div_euclid(ALTERNATING_US) % 2) as usize);
    let [first, last] = &halves.residuals;
    let pixels = 0..view.size().pixels();
    mean_product(pixels.map(|pixel| (first[pixel] * last[pixel], halves.weight(pixel))), 1.0)
}

/// Neighbours of a pixel, at most eight.
fn neighbours(pixel: usize, width: usize, height: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % width, pixel / width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    rows.flat_map(move |v| (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| v * width + u))
        .filter(move |other| *other != pixel)
}

/// Pixels without any event whose neighbours have events, where the ideal sensor has many.
pub(super) fn silent(view: &View<'_>) -> Option<Value> {
    let (width, height) = (usize::from(view.size().width), usize::from(view.size().height));
    let mut has_events = vec![false; width * height];
    view.events().iter().for_each(|event| has_events[event.pixel as usize] = true);
    let expected = &view.reference_scene.expected;
    let is_certain = |pixel: usize| {
        expected.times(pixel, false).len() + expected.times(pixel, true).len() >= CERTAIN_EVENTS
    };
    let certain: Vec<usize> = (0..width * height).filter(|pixel| is_certain(*pixel)).collect();
    let is_dead = |pixel: &&usize| {
        let live = neighbours(**pixel, width, height).filter(|other| has_events[*other]);
        !has_events[**pixel] && live.count() >= LIVE_NEIGHBOURS
    };
    let count = certain.iter().filter(is_dead).count();
    (certain.len() >= ENOUGH_PIXELS).then(|| Value::of_count(count as f64))
}

/// Pixels whose rate is far above those of their neighbours and above [`MIN_HOT_HZ`], in both halves
/// of the recording.
pub(super) fn hot(view: &View<'_>) -> Option<Value> {
    let (width, height) = (usize::from(view.size().width), usize::from(view.size().height));
    let middle_us = view.window.length().0 / 2;
    let mut halves = [vec![0.0_f64; width * height], vec![0.0; width * height]];
    for event in view.events() {
        let half = usize::from(view.since_start_us(event.t_us) >= middle_us);
        halves[half][event.pixel as usize] += 1.0;
    }
    let count = |pixel: usize| halves[0][pixel] + halves[1][pixel];
    let mut near = Vec::with_capacity(8);
    let mut is_hot = |pixel: &usize| {
        near.clear();
        near.extend(neighbours(*pixel, width, height).map(count));
        near.sort_by(f64::total_cmp);
        let (Some(max), median) = (near.last(), near.get(near.len() / 2)) else { return false };
        let (n, median) = (count(*pixel), median.copied().unwrap_or(0.0));
        let stays = halves.iter().all(|half| half[*pixel] >= 0.25 * n);
        stays
            && n > HOT_FACTORS[0] * median + HOT_EXCESS
            && n > HOT_FACTORS[1] * max
            && n >= MIN_HOT_HZ * view.seconds()
    };
    let hot = (0..width * height).filter(|pixel| is_hot(pixel)).count();
    Some(Value::of_count(hot as f64))
}

/// Displacement away from the centre of the image, in pixels at the corner.
pub(super) fn radial(view: &View<'_>) -> Option<Value> {
    /// Error of a displacement that two simulators of one sensor differ by, pixels.
    const TOLERANCE_PX: f64 = 0.05;
    let (columns, rows) = crate::probe::TILES;
    let aspect = f64::from(view.size().height) / f64::from(view.size().width);
    let half = (1.0 + aspect * aspect).sqrt();
    let at = |i: usize, n: usize| (i as f64 + 0.5) / n as f64 * 2.0 - 1.0;
    let (mut along, mut squares, mut count) = (0.0, 0.0, 0);
    for (tile, moved) in crate::probe::displacements(view).into_iter().enumerate() {
        let Some((dx, dy)) = moved else { continue };
        let x = at(tile % columns, columns) / half;
        let y = aspect * at(tile / columns, rows) / half;
        along += dx * x + dy * y;
        squares += x * x + y * y;
        count += 1;
    }
    (count >= 6).then(|| Value::new(along / squares, TOLERANCE_PX))
}
