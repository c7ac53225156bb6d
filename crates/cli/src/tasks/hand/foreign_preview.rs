//! Overlays of the recordings of other hands on which a network is worst, of middling ones, and of
//! the best.

use std::path::Path;

use anyhow::Result;
use evpose_core::{Plane, Polarity};
use evpose_report::canvas::{Canvas, PREDICTION, TRUTH, contact_sheet};
use evpose_report::png::png;
use evpose_task::hand::{HandConfig, Predictor};
use evpose_train::foreign::{ForeignHand, ForeignHandView, foreign_hand_views};
use image::RgbImage;

use crate::outputs::write_file;

/// Recordings of each kind: worst, median, best.
const EACH: usize = 3;
const VIEWS: usize = 4;
/// Width of each view, at least.
const WIDTH_PX: u32 = 380;

/// Draws them to a PNG file, a recording in each row, and returns the names of the rows. `scores`
/// are those of the recordings, higher ones better.
pub(super) fn write(
    config: &HandConfig,
    recordings: &[ForeignHand],
    scores: &[f64],
    predictor: &mut dyn Predictor,
    path: &Path,
) -> Result<Vec<String>> {
    let mut order: Vec<usize> = (0..recordings.len().min(scores.len())).collect();
    order.sort_by(|&a, &b| scores[a].total_cmp(&scores[b]));
    let count = order.len();
    let middle = count.saturating_sub(EACH) / 2;
    let mut rows: Vec<usize> = (0..EACH.min(count))
        .chain(middle..(middle + EACH).min(count))
        .chain(count.saturating_sub(EACH)..count)
        .collect();
    // Of few recordings the three parts overlap.
    rows.sort_unstable();
    rows.dedup();
    let (mut images, mut names) = (Vec::new(), Vec::new());
    for row in rows {
        let recording = &recordings[order[row]];
        let views = foreign_hand_views(config, recording, predictor, VIEWS)?;
        for view in &views {
            images.push(overlay(config, view)?);
        }
        names.push(recording.name.clone());
    }
    let sheet = contact_sheet(&images, VIEWS);
    write_file(path, &png(&sheet)?)?;
    Ok(names)
}

fn overlay(config: &HandConfig, view: &ForeignHandView) -> Result<RgbImage> {
    let (height, width) = view.size;
    let order = config.representation.channel_order;
    let plane = |polarity| {
        let start = order.channel(polarity) * width * height;
        Plane::from_vec(width, height, view.values[start..start + width * height].to_vec())
    };
    let scale = WIDTH_PX.div_ceil(width as u32);
    let mut canvas = Canvas::events(&plane(Polarity::On)?, &plane(Polarity::Off)?, scale);
    canvas.hand_in_view(&view.truth_px, TRUTH);
    canvas.hand_in_view(&view.predicted_px, PREDICTION);
    Ok(canvas.into_image())
}
