//! Joints as a network of joints sees them: rays, depths and scores from its maps.

use evpose_body::JointObservation;
use evpose_pose::EVALUATION_JOINTS;
use glam::Vec2;

use super::joint_grid::JointGrid;

/// Count of joints.
const JOINTS: usize = EVALUATION_JOINTS.len();
/// Half of the sides of the square of cells about a joint whose likelihood is its score: two standard
/// deviations of a heatmap as it is trained.
const SCORE_CELLS: f32 = 2.0;

/// Cells by which joints lie further from the wrist than the means of their heatmaps, for each cell that heatmaps are
/// wider than those of joints that are seen. Where a network is not sure, heatmaps have a background in the middle of
/// the hand, and their means make hands too small: on recordings of the simulator that it was not trained on, by a tenth.
/// All joints by one factor, so that fingers keep their angles.
const OUTWARDS: f32 = 0.35;
/// Largest factor: joints that may be anywhere are no hand of any size.
const MAX_LARGER: f32 = 1.4;
const SEEN_SPREAD_CELLS: f32 = JointObservation::SEEN_SPREAD_CELLS;

/// Reads one row of [`JointMaps::into_rows`](evpose_nn::JointMaps::into_rows).
///
/// # Panics
/// If the row is not of the cells of `grid`.
pub fn joint_observation(row: &[f32], grid: &JointGrid) -> JointObservation {
    let [columns, rows] = grid.cells;
    let cells = columns * rows;
    assert_eq!(row.len(), 2 * JOINTS * cells + 1, "a row of another grid");
    let (maps, presence) = row.split_at(2 * JOINTS * cells);
    let (heatmaps, depth_maps) = maps.split_at(JOINTS * cells);
    let mut observed = JointObservation {
        rays: [Vec2::ZERO; JOINTS],
        depths: [0.0; JOINTS],
        spread_cells: [0.0; JOINTS],
        scores: [0.0; JOINTS],
        presence: 1.0 / (1.0 + (-presence[0]).exp()),
    };
    let mut likelihood = vec![0.0; cells];
    let mut positions = [Vec2::ZERO; JOINTS];
    for (joint, position) in positions.iter_mut().enumerate() {
        let of_joint = joint * cells..(joint + 1) * cells;
        softmax(&heatmaps[of_joint.clone()], &mut likelihood);
        *position = mean_position(&likelihood, columns);
        let depths = likelihood.iter().zip(&depth_maps[of_joint]);
        observed.depths[joint] = depths.map(|(likelihood, depth)| likelihood * depth).sum();
        observed.spread_cells[joint] = spread(&likelihood, columns, *position);
        observed.scores[joint] = near(&likelihood, columns, *position);
    }
    let larger = larger(&positions, &observed.spread_cells);
    // The wrist is the first.
    observed.rays = positions.map(|at| grid.ray(positions[0] + larger * (at - positions[0])));
    observed
}

/// The factor by which a hand is larger than the means of its heatmaps.
fn larger(positions: &[Vec2; JOINTS], spread_cells: &[f32; JOINTS]) -> f32 {
    let distance: f32 = positions.iter().map(|at| at.distance(positions[0])).sum();
    let wider: f32 = spread_cells.iter().map(|spread| (spread - SEEN_SPREAD_CELLS).max(0.0)).sum();
    (1.0 + OUTWARDS * wider / distance.max(1e-6)).min(MAX_LARGER)
}

/// The softmax of logits. Without the largest subtracted, exponentials would overflow.
fn softmax(logits: &[f32], out: &mut [f32]) {
    let largest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut sum = 0.0;
    for (out, logit) in out.iter_mut().zip(logits) {
        *out = (logit - largest).exp();
        sum += *out;
    }
    out.iter_mut().for_each(|value| *value /= sum);
}

/// The mean column and row under a likelihood of cells, row by row.
fn mean_position(likelihood: &[f32], columns: usize) -> Vec2 {
    let mut mean = Vec2::ZERO;
    for (row, values) in likelihood.chunks_exact(columns).enumerate() {
        let sum: f32 = values.iter().sum();
        let along: f32 = values.iter().enumerate().map(|(x, value)| x as f32 * value).sum();
        mean += Vec2::new(along, row as f32 * sum);
    }
    mean
}

