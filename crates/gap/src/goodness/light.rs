//! Counts of events by what the light does: fast or slow, fine or even, dark or bright, at rest.

use super::value::Value;
use crate::{Cell, EventFeatures, View};

/// Most of the milliseconds that count as calm; the others are busy.
const CALM: f64 = 0.95;

/// Events of two classes, measured and of the ideal sensor.
fn counts(view: &View<'_>, class: impl Fn(Cell, i64) -> Option<bool>) -> ([f64; 2], [f64; 2]) {
    let (mut counts, mut expected) = ([0.0; 2], [0.0; 2]);
    for event in view.events() {
        if let Some(is_second) = class(event.cell, event.t_us) {
            counts[usize::from(is_second)] += 1.0;
        }
    }
    let known = view.reference_scene;
    for pixel in 0..view.size().pixels() {
        for is_on in [false, true] {
            for t_us in known.expected.times(pixel, is_on) {
                let cell = known.classes.cell(pixel, 1e-6 * *t_us as f64);
                if let Some(is_second) = class(cell, *t_us) {
                    expected[usize::from(is_second)] += 1.0;
                }
            }
        }
    }
    (counts, expected)
}

/// Logarithm of the events over those of the ideal sensor, in a first class less that in a second.
fn contrast(view: &View<'_>, class: impl Fn(Cell, i64) -> Option<bool>) -> Option<Value> {
    let (counts, expected) = counts(view, class);
    let [first, second] = [0, 1].map(|i| Value::log_ratio(counts[i], expected[i]));
    Some(first?.less(second?))
}

/// Whether a moving pixel is bright; none between the two.
pub(super) fn is_bright(cell: Cell) -> Option<bool> {
    match cell.brightness() {
        0 | 1 => Some(false),
        2 => None,
        _ => Some(true),
    }
}

/// Mask of the light that changes.
pub(super) fn count(view: &View<'_>) -> Option<Value> {
    let (counts, expected) = counts(view, |cell, _| (cell.speed() > 0).then_some(false));
    Value::log_ratio(counts[0], expected[0])
}

/// Mask of light that changes fast, less that of light that changes slowly.
pub(super) fn fast(view: &View<'_>) -> Option<Value> {
    contrast(view, |cell, _| match cell.speed() {
        3 => Some(false),
        1 => Some(true),
        _ => None,
    })
}

/// On fine structure, less on even light.
pub(super) fn fine(view: &View<'_>) -> Option<Value> {
    contrast(view, |cell, _| (cell.speed() > 0).then_some(!cell.is_fine()))
}

/// In the dark, less in bright light.
pub(super) fn dark(view: &View<'_>) -> Option<Value> {
    contrast(view, |cell, _| is_bright(cell).filter(|_| cell.speed() > 0))
}

/// In the last third of the time, less in the first.
pub(super) fn late(view: &View<'_>) -> Option<Value> {
    let third_us = view.window.length().0 / 3;
    contrast(view, |cell, t_us| {
        let third = view.since_start_us(t_us) / third_us.max(1);
        let class = match third {
            0 => Some(true),
            2 => Some(false),
            _ => None,
        };
        class.filter(|_| cell.speed() > 0)
    })
}

/// In milliseconds in which many pixels have events, less in calm ones.
pub(super) fn busy(view: &View<'_>) -> Option<Value> {
    let is_busy = busy_milliseconds(view);
    contrast(view, |_, t_us| Some(!is_busy(t_us)))
}

/// Whether the ideal sensor has most events in the millisecond of a time.
pub(super) fn busy_milliseconds(view: &View<'_>) -> impl Fn(i64) -> bool {
    let start_us = view.window.start.0;
    let mut counts = vec![0_u32; (view.window.length().0 / 1_000 + 1) as usize];
    for pixel in 0..view.size().pixels() {
        for is_on in [false, true] {
            for t_us in view.reference_scene.expected.times(pixel, is_on) {
                if let Some(count) = counts.get_mut(((t_us - start_us) / 1_000) as usize) {
                    *count += 1;
                }
            }
        }
    }
    let mut sorted = counts.clone();
    sorted.sort_unstable();
    let limit = sorted[(CALM * (sorted.len() - 1) as f64) as usize];
    move |t_us| counts.get(((t_us - start_us) / 1_000) as usize).is_some_and(|n| *n > limit)
}

/// Events per second of a pixel at rest, in a range of brightness classes.
fn rest_hz(
    view: &View<'_>,
    brightnesses: std::ops::Range<usize>,
    is_counted: impl Fn(&EventFeatures) -> bool,
) -> Option<Value> {
    let seconds: f64 =
        view.reference_scene.classes.quiet_pixel_s()[brightnesses.clone()].iter().sum();
    let is_there = |event: &&EventFeatures| {
        event.cell.is_quiet() && brightnesses.contains(&event.cell.brightness())
    };
    let count = view.events().iter().filter(is_there).filter(|event| is_counted(event)).count();
    // A pixel second is less than any rate is known from.
    (seconds > 1.0).then(|| {
        let Value { value, error } = Value::of_count(count as f64);
        Value::new(value / seconds, error / seconds)
    })
}

/// ON less OFF events of pixels at rest.
pub(super) fn rest_on(view: &View<'_>) -> Option<Value> {
    let of = |is_on| rest_hz(view, 0..Cell::BRIGHTNESSES, move |event| event.is_on == is_on);
    Some(of(true)?.less(of(false)?))
}

/// ON events of pixels at rest, in bright light less in the dark.
pub(super) fn rest_on_in_light(view: &View<'_>) -> Option<Value> {
    Some(rest_hz(view, 3..5, |event| event.is_on)?.less(rest_hz(view, 0..2, |event| event.is_on)?))
}

/// Events of pixels at rest, in the dark less in bright light.
pub(super) fn rest_in_dark(view: &View<'_>) -> Option<Value> {
    Some(rest_hz(view, 0..2, |_| true)?.less(rest_hz(view, 3..5, |_| true)?))
}

/// Pairs of successive events of a pixel at rest with opposite polarities, less those with one.
pub(super) fn alternation(view: &View<'_>) -> Option<Value> {
    /// Longest interval of a pair.
    const NEAR_US: i64 = 100_000;
    let (mut pairs, mut sum) = (0.0_f64, 0.0);
    for event in view.events().iter().filter(|event| event.cell.is_quiet()) {
        if let Some((_, was_on)) = event.before().filter(|(us, _)| *us < NEAR_US) {
            pairs += 1.0;
            sum += if was_on == event.is_on { -1.0 } else { 1.0 };
        }
    }
    Some(Value::new(sum, (pairs + 1.0).sqrt()))
}
