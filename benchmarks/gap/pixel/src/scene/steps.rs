//! Still steps of grey: the strip every scene has at one side, and tiles of ground.

use super::DARKEST_LN;
use super::shape::{SOFTEST_PX, blend, edge};
use crate::draw::Sequence;
use crate::event::{HEIGHT, WIDTH};

const LEVELS: usize = 8;

/// Eight still patches from .02 to 1 along one side of the image.
#[derive(Debug, Clone)]
pub(super) struct Strip {
    levels: [f64; LEVELS],
    along_x: bool,
    far: bool,
    thickness_px: f64,
}

impl Strip {
    pub(super) fn new(draws: &mut Sequence) -> Self {
        let mut levels = std::array::from_fn(|i| DARKEST_LN * i as f64 / (LEVELS - 1) as f64);
        draws.shuffle(&mut levels);
        let along_x = draws.sign() > 0.0;
        Self { levels, along_x, far: draws.sign() > 0.0, thickness_px: draws.between(12.0, 16.0) }
    }

    /// Cover (0 none, 1 whole) and level at a point.
    pub(super) fn at(&self, x_px: f64, y_px: f64) -> (f64, f64) {
        let (along, across, length, depth) = if self.along_x {
            (x_px, y_px, WIDTH as f64, HEIGHT as f64)
        } else {
            (y_px, x_px, HEIGHT as f64, WIDTH as f64)
        };
        let from_side = if self.far { depth - 1.0 - across } else { across };
        let cover = edge(self.thickness_px - from_side, SOFTEST_PX);
        (
            cover,
            if cover > 0.0 {
                along_steps(&self.levels, (along + 0.5) / length, length)
            } else {
                0.0
            },
        )
    }
}

/// Soft steps through `levels` along a unit interval that is `length_px` long.
pub(super) fn along_steps(levels: &[f64], place: f64, length_px: f64) -> f64 {
    let steps = levels.len() as f64;
    let position = (place * steps).clamp(0.0, steps);
    // The nearest border between two steps.
    let border = position.round();
    let last = levels.len() - 1;
    let right = (border as usize).min(last);
    let left = (border as usize).saturating_sub(1).min(last);
    let share = edge((position - border) * length_px / steps, SOFTEST_PX);
    blend(levels[left], levels[right], share)
}

/// Still tiles over the whole image: `ROWS` rows of `COLUMNS`.
#[derive(Debug, Clone)]
pub(super) struct Tiles<const ROWS: usize, const COLUMNS: usize> {
    levels: [[f64; COLUMNS]; ROWS],
}

impl<const ROWS: usize, const COLUMNS: usize> Tiles<ROWS, COLUMNS> {
    pub(super) fn new(draws: &mut Sequence, low_ln: f64, high_ln: f64) -> Self {
        let levels =
            std::array::from_fn(|_| std::array::from_fn(|_| draws.between(low_ln, high_ln)));
        Self { levels }
    }

    pub(super) fn at(&self, x_px: f64, y_px: f64) -> f64 {
        let height = HEIGHT as f64;
        let position = ((y_px + 0.5) / height * ROWS as f64).clamp(0.0, ROWS as f64);
        let border = position.round();
        let above = (border as usize).saturating_sub(1).min(ROWS - 1);
        let below = (border as usize).min(ROWS - 1);
        let share = edge((position - border) * height / ROWS as f64, SOFTEST_PX);
        let place = (x_px + 0.5) / WIDTH as f64;
        let row = |r: usize| along_steps(&self.levels[r], place, WIDTH as f64);
        // Away from a border one row is enough.
        if share <= 0.0 {
            row(above)
        } else if share >= 1.0 {
            row(below)
        } else {
            blend(row(above), row(below), share)
        }
    }
}
