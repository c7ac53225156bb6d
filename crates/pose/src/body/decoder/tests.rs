//! Joints as the published arithmetic gives them, and what a reader of it could get wrong.

use super::*;

/// `x0, y0, x1, …` relative to the image, both -1 for joints that were not detected: the published mode
/// `output`.
fn positions(joints: &[BodyJoint]) -> Vec<f32> {
    joints.iter().flat_map(|joint| joint.position.map_or([-1.0; 2], Vec2::into)).collect()
}

const SIDE: usize = 48;
const JOINTS: usize = 13;
const CELLS: usize = SIDE * SIDE;

/// The fraction of `43758.5453 sin(12.9898 i + 78.233 stream)`.
fn hashed(count: usize, stream: usize) -> impl Iterator<Item = f64> {
    let value = move |i: usize| (12.9898 * i as f64 + 78.233 * stream as f64).sin() * 43758.5453;
    (0..count).map(move |i| value(i) - value(i).floor())
}

/// Maps of noise: joint 3 is below the threshold everywhere and joint 7 is a plane.
fn noise() -> BodyMaps<Vec<f32>> {
    let mut heatmaps: Vec<f32> = hashed(JOINTS * CELLS, 1).map(|u| u.powi(8) as f32).collect();
    heatmaps[3 * CELLS..4 * CELLS].iter_mut().for_each(|value| *value *= 0.05);
    heatmaps[7 * CELLS..8 * CELLS].fill(0.5);
    let mut centers: Vec<f32> = hashed(CELLS, 2).map(|u| u as f32).collect();
    centers.chunks_mut(SIDE).for_each(|row| row[12..].iter_mut().for_each(|value| *value *= 0.05));
    let regs = hashed(2 * JOINTS * CELLS, 3).map(|u| (60.0 * (u - 0.5)) as f32).collect();
    let offsets = hashed(2 * JOINTS * CELLS, 4).map(|u| u as f32).collect();
    BodyMaps { heatmaps, centers, regs, offsets }
}

fn slices(maps: &BodyMaps<Vec<f32>>) -> BodyMaps<&[f32]> {
    BodyMaps {
        heatmaps: &maps.heatmaps,
        centers: &maps.centers,
        regs: &maps.regs,
        offsets: &maps.offsets,
    }
}

fn assert_close(ours: &[f32], theirs: &[f32]) {
    assert_eq!(ours.len(), theirs.len());
    for (index, (a, b)) in ours.iter().zip(theirs).enumerate() {
        assert!((a - b).abs() < 2e-6, "{index}: {a} {b}");
    }
}

// Made with NumPy from the same closed forms, step by step as published (`argmax`, `astype(float32)`
// for the weight of the middle, `int` of regressions plus a half), rounded to six digits.

/// `x, y, score` of each joint at a threshold of 0.1.
#[rustfmt::skip]
const AT_0_1: [f32; 39] = [
    0.165678, 0.66633, 0.843143, 0.646944, 0.192232, 0.614819, 0.304689, 0.330736,
    0.713498, -1.0, -1.0, 0.0, 0.017484, 0.441185, 0.757358, 0.777813, 0.343562,
    0.891893, 0.289495, 0.015942, 0.964455, 0.002283, 0.447207, 0.5, 0.021464, 0.71648,
    0.910942, 0.63853, 0.01368, 0.961698, 0.145114, 0.706793, 0.976021, 0.45985,
    0.020429, 0.816926, 0.036216, 0.895726, 0.913167,
];

/// The same at 0.6, which joint 7 does not reach.
#[rustfmt::skip]
const AT_0_6: [f32; 39] = [
    0.165678, 0.66633, 0.843143, 0.646944, 0.192232, 0.614819, 0.304689, 0.330736,
    0.713498, -1.0, -1.0, 0.0, 0.017484, 0.441185, 0.757358, 0.777813, 0.343562,
    0.891893, 0.289495, 0.015942, 0.964455, -1.0, -1.0, 0.0, 0.021464, 0.71648,
    0.910942, 0.63853, 0.01368, 0.961698, 0.145114, 0.706793, 0.976021, 0.45985,
    0.020429, 0.816926, 0.036216, 0.895726, 0.913167,
];

#[test]
fn joints_are_those_of_the_published_arithmetic() {
    let maps = noise();
    for (threshold, expected) in [(DEFAULT_THRESHOLD, &AT_0_1), (0.6, &AT_0_6)] {
        let joints = BodyDecoder::new([SIDE; 2], threshold).as_published().decode(&slices(&maps));
        let (rows, _) = expected.as_chunks::<3>();
        let (xy, scores): (Vec<_>, Vec<_>) = rows.iter().map(|[x, y, s]| ([*x, *y], *s)).unzip();
        assert_close(&positions(&joints), xy.as_flattened());
        assert_close(&joints.iter().map(|joint| joint.score).collect::<Vec<_>>(), &scores);
        assert_eq!(joints[3], BodyJoint { position: None, score: 0.0 });
    }
}

