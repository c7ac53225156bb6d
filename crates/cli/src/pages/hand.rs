//! The report of a hand experiment: curves, tables and frames in one page.

use std::path::Path;

use anyhow::{Context, Result};
use evpose_core::Plane;
use evpose_pose::HandPose;
use evpose_pose::metric::Pck;
use evpose_task::Experiment as _;
use evpose_task::hand::{HandConfig, HandView};
use evpose_train::{HandDataset, HandPoseTrack, HandSequence, HistoryLine, MethodResults};
use image::{Rgb, RgbImage};

use crate::outputs::write_file;
use crate::pages::findings;
use crate::pages::held_out::{HeldOutEvaluation, header, rows};
use crate::pages::learning;
use evpose_report::canvas::{Canvas, PREDICTION, TRUTH, contact_sheet};
use evpose_report::chart::{self, Series};
use evpose_report::colour::palette;
use evpose_report::html::{HtmlPage, escape};
use evpose_report::png::png;
use evpose_train::training::TrainingSpan;

const STRIP: usize = 12;
/// Frames per second of the animation, and its length.
const ANIMATION_HZ: u64 = 20;
const ANIMATION_S: u64 = 3;
/// Width a frame is enlarged to, at least.
const FRAME_PX: u32 = 270;

/// Writes `report.html`, and its strip of frames also as `frames.png`, into `dir`.
///
/// `history` has the losses of the training, `facts` lines about what was measured: sizes, speeds, machine.
pub fn write(
    dir: &Path,
    config: &HandConfig,
    held_out: &HandDataset,
    evaluation: &HeldOutEvaluation,
    (history, facts): (&[HistoryLine], &[String]),
) -> Result<()> {
    let hands = [(shown(evaluation)?, PREDICTION)];
    let strip = png(&strip(config, held_out, &hands)?)?;
    write_file(&dir.join("frames.png"), &strip)?;
    let animation = animation(config, held_out, hands[0].0)?;

    let is_trained = !history.is_empty();
    let made = if is_trained {
        "Simulated, trained, evaluated and drawn by evpose on this machine."
    } else {
        "Nothing was trained: the network that ships with evpose was evaluated on hands simulated on this \
         machine."
    };
    let mut page = HtmlPage::new("Hand pose from an event camera", made);
    page.section(
        "What was learned, and what not",
        "On people, motions and backgrounds that the training did not show. An error of 1 is that of the \
         mean pose, which uses no events; brackets are 95% intervals over sequences.",
    );
    let sentences = findings::sentences(&evaluation.metrics);
    let items = sentences.iter().map(|sentence| format!("<li>{}</li>", escape(sentence)));
    page.markup(&format!("<ul>{}</ul>", items.collect::<String>()));
    page.section(
        "Held-out sequences",
        "Means over all evaluated poses with 95% bootstrap intervals over sequences. mean_pose always \
         predicts the average training pose; untrained is the network before its first step. \
         AUC: larger is better; everything else: smaller.",
    );
    let rows: Vec<Vec<String>> = rows(config, evaluation)
        .into_iter()
        .map(|row| row.into_iter().map(|(n, i)| format!("{n} <small>{i}</small>")).collect())
        .collect();
    page.table(&header(), &rows);

    page.section(
        "Input of the network, and its predictions",
        "Event images (ON blue, OFF red, newer darker) of held-out sequences.",
    );
    let key = format!(
        "<span class=\"key\" style=\"background:{}\"></span>true hand\
         <span class=\"key\" style=\"background:{}\"></span>predicted hand (network and Kalman filter)",
        css(TRUTH),
        css(PREDICTION)
    );
    page.image("image/gif", &animation, "animation of a held-out sequence", &key);
    page.image("image/png", &strip, "held-out frames with true and predicted hands", &key);

    page.section(
        "Correct points",
        "Share of points whose error is below a threshold (PCK). 3D: 20 points relative to the \
         wrist. 2D: 7 points, in percent of the palm's length in the image.",
    );
    page.plots(&pck_plots(&evaluation.methods)?);
    if is_trained {
        page.section(
            "Learning curves",
            "Each interval ends with a validation on held-back seconds.",
        );
        page.plots(&learning_curves(config, history)?);
    }

    page.section("How it was made", "");
    page.details("Measured", &facts.join("\n"));
    page.details("Resolved config", &config.to_toml()?);
    write_file(&dir.join("report.html"), page.finish())
}

fn css(colour: Rgb<u8>) -> String {
    let [r, g, b] = colour.0;
    format!("rgb({r},{g},{b})")
}

fn pck_plots(methods: &[MethodResults]) -> Result<Vec<String>> {
    let plot = |title, x, of_3d: bool| {
        let curves = methods
            .iter()
            .enumerate()
            .map(|(i, method)| {
                let curves = method.evaluation.curves();
                let shares = if of_3d { curves.pck_3d } else { curves.pck_2d };
                let points = shares.iter().enumerate().map(|(i, &pck)| (Pck::threshold(i), pck));
                Series::line(method.name, palette(i), points.collect())
            })
            .collect();
        chart::pck(title, x, curves)
    };
    Ok(vec![
        plot("3D, relative to the wrist", "threshold in mm", true)?,
        plot("2D", "threshold in % of the palm's length in the image", false)?,
    ])
}

