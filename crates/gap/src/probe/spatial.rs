//! Differences between pixels.
//!
//! A fixed pattern shows in both halves of the time, which alternate every 50 ms. So do hot pixels,
//! which chance does not make busiest in both halves.

use crate::probe::interface::StatisticProbe;
use crate::probe::reference;
use crate::probe::residual::{Residuals, correlation};
use crate::{Entry, StatisticBlock, View};

/// Fractions of events of the busiest pixels, silent pixels, and statistics of residuals.
pub(super) static PROBE: StatisticProbe = StatisticProbe { name: "spatial", entries, measure };

/// Length of the alternating parts of the two halves, and the margin that is left out at either
/// end.
const HALF_US: i64 = 50_000;
const APART_US: i64 = 5_000;
const SHARES: [f64; 4] = [0.001, 0.005, 0.01, 0.05];
/// Minimum reference events of a pixel that counts as silent if it has none.
const MIN_SILENT: f32 = 8.0;
/// Distances of pairs of pixels.
const DISTANCES: [usize; 3] = [1, 2, 4];
const RINGS: usize = 5;
const TILES: (usize, usize) = (6, 4);
/// Prior count that shrinks fractions and dispersions of few events towards those of independent
/// events.
const SETTLED: f64 = 50.0;
const TOLERANCE: f64 = 0.02;

/// Part of a time: the first half, the second, or neither (2) close to their boundary, where a late
/// event would fall into the other half and correlate the two.
fn part(since_start_us: i64) -> usize {
    let within_us = since_start_us.rem_euclid(HALF_US);
    if !(APART_US..HALF_US - APART_US).contains(&within_us) {
        return 2;
    }
    (since_start_us.div_euclid(HALF_US) % 2) as usize
}

/// Event counts per pixel in each part of the time.
struct Maps {
    /// Measured counts; part `h` and polarity `p` at `2 h + p`.
    measured: [Vec<f32>; 6],
    /// Counts of the reference, likewise.
    expected: [Vec<f32>; 6],
    /// Measured counts while the pixel is at rest, by part.
    quiet: [Vec<f32>; 3],
}

impl Maps {
    fn from_view(view: &View<'_>) -> Self {
        let plane = || vec![0.0_f32; view.size().pixels()];
        // Parts of time alternate: what is fixed in pixels shows as agreement between them.
        let part = |t_us| part(view.since_start_us(t_us));
        let mut measured = [(); 6].map(|()| plane());
        let mut expected = [(); 6].map(|()| plane());
        let mut quiet = [(); 3].map(|()| plane());
        for event in view.events() {
            let (part, pixel) = (part(event.t_us), event.pixel as usize);
            measured[2 * part + usize::from(event.is_on)][pixel] += 1.0;
            if event.cell.is_quiet() {
                quiet[part][pixel] += 1.0;
            }
        }
        for list in reference::lists(view, view.window) {
            for t_us in list.t_us {
                expected[2 * part(*t_us) + usize::from(list.is_on)][list.pixel] += 1.0;
            }
        }
        Self { measured, expected, quiet }
    }
}

fn sum(first: &[f32], others: &[&[f32]]) -> Vec<f32> {
    let mut sums = first.to_vec();
    for other in others {
        sums.iter_mut().zip(*other).for_each(|(sum, n)| *sum += n);
    }
    sums
}

/// Fractions of the events of `of` in the pixels with most events in `by`.
fn top_shares(by: &[f32], of: &[f32]) -> [f64; 4] {
    let count = |share: f64| ((share * by.len() as f64).round() as usize).max(1);
    let mut busy: Vec<u32> = (0..by.len() as u32).filter(|p| by[*p as usize] > 0.0).collect();
    let order = |a: &u32, b: &u32| by[*b as usize].total_cmp(&by[*a as usize]).then(a.cmp(b));
    let max = count(SHARES[3]);
    if busy.len() > max {
        // Only the top is sorted; an image may have a million pixels.
        busy.select_nth_unstable_by(max, order);
        busy.truncate(max);
    }
    busy.sort_unstable_by(order);
    let all: f64 = of.iter().map(|n| f64::from(*n)).sum();
    SHARES.map(|share| {
        let top = busy.iter().take(count(share)).map(|p| f64::from(of[*p as usize]));
        top.sum::<f64>() / (all + SETTLED)
    })
}

/// Logarithm of the Fano factor (variance over mean) of counts of pixels at rest.
fn log_fano(quiet: &[f32]) -> f64 {
    let all: f64 = quiet.iter().map(|n| f64::from(*n)).sum();
    let mean = all / quiet.len() as f64;
    let squares: f64 = quiet.iter().map(|n| (f64::from(*n) - mean).powi(2)).sum();
    ((squares + SETTLED) / (all + SETTLED)).ln()
}

