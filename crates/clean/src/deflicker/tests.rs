//! The rule in closed form, and against a computed LNES.

use proptest::prelude::*;

use super::*;
use crate::laws::{events, stream};

const SENSOR: SensorSize = SensorSize { width: 6, height: 5 };

fn on(ms: i64, x: u16, y: u16) -> Event {
    Event { t: Micros(ms * 1_000), x, y, polarity: Polarity::On }
}

fn filtered(options: DeflickerOptions, given: &[Event]) -> Vec<Event> {
    let mut deflicker = Deflicker::new(SENSOR, options);
    let mut events = stream(SENSOR, given);
    deflicker.clean(&mut events);
    deflicker.finish(&mut events);
    events.iter().collect()
}

#[test]
fn of_a_millisecond_that_flickers_only_pixels_with_company_are_kept() {
    let lone = on(5, 1, 1);
    let corner = [on(5, 3, 3), on(5, 4, 3), on(5, 4, 4)];
    let mut given = vec![on(0, 0, 0), lone];
    given.extend(corner);
    // (3, 3) has a neighbour beside it and none above or below, (4, 4) none beside it.
    assert_eq!(filtered(DeflickerOptions::default(), &given), [on(5, 4, 3)]);
}

#[test]
fn and_asks_for_both_neighbours_and_or_for_one() {
    // 1, 2 and 2 events: the middle one exceeds the one before it only, the others none.
    let given = [on(0, 5, 4), on(1, 3, 2), on(1, 1, 1), on(2, 3, 1), on(2, 1, 3)];
    let options = DeflickerOptions { bins: 3, ..DeflickerOptions::default() };
    assert_eq!(filtered(options, &given), [given[0], given[3], given[4]]);
    let and = DeflickerOptions { rule: Rule::And, ..options };
    assert_eq!(filtered(and, &given), given);
}

#[test]
fn a_quiet_second_polarity_does_not_flicker_and_its_events_go_where_the_first_does() {
    let off = |ms, x, y| Event { polarity: Polarity::Off, ..on(ms, x, y) };
    let given = [off(0, 5, 4), off(3, 1, 1)];
    assert_eq!(filtered(DeflickerOptions::default(), &given), given);
    let counted = DeflickerOptions { counted: Polarity::Off, ..DeflickerOptions::default() };
    assert_eq!(filtered(counted, &given), []);
}

#[test]
fn hours_of_silence_are_no_obstacle() {
    let far = Event { t: Micros(i64::MAX), ..on(0, 2, 2) };
    let given = [Event { t: Micros(i64::MIN), ..far }, on(0, 2, 2), far];
    let options = DeflickerOptions { bins: 1, ..DeflickerOptions::default() };
    assert_eq!(filtered(options, &given), given);
}

/// Openings with a footprint of two, as SciPy has them: erosion to the left, dilation to the right,
/// each with its own border reflected.
fn opened(values: &[f32]) -> Vec<f32> {
    let last = values.len() - 1;
    let eroded: Vec<f32> = (0..=last).map(|i| values[i].min(values[i.saturating_sub(1)])).collect();
    (0..=last).map(|i| eroded[i].max(eroded[(i + 1).min(last)])).collect()
}

#[test]
fn the_opening_is_that_of_scipy() {
    // scipy 1.17.1: grey_opening(x, size=(1, 2)) of one row.
    let row = [9.0, 4.0, 6.0, 8.0, 0.0, 1.0, 7.0, 8.0, 2.0, 2.0, 7.0, 9.0];
    let wanted = [9.0, 4.0, 6.0, 6.0, 0.0, 1.0, 7.0, 7.0, 2.0, 2.0, 7.0, 7.0];
    assert_eq!(opened(&row), wanted);
}

/// The published recipe, step by step, with a computed LNES.
fn by_lnes(given: &[Event], start: i64, bins: usize, rule: Rule) -> Vec<Event> {
    let (width, height) = (usize::from(SENSOR.width), usize::from(SENSOR.height));
    let bin_of = |event: &Event| ((event.t.0 - start) / 1_000) as usize;
    let mut masks = Vec::new();
    for polarity in [Polarity::Off, Polarity::On] {
        let mut lnes = vec![0_f32; SENSOR.pixels()];
        for event in given.iter().filter(|event| event.polarity == polarity) {
            let place = usize::from(event.y) * width + usize::from(event.x);
            lnes[place] = bin_of(event) as f32 / bins as f32;
        }
        let across: Vec<f32> = lnes.chunks_exact(width).flat_map(opened).collect();
        let mut down = vec![0.0; lnes.len()];
        for x in 0..width {
            let column: Vec<f32> = (0..height).map(|y| lnes[y * width + x]).collect();
            for (y, value) in opened(&column).into_iter().enumerate() {
                down[y * width + x] = value;
            }
        }
        masks.push(across.iter().zip(&down).map(|(a, d)| a.min(*d)).collect::<Vec<f32>>());
    }
    let count = |bin: usize| {
        given.iter().filter(|e| bin_of(e) == bin && e.polarity == Polarity::On).count()
    };
    let is_kept = |event: &&Event| {
        let bin = bin_of(event);
        let before = bin > 0 && count(bin) > count(bin - 1);
        let after = bin + 1 < bins && count(bin) > count(bin + 1);
        let flickers = if rule == Rule::Or { before || after } else { before && after };
        let place = usize::from(event.y) * width + usize::from(event.x);
        !flickers || masks[event.polarity as usize][place] > 0.0
    };
    given.iter().filter(is_kept).copied().collect()
}

proptest! {
    #[test]
    fn counting_neighbours_is_opening_the_lnes(
        given in events(SENSOR, 40_000), bins in 1_usize..12, is_or in any::<bool>(),
    ) {
        let rule = if is_or { Rule::Or } else { Rule::And };
        let options = DeflickerOptions { bins: bins as u32, rule, counted: Polarity::On };
        let length_us = 1_000 * bins as i64;
        let start = given.first().map_or(0, |event| event.t.0);
        let windows = given.chunk_by(|a, b| {
            (a.t.0 - start) / length_us == (b.t.0 - start) / length_us
        });
        let wanted: Vec<Event> = windows
            .flat_map(|window| {
                let from = start + (window[0].t.0 - start) / length_us * length_us;
                by_lnes(window, from, bins, rule)
            })
            .collect();
        prop_assert_eq!(filtered(options, &given), wanted);
    }
}
