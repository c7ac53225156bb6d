//! Peaks of heatmaps: candidates for parts.

use glam::Vec2;

use super::upsampling::FineMap;

/// Pixels about a peak along either side, over which it is refined.
const REACH: usize = 3;

/// A candidate for a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Peak {
    /// Column and row, in pixels of the upsampled map; 0 is the middle of the first pixel.
    pub(super) at_px: Vec2,
    /// Value of the heatmap.
    pub(super) score: f32,
}

/// The local maxima of a map above `threshold`, row by row, each at the mean position of the values
/// above 0 about it, weighted by them. Of equal neighbours the first counts.
///
/// # Source
/// Non-maximum suppression of OpenPose (`nmsBase.cpp`), for which equal neighbours are no maximum:
/// a body in the middle between two pixels would be lost.
pub(super) fn peaks(map: &FineMap, threshold: f32) -> Vec<Peak> {
    let mut peaks = Vec::new();
    // Pixels of the border lack neighbours, so that none of them is a maximum.
    for y in 1..map.rows.saturating_sub(1) {
        for x in 1..map.columns.saturating_sub(1) {
            let score = map.at(x, y);
            if score > threshold && is_maximum(map, x, y) {
                peaks.push(Peak { at_px: refined(map, x, y), score });
            }
        }
    }
    peaks
}

fn is_maximum(map: &FineMap, x: usize, y: usize) -> bool {
    let score = map.at(x, y);
    let before = [(x - 1, y - 1), (x, y - 1), (x + 1, y - 1), (x - 1, y)];
    let behind = [(x + 1, y), (x - 1, y + 1), (x, y + 1), (x + 1, y + 1)];
    before.iter().all(|&(x, y)| score > map.at(x, y))
        && behind.iter().all(|&(x, y)| score >= map.at(x, y))
}

fn refined(map: &FineMap, x: usize, y: usize) -> Vec2 {
    let (mut sum, mut at_px) = (0.0, Vec2::ZERO);
    for y in y.saturating_sub(REACH)..=(y + REACH).min(map.rows - 1) {
        for x in x.saturating_sub(REACH)..=(x + REACH).min(map.columns - 1) {
            // Bicubic interpolation undershoots, and a negative weight would push the peak away.
            let weight = map.at(x, y).max(0.0);
            sum += weight;
            at_px += weight * Vec2::new(x as f32, y as f32);
        }
    }
    at_px / sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A round hill about a position.
    fn hill(at: Vec2) -> FineMap {
        let value = |k: usize| {
            let d = Vec2::new((k % 20) as f32, (k / 20) as f32).distance(at);
            (-0.5 * (d / 4.0).powi(2)).exp()
        };
        FineMap { values: (0..300).map(value).collect(), rows: 15, columns: 20 }
    }

    /// A value at one pixel of a map of zeros, and another at an offset from it.
    fn pair(value: f32, offset: (isize, isize)) -> FineMap {
        let mut values = vec![0.0; 300];
        values[7 * 20 + 9] = 1.0;
        values[(7 + offset.1) as usize * 20 + (9 + offset.0) as usize] = value;
        FineMap { values, rows: 15, columns: 20 }
    }

    #[test]
    fn a_maximum_is_above_its_eight_neighbours_and_those_behind_may_be_equal() {
        for (dx, dy) in (-2_isize..=2).flat_map(|dy| (-2_isize..=2).map(move |dx| (dx, dy))) {
            let is_neighbour = (dx, dy) != (0, 0) && dx.abs().max(dy.abs()) == 1;
            let is_behind = (dy, dx) > (0, 0);
            for (value, is_peak) in
                [(0.9, true), (1.0, !is_neighbour || is_behind), (1.1, !is_neighbour)]
            {
                if (dx, dy) != (0, 0) {
                    assert_eq!(is_maximum(&pair(value, (dx, dy)), 9, 7), is_peak, "{dx} {dy}");
                }
            }
        }
    }

    #[test]
    fn a_peak_is_refined_over_three_pixels_to_all_sides() {
        for (dx, dy) in (-5_isize..=5).flat_map(|dy| (-5_isize..=5).map(move |dx| (dx, dy))) {
            let is_near = dx.abs().max(dy.abs()) <= 3 && (dx, dy) != (0, 0);
            let by = if is_near { Vec2::new(dx as f32, dy as f32) / 4.0 } else { Vec2::ZERO };
            let mut map = pair(1.0 / 3.0, (dx, dy));
            map.values[7 * 20 + 9] = 1.0;
            assert!(refined(&map, 9, 7).distance(Vec2::new(9.0, 7.0) + by) < 1e-5, "{dx} {dy}");
            let negative = pair(-1.0, (dx.max(1), dy));
            assert_eq!(refined(&negative, 9, 7), Vec2::new(9.0, 7.0));
        }
    }

    #[test]
    fn a_peak_at_the_border_is_refined_by_what_is_in_the_map() {
        let map = FineMap { rows: 4, columns: 5, values: vec![1.0; 20] };
        assert_eq!(refined(&map, 4, 3), Vec2::new(2.5, 1.5));
    }

    #[test]
    fn a_hill_has_one_peak_also_between_two_pixels() {
        for at in [Vec2::new(9.0, 7.0), Vec2::new(9.5, 7.0), Vec2::new(9.5, 7.5)] {
            let found = peaks(&hill(at), 0.05);
            assert_eq!(found.len(), 1, "{at}: {found:?}");
            assert!(found[0].at_px.distance(at) < 0.6, "{at}: {found:?}");
        }
        assert!(peaks(&hill(Vec2::new(9.0, 7.0)), 1.5).is_empty());
    }
}
