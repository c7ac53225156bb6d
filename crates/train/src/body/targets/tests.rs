//! Targets as another program makes them, and as a decoder reads them.

use evpose_pose::body::Visibility;
use proptest::prelude::*;

use super::*;
use crate::body::BodyBatch;

const JOINTS: usize = 13;

/// The fraction of `43758.5453 sin(12.9898 i + 78.233 stream)`.
fn hashed(count: usize, stream: usize) -> Vec<f64> {
    let value = |i: usize| (12.9898 * i as f64 + 78.233 * stream as f64).sin() * 43758.5453;
    (0..count).map(|i| value(i) - value(i).floor()).collect()
}

fn person(stream: usize, scale: f32, from: f32, center: [f32; 2]) -> BodyLabel {
    let values: Vec<f32> = hashed(3 * JOINTS, stream).into_iter().map(|u| u as f32).collect();
    let (rows, _) = values.as_chunks::<3>();
    let keypoint = |&[x, y, visibility]: &[f32; 3]| Keypoint {
        position: Vec2::new(from + scale * x, from + scale * y),
        visibility: match visibility {
            v if v < 0.2 => Visibility::Unlabelled,
            v if v > 0.6 => Visibility::Visible,
            _ => Visibility::Hidden,
        },
    };
    let keypoints = rows.iter().map(keypoint).collect();
    BodyLabel { keypoints, center: center.into(), ..BodyLabel::default() }
}

fn owned(joints: usize, side: usize) -> BodyMaps<Vec<f32>> {
    let map = |channels: usize| vec![f32::NAN; channels * side * side];
    BodyMaps::from_array([joints, 1, 2 * joints, 2 * joints].map(map))
}

fn maps(grid: &BodyGrid, label: &BodyLabel) -> BodyMaps<Vec<f32>> {
    let mut maps = owned(label.keypoints.len(), grid.side());
    let BodyMaps { heatmaps, centers, regs, offsets } = &mut maps;
    grid.write_maps(label, &mut BodyMaps { heatmaps, centers, regs, offsets });
    maps
}

/// The targets of a label: cells, values, and the two maps.
#[derive(Debug, Clone, Default, PartialEq)]
struct Written {
    heatmaps: Vec<f32>,
    centers: Vec<f32>,
    center_cell: i32,
    joint_cells: Vec<i32>,
    regs: Vec<[f32; 2]>,
    offsets: Vec<[f32; 2]>,
    known: Vec<f32>,
}

fn written(grid: &BodyGrid, label: &BodyLabel) -> Written {
    let mut batch = BodyBatch::new(3, label.keypoints.len(), grid.side());
    let mut samples = batch.samples_mut();
    grid.write(label, &mut samples[1]);
    let of = &samples[1];
    Written {
        heatmaps: of.heatmaps.to_vec(),
        centers: of.centers.to_vec(),
        center_cell: *of.center_cell,
        joint_cells: of.joint_cells.to_vec(),
        regs: of.regs.to_vec(),
        offsets: of.offsets.to_vec(),
        known: of.known.to_vec(),
    }
}

/// A case and what NumPy makes of it.
struct Golden {
    side: usize,
    label: BodyLabel,
    center_cell: i32,
    /// Each map, multiplied by hashed values (streams 40 to 43) and summed.
    sums: [f64; 4],
}

/// Made with NumPy 2.4 from the same closed forms: loops over joints, blobs and squares as the
/// published rules have them, in f64, rounded to f32; the cell with `argmax` of the map of centres
/// times `1 / (d + 1.8)`. The fifth case has other persons, the sixth joints and a middle outside
/// of the image.
fn goldens() -> Vec<Golden> {
    let golden = |side, label, center_cell, sums| Golden { side, label, center_cell, sums };
    let mut crowd = person(5, 0.4, 0.1, [0.2, 0.2]);
    crowd.other_centers = vec![Vec2::new(0.55, 0.5)];
    let other = person(9, 0.4, 0.4, [0.0; 2]);
    crowd.other_keypoints = other.keypoints.iter().map(|joint| vec![joint.position]).collect();
    vec![
        golden(
            48,
            person(1, 0.3, 0.2, [0.31, 0.28]),
            638,
            [47.00049, 7.457696, 851.8251, 3.620819],
        ),
        golden(
            48,
            person(2, 0.5, 0.35, [0.6, 0.7]),
            1612,
            [79.87107, 11.34931, -409.2706, 5.830893],
        ),
        golden(
            48,
            person(3, 0.9, 0.05, [0.5, 0.52]),
            1176,
            [100.352, 13.34759, -1066.145, 3.947168],
        ),
        golden(
            32,
            person(4, 0.8, 0.1, [0.45, 0.95]),
            974,
            [119.7359, 10.08881, -1661.695, 4.425293],
        ),
        golden(48, crowd, 1178, [97.61679, 14.81494, 2470.406, 3.71655]),
        golden(
            48,
            person(6, 1.25, -0.1, [-0.1, 0.4]),
            912,
            [68.50609, 8.631726, 2373.509, 2.644286],
        ),
    ]
}