/// Counts by distance from the centre, and by tile and polarity.
fn rings_and_tiles(view: &View<'_>, [off, on]: &[Vec<f32>; 2], out: &mut Vec<f64>) {
    let (width, height) = (usize::from(view.size().width), usize::from(view.size().height));
    let mut rings = [0.0; RINGS];
    let mut tiles = [0.0; TILES.0 * TILES.1 * 2];
    let off_centre = |i: usize, n: usize| (i as f32 + 0.5 - 0.5 * n as f32).powi(2);
    // Tile and distance of a column are the same in every row: they are computed once.
    let columns: Vec<(usize, f32)> =
        (0..width).map(|x| (x * TILES.0 / width, off_centre(x, width))).collect();
    let corner = 0.25 * (width * width + height * height) as f32;
    let rows = off.chunks_exact(width).zip(on.chunks_exact(width));
    for (y, (off, on)) in rows.enumerate() {
        let (row, up) = (y * TILES.1 / height * TILES.0, off_centre(y, height));
        for ((column, side), (off, on)) in columns.iter().zip(off.iter().zip(on)) {
            let (off, on) = (f64::from(*off), f64::from(*on));
            let ring = ((side + up) / corner).sqrt() * RINGS as f32;
            rings[(ring as usize).min(RINGS - 1)] += off + on;
            tiles[2 * (row + column)] += off;
            tiles[2 * (row + column) + 1] += on;
        }
    }
    out.extend(rings.iter().chain(&tiles));
}

