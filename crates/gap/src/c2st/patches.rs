//! Patches of measured and simulated events from the same places and times.

use evpose_core::{EventStream, StageNoise, TimeWindow};

use super::features::{Features, LENGTH_US, Local, SIDE_PX, patch_features};

/// Minimum events of a patch, on average over measured and simulated.
const MIN_EVENTS: usize = 6;
const MAX_PAIRS: usize = 1_500;
/// Cross-validation folds.
pub(super) const FOLDS: usize = 5;
/// Minimum tiles whose labels are permuted as a whole; fewer allow too few permutations.
const MIN_TILES: usize = 8;

pub(super) struct Pair {
    pub(super) features: [Features; 2],
    /// Group of pairs whose labels are swapped together.
    pub(super) group: usize,
    /// Cross-validation fold.
    pub(super) fold: usize,
}

struct Sorted {
    starts: Vec<usize>,
    events: Vec<Local>,
}

struct Grid {
    columns: usize,
    tiles: usize,
    patches: usize,
}

impl Sorted {
    fn from_events(events: &EventStream, window: TimeWindow, grid: &Grid) -> Self {
        let range = events.range(window);
        let patch = |i: usize| {
            let block = ((events.t()[i].0 - window.start.0) / LENGTH_US) as usize;
            let (x, y) = (usize::from(events.x()[i]), usize::from(events.y()[i]));
            let tile = y / SIDE_PX * grid.columns + x / SIDE_PX;
            block * grid.tiles + tile
        };
        // An incomplete last patch of the window is left out.
        let inside = || range.clone().filter(|i| patch(*i) < grid.patches);
        // A counting sort: a patch is a slice of one array.
        let mut starts = vec![0; grid.patches + 1];
        for i in inside() {
            starts[patch(i) + 1] += 1;
        }
        for i in 0..grid.patches {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut sorted = vec![Local::default(); starts[grid.patches]];
        for i in inside() {
            let slot = &mut next[patch(i)];
            sorted[*slot] = Local {
                t_us: (events.t()[i].0 - window.start.0) % LENGTH_US,
                stamp_us: events.t()[i].0,
                x: usize::from(events.x()[i]) % SIDE_PX,
                y: usize::from(events.y()[i]) % SIDE_PX,
                is_on: events.polarity()[i].is_on(),
            };
            *slot += 1;
        }
        Self { starts, events: sorted }
    }

    fn patch(&self, patch: usize) -> &[Local] {
        &self.events[self.starts[patch]..self.starts[patch + 1]]
    }
}

/// Draws pairs of patches with enough events, at most 1,500.
pub(super) fn pairs(
    measured: &EventStream,
    simulated: &[EventStream],
    window: TimeWindow,
    seed: u64,
) -> Vec<Pair> {
    if simulated.is_empty() {
        return Vec::new();
    }
    let size = measured.sensor();
    let columns = usize::from(size.width).div_ceil(SIDE_PX);
    let tiles = columns * usize::from(size.height).div_ceil(SIDE_PX);
    let blocks = (window.length().0 / LENGTH_US).max(0) as usize;
    let grid = Grid { columns, tiles, patches: blocks * tiles };
    let measured = Sorted::from_events(measured, window, &grid);
    let simulated: Vec<Sorted> =
        simulated.iter().map(|events| Sorted::from_events(events, window, &grid)).collect();
    // One stream per tile, so that properties of its pixels are the same over time.
    let other = |patch: usize| simulated[patch % tiles % simulated.len()].patch(patch);
    let has_events =
        |patch: &usize| measured.patch(*patch).len() + other(*patch).len() >= 2 * MIN_EVENTS;
    let mut chosen: Vec<usize> = (0..grid.patches).filter(has_events).collect();
    // A random order, so that those that are kept are spread over image and time.
    let noise = StageNoise::new(seed, "patches", 0);
    chosen.sort_by_key(|patch| (noise.bits(*patch, 0), *patch));
    chosen.truncate(MAX_PAIRS);
    chosen.sort_unstable();
    let pair = |patch: usize| {
        let (tile, block) = (patch % tiles, patch / tiles);
        let part = block * FOLDS / blocks;
        // Few tiles are too few groups to be permuted: parts of time count as well.
        let group = if tiles < MIN_TILES { tile * FOLDS + part } else { tile };
        Pair {
            features: [patch_features(measured.patch(patch)), patch_features(other(patch))],
            group,
            fold: (tile + part) % FOLDS,
        }
    };
    chosen.into_iter().map(pair).collect()
}
