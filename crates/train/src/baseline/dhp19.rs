//! The network of DHP19 alone: a joint as a heatmap, which is a single pixel, blurred.

use burn::tensor::{Int, Tensor};
use evpose_pose::body::BodyPoints;
use glam::Vec2;

/// Half the blur's width for each standard deviation, that of OpenCV for floats.
const REACH_SIGMAS: f32 = 4.0;

/// The heatmaps of joints relative to an input of so many columns and rows, black for those out of view: profiles
/// along rows and along columns, joint by joint.
pub(super) fn profiles(
    points: &BodyPoints,
    [width, height]: [usize; 2],
    sigma_px: f32,
) -> [Vec<f32>; 2] {
    let axis = |length: usize, at: fn(Vec2) -> f32| -> Vec<f32> {
        let of = |point: &Option<Vec2>| match point {
            // The pixel that the joint is in: truncated, as published.
            Some(point) => profile((at(*point) * length as f32) as usize, length, sigma_px),
            None => vec![0.0; length],
        };
        points.iter().flat_map(of).collect()
    };
    [axis(height, |at| at.y), axis(width, |at| at.x)]
}

/// The middles of the pixels at which heatmaps are largest, joint by joint.
pub(super) fn peaks_px(maps: &Tensor<4>) -> Vec<Vec2> {
    let [batch, joints, height, width] = maps.dims();
    // An index has no gradient: detached, it keeps no graph alive.
    let flat = maps.clone().detach().reshape([batch, joints, height * width]);
    let cells: Tensor<3, Int> = flat.argmax(2);
    let cell = |index: i64| {
        let (row, column) = (index / width as i64, index % width as i64);
        Vec2::new(column as f32, row as f32) + 0.5
    };
    cells.into_data().iter::<i64>().map(cell).collect()
}

/// The profile of a blurred pixel along a line of `length` pixels: the heatmap is the product of
/// those along its rows and its columns, and 1 where it is largest.
///
/// # Model
/// A Gaussian that is cut off as OpenCV's `GaussianBlur` does, beyond the ends of the line mirrored
/// about its last pixels (`BORDER_REFLECT_101`), then scaled.
///
/// # Source
/// Calabrese et al.: *DHP19*, CVPRW 2019, and its published notebook on heatmaps.
fn profile(cell: usize, length: usize, sigma_px: f32) -> Vec<f32> {
    // An odd width, rounded as OpenCV does.
    let width = (2.0 * REACH_SIGMAS * sigma_px + 1.0).round_ties_even() as i64 | 1;
    let reach = width / 2;
    let weight = |offset: i64| {
        let sigmas = offset as f64 / f64::from(sigma_px);
        (-0.5 * sigmas * sigmas).exp()
    };
    let blurred = |at: usize| -> f64 {
        (-reach..=reach)
            .filter(|offset| mirrored(at as i64 + offset, length) == cell)
            .map(weight)
            .sum()
    };
    let near = |at: &usize| at.abs_diff(cell) as i64 <= 2 * reach;
    let mut profile = vec![0.0; length];
    (0..length).filter(near).for_each(|at| profile[at] = blurred(at));
    let largest = profile.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    profile.into_iter().map(|value| (value / largest) as f32).collect()
}

/// The pixel of a line that stands for one beyond its ends.
fn mirrored(at: i64, length: usize) -> usize {
    let last = length as i64 - 1;
    if last == 0 {
        return 0;
    }
    let at = at.rem_euclid(2 * last);
    at.min(2 * last - at) as usize
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    /// `heatmaps.json`: a pixel blurred by OpenCV 4 in double precision, its largest value 1; largest
    /// values of rows and of columns, whose product it is.
    #[derive(Deserialize)]
    struct Golden {
        size: [usize; 2],
        cell: [usize; 2],
        sigma: f32,
        rows: Vec<f32>,
        columns: Vec<f32>,
    }

    #[test]
    fn heatmaps_are_those_of_opencv_also_at_borders() {
        let text = include_str!("../../tests/data/heatmaps.json");
        let all: Vec<Golden> = serde_json::from_str(text).unwrap();
        assert_eq!(all.len(), 5);
        for Golden { size: [height, width], cell: [row, column], sigma, rows, columns } in all {
            for (ours, want) in
                [(profile(row, height, sigma), rows), (profile(column, width, sigma), columns)]
            {
                assert_eq!(ours.len(), want.len());
                for (ours, want) in ours.iter().zip(&want) {
                    assert!((ours - want).abs() < 1e-6, "{row} {column}: {ours} {want}");
                }
            }
        }
    }
}
