//! The prior of a fit of hands, from landmarks of real ones.
//!
//! ```text
//! cargo run --release -p evpose-body --example real_hands -- asl-ai/data/raw_gestures crates/body/src/hand_fit/real_hands.txt
//! ```
//!
//! reads `CLASS/*.npy`, the 21 landmarks of MediaPipe (x, y, z in parts of the image) of 10,508 photographs of letters of
//! the American manual alphabet (`borisgraudt/asl-ai`, CC0-1.0), fits the angles of the digits to each, and writes
//! their mean and covariance, each class counting as much as any other. The width of the images over their height,
//! which is not stated, is the one with which hands fit best.

#![allow(clippy::print_stderr, reason = "a program for the terminal")]

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use evpose_body::{BodyModel, HandFit, JointObservation};
use evpose_pose::HandSide;
use glam::{Vec2, Vec3};

/// Landmarks of MediaPipe in the order of [`evpose_pose::EVALUATION_JOINTS`].
const LANDMARKS: [usize; 21] =
    [0, 4, 8, 12, 16, 20, 5, 6, 7, 9, 10, 11, 17, 18, 19, 13, 14, 15, 1, 2, 3];
const MIDDLE_KNUCKLE: usize = 9;
/// Widths of images over heights that cameras have.
const ASPECTS: [f32; 5] = [0.5625, 0.75, 1.0, 4.0 / 3.0, 16.0 / 9.0];
/// Distance at which hands are taken to be, in metres, and cells of a heatmap for one of a ray.
const DISTANCE_M: f32 = 1.2;
const FOCAL_CELLS: f32 = 1000.0;
/// Every so many hands decide the shape of the images.
const STRIDE: usize = 10;
/// Largest mean error of a hand that counts, in lengths of the palm: others are errors of the landmarks.
const MAX_ERROR: f32 = 0.12;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, file] = &args[..] else { return Err("FOLDER and FILE are needed".into()) };
    let mut classes = Vec::new();
    for class in sorted(Path::new(folder))? {
        let hands: Result<Vec<_>, _> = sorted(&class)?.iter().map(|path| landmarks(path)).collect();
        classes.push(hands?);
    }
    let model = BodyModel::procedural_arm();
    let fit = HandFit::new(&model, &model.shaped(&[]), HandSide::Right);
    let errors = ASPECTS.map(|aspect| {
        let some = classes.iter().flatten().step_by(STRIDE);
        let errors: Vec<f32> = some.map(|hand| fitted(&fit, hand, aspect).1).collect();
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        eprintln!("width over height {aspect:.3}: error {mean:.4} palms");
        mean
    });
    let best = (0..ASPECTS.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b])).unwrap_or(0);

    let (mut mean, mut second) = ([0.0; 20], vec![[0.0; 20]; 20]);
    for hands in &classes {
        let all = hands.iter().map(|hand| fitted(&fit, hand, ASPECTS[best]));
        let kept: Vec<[f64; 20]> =
            all.filter(|(_, error)| *error < MAX_ERROR).map(|(angles, _)| angles).collect();
        eprintln!("{} of {} hands", kept.len(), hands.len());
        let weight = 1.0 / (kept.len() * classes.len()) as f64;
        for hand in &kept {
            for i in 0..20 {
                mean[i] += weight * hand[i];
                (0..20).for_each(|j| second[i][j] += weight * hand[i] * hand[j]);
            }
        }
    }
    let mut text = String::new();
    writeln!(text, "{}", line(&mean))?;
    for i in 0..20 {
        let row: Vec<f64> = (0..=i).map(|j| second[i][j] - mean[i] * mean[j]).collect();
        writeln!(text, "{}", line(&row))?;
    }
    fs::write(file, text)?;
    Ok(())
}

fn line(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|value| format!("{value:.0}")).collect();
    values.join(" ")
}

fn sorted(folder: &Path) -> Result<Vec<std::path::PathBuf>, std::io::Error> {
    let mut paths = fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<_>, _>>()?;
    paths.sort();
    Ok(paths)
}

/// 63 values of double precision behind the header of a NumPy file.
fn landmarks(path: &Path) -> Result<Vec<Vec3>, Box<dyn Error>> {
    let bytes = fs::read(path)?;
    let values = bytes.len().checked_sub(63 * 8).and_then(|start| bytes.get(start..));
    let values = values.ok_or_else(|| format!("{}: too short", path.display()))?;
    let values: Vec<f32> =
        values.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes) as f32).collect();
    Ok(values.as_chunks::<3>().0.iter().map(|point| Vec3::from_array(*point)).collect())
}

/// The angles of a hand in degrees, digit by digit, and the mean error of its joints in lengths of the palm.
fn fitted(fit: &HandFit, landmarks: &[Vec3], aspect: f32) -> ([f64; 20], f32) {
    // Left hands, and right ones in a mirror, are tried as right ones.
    let tries = [1.0, -1.0].map(|mirror| {
        let from_wrist = LANDMARKS.map(|at| {
            let off = landmarks[at] - landmarks[0];
            Vec3::new(mirror * off.x, -off.y / aspect, off.z)
        });
        let palm = from_wrist[MIDDLE_KNUCKLE].length().max(1e-6);
        let ray_per_unit = fit.palm_m() / DISTANCE_M / palm;
        let observed = JointObservation {
            rays: from_wrist.map(|point| ray_per_unit * point.truncate()),
            depths: from_wrist.map(|point| point.z / palm),
            spread_cells: [0.0; 21],
            scores: [1.0; 21],
            presence: 1.0,
        };
        let pose = fit.fit(&observed, FOCAL_CELLS);
        let seen = fit.points_m(&pose).map(|point| point.truncate() / -point.z);
        let off = seen.iter().zip(&observed.rays).map(|(a, b): (&Vec2, &Vec2)| a.distance(*b));
        let error = off.sum::<f32>() / 21.0 / (ray_per_unit * palm);
        let angles =
            std::array::from_fn(|k| f64::from(pose.angles.digits[k / 4][k % 4].to_degrees()));
        (angles, error)
    });
    let [a, b] = tries;
    if a.1 <= b.1 { a } else { b }
}
