//! Joints as a network of joints sees them: rays, depths and scores from its maps.

use std::ops::Range;

use evpose_body::JointObservation;
use evpose_pose::EVALUATION_JOINTS;
use glam::Vec2;

use super::joint_grid::JointGrid;

/// Count of joints.
const JOINTS: usize = EVALUATION_JOINTS.len();
/// Half of the sides of the square of cells about a joint whose likelihood is its score: two standard
/// deviations of a heatmap as it is trained.
const SCORE_CELLS: f32 = 2.0;

/// Standard deviation of the window about a peak in which its place and its depth are read, in cells. What is likely
/// elsewhere is another place of the joint, and a mean of both is none.
const WINDOW_CELLS: f32 = 2.0;
/// How far from its middle the window is summed: at four standard deviations it is 3e-4.
const WINDOW_REACH_CELLS: f32 = 4.0 * WINDOW_CELLS;
/// Times that the window is moved to the mean under it. For a Gaussian, each leaves a fifth of the distance.
const WINDOW_MOVES: usize = 3;

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
    for joint in 0..JOINTS {
        let of_joint = joint * cells..(joint + 1) * cells;
        softmax(&heatmaps[of_joint.clone()], &mut likelihood);
        let mut position = peak(&likelihood, columns);
        for _ in 0..WINDOW_MOVES {
            (position, observed.depths[joint]) =
                mean_near(&likelihood, &depth_maps[of_joint.clone()], columns, position);
        }
        observed.rays[joint] = grid.ray(position);
        observed.spread_cells[joint] = spread(&likelihood, columns, position);
        observed.scores[joint] = near(&likelihood, columns, position);
    }
    observed
}

/// The cell about which the likelihood of 3x3 cells is largest.
fn peak(likelihood: &[f32], columns: usize) -> Vec2 {
    // Of three neighbours in a row, then of three rows: six additions a cell, not nine.
    let mut threes = vec![0.0; likelihood.len()];
    for (sums, row) in threes.chunks_exact_mut(columns).zip(likelihood.chunks_exact(columns)) {
        sums.copy_from_slice(row);
        sums[1..].iter_mut().zip(row).for_each(|(sum, left)| *sum += left);
        sums.iter_mut().zip(&row[1..]).for_each(|(sum, right)| *sum += right);
    }
    let rows = likelihood.len() / columns;
    let (mut largest, mut at) = (f32::NEG_INFINITY, Vec2::ZERO);
    let mut sums = vec![0.0; columns];
    for row in 0..rows {
        sums.fill(0.0);
        for near in row.saturating_sub(1)..(row + 2).min(rows) {
            let threes = &threes[near * columns..][..columns];
            sums.iter_mut().zip(threes).for_each(|(sum, three)| *sum += three);
        }
        for (column, sum) in sums.iter().enumerate() {
            if *sum > largest {
                (largest, at) = (*sum, Vec2::new(column as f32, row as f32));
            }
        }
    }
    at
}

/// The mean position and the mean depth, given that the joint is near `middle`.
fn mean_near(likelihood: &[f32], depths: &[f32], columns: usize, middle: Vec2) -> (Vec2, f32) {
    let window =
        |at: usize, middle: f32| (-0.5 * ((at as f32 - middle) / WINDOW_CELLS).powi(2)).exp();
    let across = cells_within(WINDOW_REACH_CELLS, middle.x, columns);
    let along: Vec<f32> = across.clone().map(|column| window(column, middle.x)).collect();
    let (mut sum, mut position, mut depth) = (0.0, Vec2::ZERO, 0.0);
    for row in cells_within(WINDOW_REACH_CELLS, middle.y, likelihood.len() / columns) {
        let down = window(row, middle.y);
        let first = row * columns;
        let cells = first + across.start..first + across.end;
        let inside = likelihood[cells.clone()].iter().zip(&depths[cells]).zip(&along);
        for (column, ((likelihood, of_cell), along)) in across.clone().zip(inside) {
            let weight = likelihood * along * down;
            sum += weight;
            position += weight * Vec2::new(column as f32, row as f32);
            depth += weight * of_cell;
        }
    }
    (position / sum, depth / sum)
}

