//! Ratio of the ON to the OFF threshold, from light that comes back to where it was.
//!
//! # Model
//! The memory of a pixel follows light in steps of `C_on` up and `C_off` down. From one minimum of its light to another,
//! an OFF event before an ON event, and from maximum to maximum, steps up are as high as steps down on average over
//! the image: `C_on N_on = C_off N_off`, and `C_on / C_off = N_off / N_on`. Events before the first and behind the last
//! extremum, such as those of light that only rises, do not count. Background is subtracted: that of a recording at
//! rest, at most that of the quietest twentieth of time.
//!
//! The interval has five parts in quadrature: a bootstrap over tiles of the image, all of what is subtracted, half of what
//! halves of the recording differ by, half a threshold of each pixel and kind of extremum, by which memories differ from
//! one to the next, and what refractory periods hide. Light goes on in a period `P`, by `P / (dt - P)` thresholds
//! where events are `dt` apart, at either polarity, which takes the ratio towards one. No period is longer than the
//! shortest times between events.
//!
//! # Limits
//! Under a lamp, all pixels see one cycle, of which each counts the same whole events: what is left over does not average
//! out. Light whose extrema drift evenly, and events that are lost at one polarity, count as a difference of thresholds.

use std::ops::Range;

use evpose_core::stats::bootstrap::{BootstrapConfig, bootstrap};
use evpose_core::stats::quantile::nearest_rank;
use evpose_core::{Event, Micros};

use super::recording::{CameraRecording, Reading, interval, reach};

/// Columns and rows of tiles, and parts of time.
const TILES: [usize; 2] = [8, 6];
const ALL: usize = TILES[0] * TILES[1];
const PARTS: usize = 20;
/// Minimum events of each polarity that light makes, also in multiples of those at rest.
const MIN_EVENTS: f64 = 300.0;
const MIN_OVER_REST: f64 = 2.0;
/// Largest reach of an interval that says something, relative to the ratio.
const MAX_REACH: f64 = 0.5;
/// Share of times between events that may be shorter than a refractory period, by the jitter of clocks.
const SHORTEST: f64 = 1e-4;
/// Largest change of light in a refractory period, thresholds.
const MAX_HIDDEN: f64 = 10.0;
const BOOTSTRAP: BootstrapConfig = BootstrapConfig { resamples: 1_000, seed: 1 };

/// Events of a pixel until an extremum: their counts, OFF and ON, and the time of the last one.
type Mark = ([u32; 2], Micros);

/// A pixel: events so far, and the first and the last minimum and maximum.
#[derive(Default)]
struct Pixel {
    so_far: Option<(Mark, usize)>,
    extrema: [Option<[Mark; 2]>; 2],
}

/// Between extrema of the pixels of a tile: OFF and ON events, seconds, and count of such stretches.
type Tile = [f64; 4];

impl Pixel {
    fn push(&mut self, t: Micros, polarity: usize) {
        let ((mut counts, last_t), last) = self.so_far.unwrap_or((([0; 2], t), polarity));
        if last != polarity {
            let here = (counts, last_t);
            self.extrema[last].get_or_insert([here; 2])[1] = here;
        }
        counts[polarity] += 1;
        self.so_far = Some(((counts, t), polarity));
    }

