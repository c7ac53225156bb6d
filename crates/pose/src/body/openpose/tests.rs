//! Decoding against an independent program.
//!
//! The values were printed by a NumPy 2.4.6 and PyTorch 2.15.0 program (Python 3.11) that makes the
//! same maps, upsamples them with `torch.nn.functional.interpolate` (bicubic, corners not aligned) and
//! decodes them by itself in double precision. Pairs and channels in it are those of OpenPose's
//! `poseParameters.cpp`.

use glam::DVec2;

use super::*;

const ROWS: usize = 24;
const COLUMNS: usize = 31;
/// Width of the heatmaps' hills, in cells.
const SIGMA: f64 = 0.8;
/// Half the width of a limb's field, in cells.
const HALF_WIDTH: f64 = 1.6;
/// A nose without a body, in cells, and its height.
const STRAY_NOSE: (DVec2, f64) = (DVec2::new(27.3, 2.4), 0.3);

/// The 25 parts of BODY_25, in cells.
#[rustfmt::skip]
const TEMPLATE: [[f64; 2]; 25] = [
    [10.31, 3.17], [10.12, 5.43], [8.07, 5.61], [7.23, 8.87], [6.41, 11.73],
    [12.19, 5.37], [13.27, 8.53], [14.61, 11.19], [10.23, 11.57], [8.83, 11.67],
    [8.47, 15.83], [8.13, 19.71], [11.59, 11.47], [12.07, 15.59], [12.71, 19.37],
    [9.87, 2.71], [10.83, 2.63], [9.21, 3.07], [11.43, 2.97], [13.87, 20.67],
    [14.23, 20.31], [12.43, 19.97], [7.07, 20.93], [6.71, 20.57], [8.33, 20.23],
];

/// A person in the maps: the template, scaled and moved.
struct Shown {
    scale: f64,
    origin: DVec2,
    height: f64,
    missing: &'static [usize],
}

const PEOPLE: [Shown; 2] = [
    Shown { scale: 1.0, origin: DVec2::ZERO, height: 0.9, missing: &[] },
    // Without the left elbow and wrist.
    Shown { scale: 0.62, origin: DVec2::new(17.1, 6.3), height: 0.55, missing: &[6, 7] },
];

/// Index in the template of a part; COCO has no middle of the hips and no feet.
fn template_index(model: OpenPoseModel, part: usize) -> usize {
    if model == OpenPoseModel::Coco18 && part >= 8 { part + 1 } else { part }
}

/// Heatmaps and fields of both people.
fn maps(model: OpenPoseModel) -> (Vec<f32>, Vec<f32>) {
    let cells = ROWS * COLUMNS;
    let center = |cell: usize| DVec2::new((cell % COLUMNS) as f64, (cell / COLUMNS) as f64);
    let hill = |at: DVec2, height: f64, cell: usize| {
        height * (-center(cell).distance_squared(at) / (2.0 * SIGMA * SIGMA)).exp()
    };
    let mut heatmaps = vec![0.0_f64; model.heatmap_channels() * cells];
    let mut fields = vec![0.0_f64; model.field_channels() * cells];
    for person in &PEOPLE {
        let is_shown = |part: usize| !person.missing.contains(&template_index(model, part));
        let at = |part: usize| {
            DVec2::from(TEMPLATE[template_index(model, part)]) * person.scale + person.origin
        };
        for part in (0..model.parts()).filter(|part| is_shown(*part)) {
            for cell in 0..cells {
                let value = &mut heatmaps[part * cells + cell];
                // OpenPose trains on the larger of two hills, which keeps both peaks apart.
                *value = value.max(hill(at(part), person.height, cell));
            }
        }
        for limb in model.limbs() {
            if limb.parts.iter().any(|part| !is_shown(*part)) {
                continue;
            }
            let [from, to] = limb.parts.map(at);
            let line = to - from;
            for cell in 0..cells {
                let along =
                    ((center(cell) - from).dot(line) / line.length_squared()).clamp(0.0, 1.0);
                let distance = center(cell).distance(from + along * line);
                let weight = person.height * (1.0 - distance / HALF_WIDTH).max(0.0);
                let field = weight * line.normalize();
                fields[limb.channel * cells + cell] += field.x;
                fields[(limb.channel + 1) * cells + cell] += field.y;
            }
        }
    }
    for (cell, value) in heatmaps.iter_mut().enumerate().take(cells) {
        *value = value.max(hill(STRAY_NOSE.0, STRAY_NOSE.1, cell));
    }
    let single = |maps: Vec<f64>| maps.into_iter().map(|value| value as f32).collect();
    (single(heatmaps), single(fields))
}