/// One joint on 4x6 cells with its middle at column 3 and row 2, and regressions of `x` and `y`.
fn small(heatmap: [f32; 24], [x, y]: [f32; 2]) -> BodyMaps<Vec<f32>> {
    let mut centers = vec![0.0; 24];
    centers[2 * 6 + 3] = 1.0;
    let regs = [[x; 24], [y; 24]].concat();
    BodyMaps { heatmaps: heatmap.to_vec(), centers, regs, offsets: vec![0.0; 48] }
}

fn cell_by(decoder: &BodyDecoder, maps: &BodyMaps<Vec<f32>>) -> [f32; 2] {
    let joints = decoder.decode(&slices(maps));
    (joints[0].position.unwrap() * Vec2::new(6.0, 4.0)).round().into()
}

fn cell(maps: &BodyMaps<Vec<f32>>) -> [f32; 2] {
    cell_by(&BodyDecoder::new([4, 6], DEFAULT_THRESHOLD), maps)
}

#[test]
fn the_published_regressions_are_rounded_towards_zero() {
    // On a plane, a joint is where the regression points.
    let plane = [0.5; 24];
    let published = BodyDecoder::new([4, 6], DEFAULT_THRESHOLD).as_published();
    let cell = |regression: [f32; 2]| cell_by(&published, &small(plane, regression));
    assert_eq!(cell([-1.4, -0.6]), [3.0, 2.0], "not down to 2");
    assert_eq!(cell([-1.6, 0.4]), [2.0, 2.0]);
    assert_eq!(cell([1.5, 0.5]), [5.0, 3.0], "halves up");
    assert_eq!(cell([-9.0, 99.0]), [0.0, 3.0], "the nearest cell of those outside");
}

#[test]
fn regressions_point_as_far_to_the_left_and_up_as_to_the_right_and_down() {
    let plane = [0.5; 24];
    assert_eq!(cell(&small(plane, [-1.4, -0.6])), [2.0, 1.0]);
    assert_eq!(cell(&small(plane, [1.4, 0.6])), [4.0, 3.0]);
    assert_eq!(cell(&small(plane, [-9.0, 99.0])), [0.0, 3.0], "the nearest cell of those outside");
    // The heatmap decides between cells that are almost as near.
    let mut heatmap = plane;
    heatmap[2 * 6 + 1] = 0.55;
    assert_eq!(cell(&small(heatmap, [-1.48, 0.0])), [1.0, 2.0]);
}

#[test]
fn the_softer_the_weights_are_the_more_heatmaps_count() {
    let mut heatmap = [0.1; 24];
    (heatmap[2 * 6 + 3], heatmap[2 * 6 + 5]) = (0.5, 0.8);
    let maps = small(heatmap, [0.0, 0.0]);
    // 0.5 / s against 0.8 / (2 + s): equal at s = 10/3.
    let decoder = BodyDecoder::new([4, 6], DEFAULT_THRESHOLD);
    assert_eq!(cell_by(&decoder, &maps), [3.0, 2.0]);
    assert_eq!(cell_by(&decoder.clone().softened_by(3.3), &maps), [3.0, 2.0]);
    assert_eq!(cell_by(&decoder.softened_by(3.4), &maps), [5.0, 2.0]);
    // So does the map of centres beside its middle, column 3 of row 2.
    let mut centers = [0.0; 24];
    (centers[2 * 6 + 3], centers[2 * 6 + 5]) = (0.5, 0.8);
    let decoder = BodyDecoder::new([4, 6], DEFAULT_THRESHOLD);
    assert_eq!(decoder.center_cell(&centers), 2 * 6 + 3);
    assert_eq!(decoder.softened_by(3.4).center_cell(&centers), 2 * 6 + 5);
}

#[test]
fn the_first_of_equals_counts_row_by_row() {
    let mut heatmap = [0.0; 24];
    for (x, y) in [(4, 2), (3, 3), (2, 2), (3, 1)] {
        heatmap[y * 6 + x] = 0.7;
    }
    assert_eq!(cell(&small(heatmap, [0.0, 0.0])), [3.0, 1.0]);
}

#[test]
fn what_is_on_no_heatmap_is_missing() {
    let decoder = BodyDecoder::new([4, 6], DEFAULT_THRESHOLD);
    let joints = decoder.decode(&slices(&small([0.09; 24], [0.0; 2])));
    assert_eq!(positions(&joints), [-1.0, -1.0]);
    assert_eq!(joints[0].score, 0.0);
}