/// Loss and the errors it is made of, over training samples.
fn learning_curves(config: &HandConfig, history: &[HistoryLine]) -> Result<Vec<String>> {
    let charts = learning::charts(history, TrainingSpan::from(&config.training));
    Ok(charts.iter().map(chart::curves).collect::<Result<_, _>>()?)
}

/// The filtered predictions, or the last method's where there are none.
fn shown(evaluation: &HeldOutEvaluation) -> Result<&MethodResults> {
    let filtered = evaluation.methods.iter().find(|method| method.name == "trained_kalman");
    filtered.or(evaluation.methods.last()).context("no method was evaluated")
}

/// Frames from all over `data`, with the hands of some methods at those of the first, in colours of their own.
pub fn strip(
    config: &HandConfig,
    data: &HandDataset,
    shown: &[(&MethodResults, Rgb<u8>)],
) -> Result<RgbImage> {
    let view = HandView::new(config)?;
    let sequences = data.sequences();
    let frames: Vec<RgbImage> = (0..STRIP)
        .map(|i| {
            // Frames are spread evenly over the sequences, of which there may be fewer.
            let sequence =
                i * sequences.len() / STRIP.min(sequences.len().max(1)) % sequences.len();
            let tracks = shown.iter().map(|(method, colour)| (&method.tracks[sequence], *colour));
            let frames = &tracks.clone().next().context("no method is shown")?.0.frames;
            // Spread over the sequence, away from its ends.
            let at = (frames.len() * (2 * (i % 5) + 1)) / 10;
            let frame = *frames.get(at).context("no pose was evaluated")?;
            let hand = |(track, colour): (&HandPoseTrack, _)| Some((track.at(frame)?, colour));
            let hands: Vec<_> = tracks.filter_map(hand).collect();
            overlay(config, data, &view, &sequences[sequence], frame, &hands)
        })
        .collect::<Result<_>>()?;
    Ok(contact_sheet(&frames, 4))
}

/// The sequence whose wrist error is the median: neither the best nor the worst.
fn median_sequence(shown: &MethodResults) -> usize {
    let error_mm =
        |&i: &usize| shown.evaluation.sequences[i].translation_mm.mean().unwrap_or(f64::INFINITY);
    let mut order: Vec<usize> = (0..shown.evaluation.sequences.len()).collect();
    order.sort_by(|a, b| error_mm(a).total_cmp(&error_mm(b)));
    order[order.len() / 2]
}

/// The start of a held-out sequence of median error, at half speed.
fn animation(config: &HandConfig, data: &HandDataset, shown: &MethodResults) -> Result<Vec<u8>> {
    use image::codecs::gif::{GifEncoder, Repeat};
    let view = HandView::new(config)?;
    let index = median_sequence(shown);
    let sequence = &data.sequences()[index];
    let track = &shown.tracks[index];
    let mut gif = Vec::new();
    {
        // 20 of 1 (best) to 30 (fastest): few flat colours need no better palette.
        let mut encoder = GifEncoder::new_with_speed(&mut gif, 20);
        encoder.set_repeat(Repeat::Infinite)?;
        let step_ms = 1000 / ANIMATION_HZ;
        let mut next = track.frames.first().copied().unwrap_or(0);
        let end = next + ANIMATION_S * 1000;
        for (&frame, pose) in track.frames.iter().zip(&track.poses) {
            // Poses are denser than frames of the animation.
            if frame < next || frame >= end {
                continue;
            }
            next = frame + step_ms;
            let hands = [(*pose, PREDICTION)];
            let image = overlay(config, data, &view, sequence, frame, &hands)?;
            let image = image::DynamicImage::ImageRgb8(image).into_rgba8();
            let delay = image::Delay::from_numer_denom_ms(2 * step_ms as u32, 1);
            encoder.encode_frame(image::Frame::from_parts(image, 0, 0, delay))?;
        }
    }
    Ok(gif)
}

/// One window of events with the true and the predicted hands over it.
fn overlay(
    config: &HandConfig,
    data: &HandDataset,
    view: &HandView,
    sequence: &HandSequence,
    frame: u64,
    predicted: &[(HandPose, Rgb<u8>)],
) -> Result<RgbImage> {
    use evpose_core::Polarity;
    let planes = data.evaluation_input(sequence, frame)?;
    let (height, width) = data.image_size();
    let order = config.representation.channel_order;
    let plane = |polarity| {
        let start = order.channel(polarity) * width * height;
        Plane::from_vec(width, height, planes[start..start + width * height].to_vec())
    };
    let scale = FRAME_PX.div_ceil(width as u32);
    let mut canvas = Canvas::events(&plane(Polarity::On)?, &plane(Polarity::Off)?, scale);
    let betas = sequence.betas(sequence.episode_of(frame));
    let hand = sequence.hand();
    let truth = sequence.points(view, frame, &view.shaped(betas))?;
    let predicted = predicted.iter().map(|(pose, colour)| (view.points_seen(hand, pose), *colour));
    for (points, colour) in std::iter::once((truth, TRUTH)).chain(predicted) {
        // What is behind the camera has no image.
        if let Some(points) = points.in_front() {
            canvas.hand(&points, colour);
        }
    }
    Ok(canvas.into_image())
}