fn entries() -> Vec<Entry> {
    let value = |name: String, tolerance| Entry::value(StatisticBlock::Spatial, name, tolerance);
    let percent = |share: &f64| 100.0 * share;
    let quiet = SHARES.iter().map(|share| {
        let name = format!("share at rest of the {} % busiest in the other half", percent(share));
        value(name, TOLERANCE)
    });
    let all = SHARES
        .iter()
        .map(|share| value(format!("share of the {} % busiest pixels", percent(share)), TOLERANCE));
    let silent = Entry::count(StatisticBlock::Spatial, "silent pixels");
    let others = [
        ("log variance over mean at rest", 0.05),
        ("correlation of residuals of halves, all pixels", TOLERANCE),
        ("correlation of residuals of halves, pixels active in both", TOLERANCE),
        ("variance of residuals of active pixels", 0.01),
        ("correlation of residuals of ON and OFF", TOLERANCE),
        ("log dispersion of rows", 0.1),
        ("log dispersion of columns", 0.1),
    ];
    let others = others.map(|(name, tolerance)| value(name.to_owned(), tolerance));
    let morans =
        DISTANCES.map(|d| value(format!("likeness of residuals {d} pixels apart"), TOLERANCE));
    let count = |name| Entry::count(StatisticBlock::Spatial, name);
    let rings = (0..RINGS).map(|ring| count(format!("events of ring {ring}")));
    let tiles = (0..TILES.0 * TILES.1 * 2)
        .map(|i| count(format!("{} events of tile {}", ["OFF", "ON"][i % 2], i / 2)));
    let shares = quiet.chain(all).chain([silent]);
    shares.chain(others).chain(morans).chain(rings).chain(tiles).collect()
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    let Maps { measured, expected, quiet } = Maps::from_view(view);
    // Chosen in one part of time and counted in another: chance is not chosen twice.
    let forth = top_shares(&quiet[0], &quiet[1]);
    let back = top_shares(&quiet[1], &quiet[0]);
    out.extend(forth.iter().zip(back).map(|(a, b)| 0.5 * (a + b)));

    let halves = |m: &[Vec<f32>; 6]| [sum(&m[0], &[&m[1]]), sum(&m[2], &[&m[3]])];
    let signs = |m: &[Vec<f32>; 6]| [0, 1].map(|p| sum(&m[p], &[&m[2 + p], &m[4 + p]]));
    let (n_half, e_half) = (halves(&measured), halves(&expected));
    let (n_sign, e_sign) = (signs(&measured), signs(&expected));
    let (n, e) = (sum(&n_sign[0], &[&n_sign[1]]), sum(&e_sign[0], &[&e_sign[1]]));
    out.extend(top_shares(&n, &n));
    out.push(n.iter().zip(&e).filter(|(n, e)| **n == 0.0 && **e >= MIN_SILENT).count() as f64);

    out.push(log_fano(&sum(&quiet[0], &[&quiet[1], &quiet[2]])));
    let [first, second] = [0, 1].map(|half| Residuals::from_counts(&n_half[half], &e_half[half]));
    out.push(correlation(&first, &second, |_| true));
    out.push(correlation(&first, &second, |p| e_half[0][p] > 0.0 && e_half[1][p] > 0.0));
    let mut whole = Residuals::from_counts(&n, &e);
    out.push(whole.mean_square(|p| e[p] > 0.0));
    let [off, on] = [0, 1].map(|sign| Residuals::from_counts(&n_sign[sign], &e_sign[sign]));
    out.push(correlation(&off, &on, |p| e_sign[0][p] > 0.0 && e_sign[1][p] > 0.0));

    // Without the mean: a wrong overall rate is no pattern.
    whole.centre();
    let width = usize::from(view.size().width);
    out.extend(whole.line_dispersions(width));
    out.extend(DISTANCES.map(|distance| whole.moran(width, distance)));
    rings_and_tiles(view, &n_sign, out);
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream, Micros, StageNoise};

    use super::*;
    use crate::probe::testing;

    /// Drops a random fraction of the events of a pixel.
    fn thinned(share: impl Fn(Event) -> f32) -> EventStream {
        let noise = StageNoise::new(5, "thin", 0);
        let mut index = 0;
        testing::changed(|event| {
            index += 1;
            (noise.uniform(index, 0) > share(event)).then_some(event)
        })
    }

    fn value(events: &EventStream, name: &str) -> f64 {
        testing::value(&PROBE, events, name)
    }

    #[test]
    fn hot_pixels_raise_the_shares_of_the_busiest() {
        let x = |i: u16| testing::REST_FROM + 10 + (i % 3);
        let hot = (0..600).map(|i| testing::on(1_000 * i64::from(i), x(i), 30));
        let noise = testing::noise(2_000, 1);
        let even = testing::stream(testing::events().iter().chain(noise.clone()));
        let spiked = testing::stream(testing::events().iter().chain(noise).chain(hot));
        let name = "share at rest of the 0.1 % busiest in the other half";
        assert!(value(&even, name) < 0.02, "{}", value(&even, name));
        assert!(value(&spiked, name) > 0.3, "{}", value(&spiked, name));
        let name = "log variance over mean at rest";
        assert!(value(&even, name).abs() < 0.3, "{}", value(&even, name));
        assert!(value(&spiked, name) > 2.0, "{}", value(&spiked, name));
    }

    #[test]
    fn silent_pixels_are_counted_where_the_reference_has_events() {
        let mut counts = std::collections::HashMap::new();
        for event in testing::events().iter().filter(|event| event.y == 40) {
            *counts.entry(event.x).or_insert(0) += 1;
        }
        let spoken = counts.values().filter(|count| **count >= 8).count();
        assert!(spoken > 20);
        let dead = testing::changed(|event| (event.y != 40).then_some(event));
        assert_eq!(value(testing::events(), "silent pixels"), 0.0);
        assert_eq!(value(&dead, "silent pixels"), spoken as f64);
    }

    #[test]
    fn a_fixed_pattern_shows_in_both_halves_and_chance_does_not() {
        let name = "correlation of residuals of halves, pixels active in both";
        let by_chance = value(&thinned(|_| 0.3), name);
        let fixed = value(&thinned(|event| 0.6 * f32::from((event.x + event.y) % 2)), name);
        assert!(by_chance.abs() < 0.1, "{by_chance}");
        assert!(fixed > 0.3, "{fixed}");
        let name = "correlation of residuals of ON and OFF";
        assert!(value(&thinned(|event| 0.6 * f32::from((event.x + event.y) % 2)), name) > 0.3);
    }

    #[test]
    fn late_events_do_not_tie_the_halves_together() {
        let name = "correlation of residuals of halves, pixels active in both";
        let late = testing::changed(|event| Some(Event { t: event.t + Micros(500), ..event }));
        assert!(value(&late, name).abs() < 0.1, "{}", value(&late, name));
    }

    #[test]
    fn a_pattern_of_columns_shows_along_columns_and_not_along_rows() {
        let columns = thinned(|event| 0.6 * f32::from(event.x % 2));
        let along = value(&columns, "log dispersion of columns");
        let across = value(&columns, "log dispersion of rows");
        assert!(along > across + 1.0, "{along} {across}");
    }

    #[test]
    fn neighbours_are_alike_in_a_pattern_of_patches() {
        let patches = thinned(|event| 0.6 * f32::from((event.x / 8 + event.y / 8) % 2));
        let name = "likeness of residuals 1 pixels apart";
        assert!(value(&patches, name) > value(&thinned(|_| 0.3), name) + 0.2);
    }
}