/// The cells along one side of the map that are not farther from a place than `reach_cells`.
fn cells_within(reach_cells: f32, at: f32, count: usize) -> Range<usize> {
    let first = (at - reach_cells).ceil().max(0.0) as usize;
    first..((at + reach_cells).floor() as usize + 1).min(count)
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

/// How far from a position a likelihood of cells is, in cells: of one axis, the root of the mean square of both. Other
/// peaks count.
fn spread(likelihood: &[f32], columns: usize, position: Vec2) -> f32 {
    let mut sum = 0.0;
    for (row, values) in likelihood.chunks_exact(columns).enumerate() {
        let down = (row as f32 - position.y).powi(2);
        let across = |x: usize| (x as f32 - position.x).powi(2);
        sum += values.iter().enumerate().map(|(x, value)| value * (across(x) + down)).sum::<f32>();
    }
    (0.5 * sum).sqrt()
}

/// The likelihood of the cells about a position.
fn near(likelihood: &[f32], columns: usize, position: Vec2) -> f32 {
    let across = cells_within(SCORE_CELLS, position.x, columns);
    let down = cells_within(SCORE_CELLS, position.y, likelihood.len() / columns);
    down.map(|row| likelihood[row * columns..][across.clone()].iter().sum::<f32>()).sum()
}

#[cfg(test)]
mod tests {
    use evpose_core::SensorSize;

    use crate::hand::HandConfig;

    use super::*;

    #[test]
    fn a_joint_is_at_the_peak_of_its_heatmap_and_a_flat_one_scores_next_to_nothing() {
        let camera = HandConfig::default().simulation.camera();
        let grid = JointGrid::new(&camera, SensorSize { width: 128, height: 96 }, 2.0);
        let ([columns, rows], at) = (grid.cells, Vec2::new(20.3, 11.6));
        let mut heatmap = Vec::new();
        for row in 0..rows {
            let square = |column: usize| Vec2::new(column as f32, row as f32).distance_squared(at);
            heatmap.extend((0..columns).map(|column| -0.5 * square(column)));
        }
        // Less likely than there, but so wide that it holds as much.
        let elsewhere = Vec2::new(7.0, 15.0);
        let wide = |cell: usize| {
            let cell = Vec2::new((cell % columns) as f32, (cell / columns) as f32);
            0.25 * (-0.125 * cell.distance_squared(elsewhere)).exp()
        };
        let two: Vec<f32> =
            heatmap.iter().enumerate().map(|(cell, z)| (z.exp() + wide(cell)).ln()).collect();
        let mut row = [heatmap, two].concat();
        row.resize(JOINTS * columns * rows, 7.0);
        for joint in 0..JOINTS {
            row.extend(std::iter::repeat_n(0.1 * joint as f32, columns * rows));
        }
        row.push(2.0);
        let observed = joint_observation(&row, &grid);
        let off_cells =
            |joint: usize| observed.rays[joint].distance(grid.ray(at)) * grid.focal_cells();
        assert!(off_cells(0) < 0.01 && off_cells(1) < 0.01, "{} {}", off_cells(0), off_cells(1));
        assert!(observed.scores[0] > 0.85 && observed.scores[0] <= 1.0, "{}", observed.scores[0]);
        assert!((observed.scores[1] - 0.45).abs() < 0.03, "{}", observed.scores[1]);
        assert!((observed.spread_cells[0] - 1.0).abs() < 0.02, "{}", observed.spread_cells[0]);
        assert!(observed.spread_cells[1] > 5.0, "{}", observed.spread_cells[1]);
        assert!(observed.spread_cells[5] > 7.0, "{}", observed.spread_cells[5]);
        assert!(observed.scores[5] < 0.04, "{}", observed.scores[5]);
        assert!((observed.depths[7] - 0.7).abs() < 1e-4, "{}", observed.depths[7]);
        assert!((observed.presence - 1.0 / (1.0 + (-2f32).exp())).abs() < 1e-6);
    }
}