    fn add_to(&self, tile: &mut Tile) {
        for [(before, from), (until, to)] in self.extrema.iter().flatten().filter(|[a, b]| a != b) {
            let [off, on] = [0, 1].map(|k| f64::from(until[k] - before[k]));
            let more = [off, on, (*to - *from).as_seconds(), 1.0];
            tile.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
    }
}

/// Tiles of the events in some of two halves of time; hot pixels do not count.
fn tiles(recording: &CameraRecording, halves: Range<f64>) -> [Tile; ALL] {
    let (size, start) = (recording.events.sensor(), recording.events.t()[0]);
    let hot = recording.hot_pixels();
    let mut pixels: Vec<Pixel> = (0..size.pixels()).map(|_| Pixel::default()).collect();
    for event in recording.events.iter().filter(|event| !hot.contains(&(event.x, event.y))) {
        if halves.contains(&((event.t - start).as_seconds() / recording.seconds)) {
            let at = usize::from(event.y) * usize::from(size.width) + usize::from(event.x);
            pixels[at].push(event.t, usize::from(event.polarity.is_on()));
        }
    }
    let mut tiles = [Tile::default(); ALL];
    let [width, height] = [size.width, size.height].map(usize::from);
    for (at, pixel) in pixels.iter().enumerate() {
        let (column, row) = (at % width * TILES[0] / width, at / width * TILES[1] / height);
        pixel.add_to(&mut tiles[row * TILES[0] + column]);
    }
    tiles
}

/// Rates of a pixel in the quietest parts of time, OFF and ON, Hz.
fn quietest_hz(recording: &CameraRecording) -> [f64; 2] {
    let mut counts = [[0.0; 2]; PARTS];
    for event in recording.events.iter() {
        let part = (event.t - recording.events.t()[0]).as_seconds() / recording.seconds;
        counts[(part * PARTS as f64) as usize][usize::from(event.polarity.is_on())] += 1.0;
    }
    let pixel_s = recording.events.sensor().pixels() as f64 * recording.seconds / PARTS as f64;
    [0, 1].map(|k| counts.iter().map(|part| part[k]).fold(f64::INFINITY, f64::min) / pixel_s)
}

/// Mean change of light in a refractory period, at most, in thresholds.
fn hidden(recording: &CameraRecording) -> f64 {
    let size = recording.events.sensor();
    let mut last = vec![None; size.pixels()];
    let before = |event: Event| {
        let at = usize::from(event.y) * usize::from(size.width) + usize::from(event.x);
        let before = last[at].replace(event.t)?;
        Some((event.t - before).0.max(1) as f64)
    };
    let mut intervals: Vec<f64> = recording.events.iter().filter_map(before).collect();
    intervals.sort_unstable_by(f64::total_cmp);
    let period = nearest_rank(&intervals, SHORTEST);
    let change = |us: &f64| (period / (us - period).max(period / MAX_HIDDEN)).min(MAX_HIDDEN);
    intervals.iter().map(change).sum::<f64>() / intervals.len() as f64
}

/// Reads the ratio; `lent` are the OFF and the ON rate of a pixel at rest in another recording, Hz.
pub(super) fn read(recording: &CameraRecording, lent: Option<[f64; 2]>) -> Reading {
    if recording.has_lamp() {
        return recording.unknown("the lamp has one cycle for all pixels");
    }
    let quietest = quietest_hz(recording);
    let rest = lent.map_or(quietest, |hz| [0, 1].map(|k| quietest[k].min(hz[k])));
    let sums = |tiles: &[Tile], drawn: &[usize]| {
        [0, 1, 2, 3].map(|k| drawn.iter().map(|i| tiles[*i][k]).sum::<f64>())
    };
    let lit = |sums: Tile| [0, 1].map(|k| (sums[k] - rest[k] * sums[2]).max(0.0));
    let ratio = |[off, on]: [f64; 2]| off / on.max(1.0);
    let every: Vec<usize> = (0..ALL).collect();
    let whole = tiles(recording, 0.0..1.0);
    let all = sums(&whole, &every);
    let of_light = lit(all);
    if (0..2).any(|k| of_light[k] < MIN_EVENTS.max(MIN_OVER_REST * rest[k] * all[2])) {
        return recording.unknown(
            "light makes few events beside the quietest time: hold the camera still for a second",
        );
    }
    let drawn = bootstrap(ALL, &BOOTSTRAP, |drawn| ratio(lit(sums(&whole, drawn))));
    let value = drawn.estimate;
    let halves = [0.0..0.5, 0.5..1.0].map(|half| lit(sums(&tiles(recording, half), &every)));
    // A half at rest has no ratio.
    let has_both = halves.iter().all(|half| half[0] + half[1] > 0.2 * (of_light[0] + of_light[1]));
    let drift = if has_both { 0.5 * (ratio(halves[0]) - ratio(halves[1])) } else { 0.0 };
    let background = value - ratio([all[0], all[1]]);
    let remainder = 0.5 * all[3] / of_light[0].min(of_light[1]) * value;
    let hidden = (value - 1.0) * hidden(recording);
    let parts = [reach(&drawn), drift, background, remainder, hidden];
    let reach = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    match reach <= MAX_REACH * value {
        true => recording.known(interval(value, reach)),
        false => recording.unknown("light does not come back to where it was, or too few times"),
    }
}