fn check(model: OpenPoseModel, scores: [f32; 2]) {
    let (heatmaps, fields) = maps(model);
    let decoder = OpenPoseDecoder::new(model, [ROWS, COLUMNS], OpenPoseOptions::default());
    let people = decoder.people(&heatmaps, &fields);
    assert_eq!(people.len(), PARTS.len(), "{}", model.name());
    for ((person, score), parts) in people.iter().zip(scores).zip(PARTS) {
        assert!((person.score - score).abs() < 2e-3, "{}, not {score}", person.score);
        assert_eq!(person.parts.len(), model.parts());
        for (k, part) in person.parts.iter().enumerate() {
            let [x, y, score] = parts[template_index(model, k)];
            assert_eq!(part.position.is_some(), score > 0.0, "part {k}");
            let at = part.position.unwrap_or_default();
            assert!(at.distance(Vec2::new(x, y)) < 1e-5, "part {k}: {at}, not {x}, {y}");
            assert!((part.score - score).abs() < 1e-5, "part {k}");
        }
    }
}

#[test]
fn people_are_those_of_an_independent_program() {
    check(OpenPoseModel::Coco18, [30.18613, 16.44942]);
    check(OpenPoseModel::Body25, [41.59627, 23.34917]);
}

#[test]
fn the_joints_are_those_of_the_person_of_the_highest_score() {
    for model in OpenPoseModel::ALL {
        let (heatmaps, fields) = maps(model);
        let decoder = OpenPoseDecoder::new(model, [ROWS, COLUMNS], OpenPoseOptions::default());
        let joints = decoder.joints(&heatmaps, &fields);
        // Shoulders, elbows, wrists, hips, knees and ankles of the template, the left one first.
        let parts = [5, 2, 6, 3, 7, 4, 12, 9, 13, 10, 14, 11];
        let head = 0.5 * (DVec2::from(TEMPLATE[17]) + DVec2::from(TEMPLATE[18]));
        let below = parts.map(|part| DVec2::from(TEMPLATE[part]));
        let cells = DVec2::new(COLUMNS as f64, ROWS as f64);
        for (joint, at) in joints.iter().zip([head].iter().chain(&below)) {
            let position = joint.position.unwrap().as_dvec2() * cells - 0.5;
            assert!(position.distance(*at) < 0.25, "{position}, not {at}");
        }
        let nobody = decoder.joints(&vec![0.0; heatmaps.len()], &vec![0.0; fields.len()]);
        assert!(nobody.iter().all(|joint| joint.position.is_none()));
    }
}

/// Column and row relative to the maps, and score, of the parts of both people; the same of either model.
#[rustfmt::skip]
const PARTS: [[[f32; 3]; 25]; 2] = [
    [
        [0.344926, 0.148670, 0.854227], [0.340794, 0.247288, 0.846400], [0.276168, 0.257711, 0.854449],
        [0.247946, 0.393113, 0.873023], [0.219896, 0.512938, 0.829117], [0.409138, 0.242214, 0.843749],
        [0.441596, 0.377551, 0.826136], [0.489840, 0.486803, 0.841087], [0.344721, 0.502712, 0.832997],
        [0.304256, 0.507935, 0.851150], [0.288347, 0.684663, 0.838270], [0.276300, 0.846205, 0.863865],
        [0.393007, 0.497449, 0.806576], [0.405200, 0.674301, 0.851334], [0.429320, 0.825547, 0.831390],
        [0.336603, 0.137872, 0.863865], [0.368772, 0.132786, 0.847046], [0.312413, 0.148383, 0.879740],
        [0.384997, 0.143396, 0.850167], [0.465636, 0.882935, 0.856776], [0.473753, 0.862196, 0.847328],
        [0.417255, 0.851729, 0.850167], [0.243909, 0.893284, 0.895345], [0.235772, 0.877712, 0.824259],
        [0.284179, 0.861931, 0.844275],
    ],
    [
        [0.772288, 0.362046, 0.504395], [0.768178, 0.424589, 0.503406], [0.727854, 0.429762, 0.535690],
        [0.715566, 0.513164, 0.510912], [0.695532, 0.586056, 0.519253], [0.812560, 0.424450, 0.503222],
        [0.000000, 0.000000, 0.000000], [0.000000, 0.000000, 0.000000], [0.772133, 0.580796, 0.491722],
        [0.744050, 0.585907, 0.492237], [0.735854, 0.690176, 0.523347], [0.727936, 0.794179, 0.514516],
        [0.796475, 0.575704, 0.504939], [0.812342, 0.685051, 0.519838], [0.820716, 0.778860, 0.528410],
        [0.764049, 0.351758, 0.537130], [0.788092, 0.351619, 0.538995], [0.752153, 0.361845, 0.529571],
        [0.792556, 0.356920, 0.535133], [0.848647, 0.815179, 0.527605], [0.852849, 0.809843, 0.545501],
        [0.816660, 0.804442, 0.518734], [0.707744, 0.820417, 0.503705], [0.699636, 0.815003, 0.534088],
        [0.731905, 0.809700, 0.528356],
    ],
];