#[test]
fn maps_of_parity_are_those_of_another_program() {
    for (number, golden) in goldens().into_iter().enumerate() {
        let grid = BodyGrid::new(golden.side, true);
        let maps = maps(&grid, &golden.label).into_array();
        for (index, (map, expected)) in maps.iter().zip(golden.sums).enumerate() {
            let weights = hashed(map.len(), 40 + index);
            let sum: f64 = map.iter().zip(weights).map(|(v, w)| f64::from(*v) * w).sum();
            assert!((sum - expected).abs() < 2e-6 * expected.abs(), "{number}, {index}: {sum}");
        }
        assert_eq!(written(&grid, &golden.label).center_cell, golden.center_cell, "{number}");
    }
}

#[test]
fn values_at_cells_are_those_that_the_published_loss_reads() {
    for (number, Golden { side, label, .. }) in goldens().into_iter().enumerate() {
        for parity in [true, false] {
            let grid = BodyGrid::new(side, parity);
            let (maps, written) = (maps(&grid, &label), written(&grid, &label));
            assert_eq!((&written.heatmaps, &written.centers), (&maps.heatmaps, &maps.centers));
            let center = written.center_cell as usize;
            for joint in 0..JOINTS {
                let channel = |map: &[f32], cell: usize| {
                    [0, 1].map(|axis| map[(2 * joint + axis) * side * side + cell])
                };
                let reg = channel(&maps.regs, center);
                assert_eq!(written.regs[joint], reg, "{number}, joint {joint}");
                let at = [center % side, center / side];
                let [x, y] = [0, 1].map(|axis| {
                    (reg[axis] as i64 + at[axis] as i64).clamp(0, side as i64 - 1) as usize
                });
                assert_eq!(written.joint_cells[joint] as usize, y * side + x, "{number}, {joint}");
                assert_eq!(written.offsets[joint], channel(&maps.offsets, y * side + x));
            }
        }
    }
}

fn one(x: f32, y: f32, center: [f32; 2]) -> BodyLabel {
    let keypoint = Keypoint { position: Vec2::new(x, y), visibility: Visibility::Visible };
    BodyLabel { keypoints: vec![keypoint], center: center.into(), ..BodyLabel::default() }
}

#[test]
fn blobs_are_round_unless_they_are_as_published() {
    // A single joint spans nothing: radius 4.
    let label = one(0.5, 0.5, [0.5; 2]);
    for parity in [false, true] {
        let map = maps(&BodyGrid::new(48, parity), &label).heatmaps;
        let at = |x: usize, y: usize| map[y * 48 + x];
        assert_eq!([at(24, 24), at(20, 24)], [1.0, (-3f32).exp()]);
        assert_eq!(at(28, 24), if parity { 0.0 } else { (-3f32).exp() });
        assert_eq!([at(27, 27), at(24, 19)], [0.0; 2], "beyond four cells");
        assert_eq!(at(26, 24), (-1.5f32).exp());
    }
}

#[test]
fn persons_that_fill_more_of_the_image_have_larger_blobs() {
    for (side, size) in [(0.39, 3), (0.41, 5), (0.54, 5), (0.55, 7)] {
        let mut label = one(0.1, 0.1, [0.5; 2]);
        label.keypoints.extend(one(0.1 + side, 0.1 + side, [0.5; 2]).keypoints);
        assert_eq!(blob::size(&label), size, "{side}");
        // What nobody labelled spans nothing.
        let far = Keypoint { position: Vec2::splat(9.0), visibility: Visibility::Unlabelled };
        label.keypoints.push(far);
        assert_eq!(blob::size(&label), size, "{side}");
    }
    assert_eq!(blob::size(&BodyLabel::default()), 3);
}