/// The standard deviation of a position under a likelihood of cells whose mean is `mean`, in cells: of one axis, the root
/// of the mean of both variances.
fn spread(likelihood: &[f32], columns: usize, mean: Vec2) -> f32 {
    let mut sum = 0.0;
    for (row, values) in likelihood.chunks_exact(columns).enumerate() {
        let down = (row as f32 - mean.y).powi(2);
        let across = |x: usize| (x as f32 - mean.x).powi(2);
        sum += values.iter().enumerate().map(|(x, value)| value * (across(x) + down)).sum::<f32>();
    }
    (0.5 * sum).sqrt()
}

/// The likelihood of the cells about a position.
fn near(likelihood: &[f32], columns: usize, position: Vec2) -> f32 {
    let range = |at: f32, count: usize| {
        let first = (at - SCORE_CELLS).ceil().max(0.0) as usize;
        first..((at + SCORE_CELLS).floor() as usize + 1).min(count)
    };
    let across = range(position.x, columns);
    let down = range(position.y, likelihood.len() / columns);
    down.map(|row| likelihood[row * columns..][across.clone()].iter().sum::<f32>()).sum()
}

#[cfg(test)]
mod tests {
    use evpose_core::SensorSize;

    use crate::hand::HandConfig;

    use super::*;

    #[test]
    fn hands_of_wide_heatmaps_are_larger_than_their_means_but_not_by_any_factor() {
        let positions: [Vec2; JOINTS] = std::array::from_fn(|joint| Vec2::new(joint as f32, 3.0));
        assert_eq!(larger(&positions, &[SEEN_SPREAD_CELLS; JOINTS]), 1.0);
        let wide = larger(&positions, &[3.0; JOINTS]);
        // 21 joints that are 2 cells wider, at a distance of 10 in the mean.
        assert!((wide - 1.0 - OUTWARDS * 0.2).abs() < 1e-6, "{wide}");
        assert_eq!(larger(&[Vec2::ONE; JOINTS], &[9.0; JOINTS]), MAX_LARGER);
    }

    #[test]
    fn a_gaussian_is_read_where_it_is_and_a_flat_heatmap_scores_next_to_nothing() {
        let camera = HandConfig::default().simulation.camera();
        let grid = JointGrid::new(&camera, SensorSize { width: 128, height: 96 }, 2.0);
        let ([columns, rows], at) = (grid.cells, Vec2::new(20.3, 11.6));
        let mut heatmap = Vec::new();
        for row in 0..rows {
            let square = |column: usize| Vec2::new(column as f32, row as f32).distance_squared(at);
            heatmap.extend((0..columns).map(|column| -0.5 * square(column)));
        }
        let mut row = heatmap;
        row.resize(JOINTS * columns * rows, 7.0);
        for joint in 0..JOINTS {
            row.extend(std::iter::repeat_n(0.1 * joint as f32, columns * rows));
        }
        row.push(2.0);
        let observed = joint_observation(&row, &grid);
        assert!(observed.rays[0].distance(grid.ray(at)) < 1e-4 / grid.focal_cells());
        assert!(observed.scores[0] > 0.85 && observed.scores[0] <= 1.0, "{}", observed.scores[0]);
        assert!((observed.spread_cells[0] - 1.0).abs() < 0.02, "{}", observed.spread_cells[0]);
        assert!(observed.spread_cells[5] > 7.0, "{}", observed.spread_cells[5]);
        let middle = Vec2::new(columns as f32 - 1.0, rows as f32 - 1.0) / 2.0;
        // From the wrist beyond the middle: all but one may be anywhere.
        let beyond = at + MAX_LARGER * (middle - at);
        assert!(observed.rays[5].distance(grid.ray(beyond)) < 1e-3 / grid.focal_cells());
        let flat = 16.0 / (columns * rows) as f32;
        assert!((observed.scores[5] - flat).abs() < 1e-4, "{}", observed.scores[5]);
        assert!((observed.depths[7] - 0.7).abs() < 1e-4, "{}", observed.depths[7]);
        assert!((observed.presence - 1.0 / (1.0 + (-2f32).exp())).abs() < 1e-6);
    }
}
