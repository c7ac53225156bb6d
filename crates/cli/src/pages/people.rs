//! Figures of people: rendered frames with events, and predictions over the network's input.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_core::{Micros, Plane, SensorSize};
use evpose_pose::body::BodyPoints;
use evpose_sim::person::{People, PersonStep};
use evpose_task::body::{BodyCheckpoint, BodyPredictor, RepresentationReader};
use evpose_train::body::{BodyFrames, BodyResults};
use glam::Vec2;
use image::RgbImage;
use rayon::prelude::*;

use crate::outputs::write_file;
use crate::pages::recent_events::RecentEvents;
use crate::progress::say;
use evpose_report::canvas::{Canvas, PREDICTION, TRUTH, contact_sheet};
use evpose_report::png::png;

const SEQUENCES: usize = 12;
/// Images in a row.
const COLUMNS: usize = 4;
const GAMMA: f32 = 2.2;
/// Over how long events are shown.
const SHOWN: Micros = Micros(30_000);
/// Times of a sequence among which the one with most events about the person is shown: people rest at
/// times. They are evenly spaced from this share of the sequence on.
const CANDIDATES: u64 = 12;
const FIRST_SHARE: f64 = 0.3;
/// Around the joints, as a share of what they span.
const MARGIN: f32 = 0.25;

/// Writes rendered frames with the joints, and below them the events of the same time: of each sequence
/// the instant with most events about the person. The same for any number of threads.
///
/// # Errors
/// If a sequence cannot be simulated, or the file cannot be written.
pub fn of_people(people: &People, path: &Path) -> Result<()> {
    let count = people.config().sequences.min(SEQUENCES) as u64;
    let pairs: Vec<[RgbImage; 2]> =
        (0..count).into_par_iter().map(|index| instant(people, index)).collect::<Result<_>>()?;
    let mut images = Vec::new();
    for row in pairs.chunks(COLUMNS) {
        images.extend(row.iter().map(|[frame, _]| frame.clone()));
        images.extend(row.iter().map(|[_, events]| events.clone()));
    }
    write(&contact_sheet(&images, COLUMNS.min(pairs.len().max(1))), path)
}

/// The frame and the events of a sequence where the person moves most.
fn instant(people: &People, index: u64) -> Result<[RgbImage; 2]> {
    let steps = people.config().steps();
    let first = (FIRST_SHARE * steps as f64) as u64;
    let spacing = ((steps - first) / CANDIDATES).max(1);
    let mut simulator = people.sequence(index)?;
    // Randomised sequences have sensors of their own.
    let sensor = simulator.sensor();
    let mut recent = RecentEvents::new(sensor, SHOWN);
    let mut busiest: Option<(usize, [RgbImage; 2])> = None;
    for number in 0..steps {
        let step = simulator.advance()?;
        recent.push(step.events);
        if number < first || !(number - first).is_multiple_of(spacing) {
            continue;
        }
        let count = recent.count(step.t, corners(&step.joints_px, sensor));
        if busiest.as_ref().is_none_or(|(most, _)| count > *most) {
            let frame = photograph(&step, sensor).into_image();
            busiest = Some((count, [frame, recent.image(step.t, 1)]));
        }
    }
    busiest.map(|(_, images)| images).context("sequences without steps")
}

/// The rectangle of the joints, with a margin; the whole image where nobody is in view.
fn corners(joints_px: &BodyPoints, sensor: SensorSize) -> [Vec2; 2] {
    let joints = || joints_px.iter().flatten().copied();
    match (joints().reduce(Vec2::min), joints().reduce(Vec2::max)) {
        (Some(low), Some(high)) => {
            // The longer side decides, or upright people would have little room at their sides.
            let margin = MARGIN * (high - low).max_element();
            [low - margin, high + margin]
        }
        _ => [Vec2::ZERO, Vec2::new(f32::from(sensor.width), f32::from(sensor.height))],
    }
}

/// The frame, exposed so that its brightest pixel is white.
fn photograph(step: &PersonStep<'_>, sensor: SensorSize) -> Canvas {
    let mut grey = Plane::for_sensor(sensor, 0);
    let white = step.luminance.data().iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    for (code, light) in grey.data_mut().iter_mut().zip(step.luminance.data()) {
        *code = (255.0 * (light / white).clamp(0.0, 1.0).powf(1.0 / GAMMA)) as u8;
    }
    let mut canvas = Canvas::grey(&grey, 1);
    canvas.body(&step.joints_px, TRUTH);
    canvas
}

/// Draws true and predicted joints over inputs of the network.
pub fn of_predictions(
    checkpoint: &BodyCheckpoint,
    evaluation: &BodyResults,
    path: &Path,
) -> Result<()> {
    let mut images = Vec::new();
    let step = evaluation.recordings.len().div_ceil(SEQUENCES).max(1);
    for (k, recording) in evaluation.recordings.iter().step_by(step).enumerate() {
        // Different phases of a motion in every recording.
        let share = 0.35 + 0.05 * (k % SEQUENCES) as f64;
        let index = (share * recording.predictions.len() as f64) as usize;
        let Some(found) = recording.predictions.get(index) else { continue };
        let mut reader = RepresentationReader::open(&recording.events, &checkpoint.config.image)?;
        let image = reader.at(Micros::from_seconds(found.t_s), |_| {})?;
        let mut canvas = Canvas::grey(&image, 2);
        // Both times went through seconds, and may differ in their last digit.
        let after = recording.truth.partition_point(|truth| truth.t_s < found.t_s - 1e-9);
        if let Some(truth) = recording.truth.get(after) {
            canvas.body(&reader.image_points(&truth.joints_px), TRUTH);
        }
        canvas.body(&reader.image_points(&found.joints_px), PREDICTION);
        images.push(canvas.into_image());
    }
    write(&contact_sheet(&images, COLUMNS), path)
}

/// Draws true and predicted joints over images with labels.
pub fn of_frames(predictor: &BodyPredictor, frames: &BodyFrames, path: &Path) -> Result<()> {
    let mut predictor = predictor.another();
    let step = frames.len().div_ceil(SEQUENCES).max(1);
    let images: Vec<RgbImage> = frames
        .frames
        .iter()
        .step_by(step)
        .map(|frame| {
            let size_px = Vec2::new(frame.image.width() as f32, frame.image.height() as f32);
            let mut truth = BodyPoints::default();
            for (point, keypoint) in truth.iter_mut().zip(&frame.label.keypoints) {
                *point = keypoint.is_labelled().then(|| keypoint.position * size_px);
            }
            let mut canvas = Canvas::grey(&frame.image, 2);
            canvas.body(&truth, TRUTH);
            canvas.body(&predictor.predict(0.0, &frame.image).joints_px, PREDICTION);
            canvas.into_image()
        })
        .collect();
    write(&contact_sheet(&images, COLUMNS.min(images.len().max(1))), path)
}

fn write(sheet: &RgbImage, path: &Path) -> Result<()> {
    write_file(path, &png(sheet)?)?;
    say(format!("figure: {}", path.display()));
    Ok(())
}