#[test]
fn other_persons_are_on_the_maps_but_not_where_regressions_are_read() {
    let mut label = one(0.1, 0.2, [0.2, 0.2]);
    label.other_centers = vec![Vec2::new(0.5, 0.5), Vec2::new(1.5, 0.5)];
    label.other_keypoints = vec![vec![Vec2::new(0.9, 0.9)]];
    let cell = |x: usize, y: usize| y * 48 + x;
    let right = written(&BodyGrid::new(48, false), &label);
    assert_eq!([right.heatmaps[cell(43, 43)], right.centers[cell(24, 24)]], [1.0; 2]);
    assert_eq!(right.center_cell as usize, cell(9, 9));
    assert_eq!(right.regs, [[-5.0, 0.0]]);
    let published = written(&BodyGrid::new(48, true), &label);
    assert_eq!((published.center_cell as usize, published.regs[0]), (cell(24, 24), [0.0; 2]));
}

#[test]
fn the_cell_that_is_read_is_the_one_that_a_decoder_finds() {
    // A large person a cell beside the middle of the map: weighted, the blob is highest in the
    // middle.
    let mut label = one(0.1, 0.1, [23.5 / 48.0, 0.5]);
    label.keypoints.extend(one(0.9, 0.9, [0.5; 2]).keypoints);
    let written = written(&BodyGrid::new(48, false), &label);
    assert_eq!(written.center_cell, 24 * 48 + 24);
    assert_eq!(written.regs, [[4.0 - 24.0; 2], [43.0 - 24.0; 2]]);
}

#[test]
fn joints_outside_of_the_image_are_not_known_and_the_border_is_inside() {
    let written = |x, y| written(&BodyGrid::new(48, false), &one(x, y, [0.5; 2]));
    for (x, y) in [(-0.001, 0.5), (0.5, 1.001), (f32::NAN, 0.5), (0.5, f32::INFINITY)] {
        let outside = written(x, y);
        assert_eq!((outside.known[0], outside.offsets[0]), (0.0, [0.0; 2]), "{x} {y}");
        assert!(outside.heatmaps.iter().all(|&value| value == 0.0));
    }
    let border = written(1.0, 0.0);
    assert_eq!((border.known[0], border.offsets[0]), (1.0, [1.0, 0.0]));
    assert_eq!(border.joint_cells[0], 47);
}

proptest! {
    #[test]
    fn a_cell_and_its_offset_are_the_joint(
        x in 0.0..1f32, y in 0.0..1f32, cx in 0.0..1f32, cy in 0.0..1f32, side in 1..64usize,
    ) {
        let label = one(x, y, [cx, cy]);
        let exact = written(&BodyGrid::new(side, false), &label);
        let published = written(&BodyGrid::new(side, true), &label);
        let cell = |at: i32| [at as usize % side, at as usize / side];
        let position = |written: &Written| {
            let at = cell(written.joint_cells[0]);
            [0, 1].map(|axis| (at[axis] as f32 + written.offsets[0][axis]) / side as f32)
        };
        let center = cell(exact.center_cell);
        for (axis, truth) in [x, y].into_iter().enumerate() {
            prop_assert!((position(&exact)[axis] - truth).abs() < 1e-6);
            // A quarter of a cell is cut off.
            let cut = truth - position(&published)[axis];
            prop_assert!((-1e-6..0.25 / side as f32 + 1e-6).contains(&cut), "{}", cut);
            let joint = cell(exact.joint_cells[0]);
            prop_assert_eq!(exact.regs[0][axis], joint[axis] as f32 - center[axis] as f32);
        }
    }

    #[test]
    fn a_decoder_finds_the_joints_on_the_maps(stream in 0..1000usize, side in 24..64usize) {
        let label = person(stream, 0.9, 0.05, [0.5, 0.5]);
        let grid = BodyGrid::new(side, false);
        let maps = maps(&grid, &label);
        let BodyMaps { heatmaps, centers, regs, offsets } = &maps;
        let maps = BodyMaps { heatmaps: &heatmaps[..], centers, regs, offsets };
        let joints = BodyDecoder::new([side; 2], DEFAULT_THRESHOLD).decode(&maps);
        for (joint, keypoint) in joints.iter().zip(&label.keypoints) {
            prop_assert_eq!(joint.position.is_some(), keypoint.is_labelled());
            if let Some(position) = joint.position {
                prop_assert!(position.distance(keypoint.position) < 1e-6);
            }
        }
    }
}
