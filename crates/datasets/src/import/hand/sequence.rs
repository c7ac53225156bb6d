//! A recording of a hand and its labels as sequences in the view of a network: `NAME.evc` (`NAME.raw`
//! of a view of more than 256 rows, or the format of the config), `NAME.meta` and `NAME.toml`, as
//! `evpose simulate` writes them.
//!
//! Frame `k` holds the events of millisecond `k` of the sequence, and record `k` is the pose at the end of
//! that millisecond, as of simulated sequences: what `evpose infer` states for the same events.

use std::ops::Range;
use std::path::{Path, PathBuf};

use evpose_camera::{Calibration, ViewAdaptor};
use evpose_core::{EventStream, Micros, TimeWindow};
use evpose_io::MetaWriter;
use evpose_pose::{HandParams, HandSide};
use evpose_sim::{EventFormat, SequenceInfo, StepWriter};
use evpose_task::hand::{HandConfig, HandView, canonical_view};

use super::fit::{FitOptions, FittedHand, HandFitter};
use super::format::{HandJoints, HandLabels, LabelledHand};
use super::track::pose_at;
use crate::import::ImportError;
use crate::import::stretch::{MS, WrittenSequence, cut, floor_ms, name_of, stretches, within};

/// Labels from which the size of a hand is taken.
const SIZE_LABELS: usize = 12;

/// Options of importing recordings of hands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandOptions {
    /// Whether sequences that are there are written again, in place of an error.
    pub replace: bool,
    /// Time of the labels' 0 in the clock of the events.
    pub start: Micros,
    /// Longest time between labels over which they are interpolated.
    pub max_gap: Micros,
    /// Shortest sequence.
    pub min_length: Micros,
    /// Side of the hand.
    pub side: HandSide,
    /// Whether the size of the hand is taken from joints in space, instead of from `fit`.
    pub fit_scale: bool,
    /// Fitting of joints.
    pub fit: FitOptions,
}

impl Default for HandOptions {
    fn default() -> Self {
        Self {
            replace: false,
            start: Micros(0),
            max_gap: Micros(100_000),
            min_length: Micros(100_000),
            side: HandSide::Right,
            fit_scale: false,
            fit: FitOptions::default(),
        }
    }
}

/// Result of importing a recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HandReport {
    /// The written sequences.
    pub sequences: Vec<WrittenSequence>,
    /// Count of labels that were used.
    pub labels: usize,
    /// Count of labels outside of the recording.
    pub outside_recording: usize,
    /// Count of labels with too few joints.
    pub incomplete: usize,
    /// Count of labels in stretches shorter than a sequence.
    pub isolated: usize,
    /// Residuals of fitted joints with their time stamps in the clock of the recording.
    pub residuals: Vec<(Micros, FittedHand)>,
    /// Those that are large, the largest first.
    pub poor: Vec<(Micros, FittedHand)>,
    /// Size of the hand relative to the neutral one.
    pub scale: f64,
    /// Whether the mirror image was written: the network is one of the other hand.
    pub is_mirrored: bool,
}

impl HandReport {
    /// Mean residual in pixels of the sensor and, of joints in space, in metres; none without fits.
    pub fn mean_residual(&self) -> Option<(f32, Option<f32>)> {
        let count = self.residuals.len() as f32;
        let fits = || self.residuals.iter().map(|(_, fitted)| fitted);
        let px = fits().map(|fitted| fitted.residual_px).sum::<f32>() / count;
        let m = fits().map(|fitted| fitted.residual_m).sum::<Option<f32>>().map(|sum| sum / count);
        (count > 0.0).then_some((px, m))
    }
}

/// Writes a recording by the camera of `calibration` and its labels, which are of the file
/// `path`, as sequences in the view of `config` into `directory`, one for each stretch without a
/// long gap between labels. `progress` receives 1 after each label.
///
/// # Errors
/// If labels and recording do not fit, a sequence of that name exists, or a file cannot be read or
/// written.
pub fn import_hand(
    events: &EventStream,
    calibration: &Calibration,
    (labels, path): (&HandLabels, &Path),
    config: &HandConfig,
    options: &HandOptions,
    (directory, name): (&Path, &str),
    progress: &mut dyn FnMut(u64),
) -> Result<HandReport, ImportError> {
    let adaptor = ViewAdaptor::new(calibration, &canonical_view(config));
    // The network predicts hands of these sides; others are shown to it in a mirror.
    let sides = [0, 1].map(|index| config.simulation.hands.side(index));
    let is_mirrored = !sides.contains(&options.side);
    let side = if is_mirrored { sides[0] } else { options.side };
    let mut report = HandReport { is_mirrored, scale: options.fit.scale, ..HandReport::default() };
    let view = HandView::new(config)?;
    let poses = match labels {
        HandLabels::Parameters(labels) => {
            let labels = select(labels, options.start, events, path, &mut report)?;
            // Parameters need no fit: they are labels already.
            progress(labels.len() as u64);
            let own = |label: HandParams| if is_mirrored { view.mirrored(&label) } else { label };
            let own =
                |hand: LabelledHand<HandParams>| LabelledHand { label: own(hand.label), ..hand };
            labels.into_iter().map(own).collect()
        }
        HandLabels::Joints(labels) => {
            let labels = select(labels, options.start, events, path, &mut report)?;
            let fitter = HandFitter::new(view, adaptor.clone(), side, is_mirrored, options.fit);
            fit_all(fitter, &labels, options, &mut report, progress)
        }
    };
    let times: Vec<Micros> = poses.iter().map(|label| label.t).collect();
    let mut parts: Vec<Range<usize>> = stretches(&times, options.max_gap);
    parts.retain(|part| times[part.end - 1] - times[part.start] >= options.min_length);
    report.labels = parts.iter().map(ExactSizeIterator::len).sum();
    report.isolated = poses.len() - report.labels;
    if parts.is_empty() {
        let reason = format!(
            "no labels over {} ms without a gap of more than {} ms: label more frames, or interpolate \
             over longer gaps (--max-gap-ms)",
            options.min_length.0 / 1000,
            options.max_gap.0 / 1000
        );
        return Err(ImportError::malformed(path, "time stamps", reason));
    }
    let seen = seen_by(adaptor, events, is_mirrored);
    let files =
        |name: &str, ending: &str| -> PathBuf { directory.join(format!("{name}.{ending}")) };
    let names: Vec<String> =
        (0..parts.len()).map(|index| name_of(name, index, parts.len())).collect();
    let format = EventFormat::of_hands(&config.simulation)?;
    // All names are checked before the first file is written.
    for name in names.iter().filter(|_| !options.replace) {
        if let Some(path) =
            [format.ending(), "evc", "meta"].iter().map(|e| files(name, e)).find(|p| p.exists())
        {
            return Err(ImportError::Exists { path });
        }
    }
    for (part, name) in parts.into_iter().zip(names) {
        let labels = &poses[part.clone()];
        // A frame has the pose of its end, and the first end must not lie before the first label.
        let start = ceil_ms(labels[0].t) - MS;
        let frames = (floor_ms(labels[labels.len() - 1].t) - start).0 / MS.0;
        let mut meta = MetaWriter::create_for_hands(files(&name, "meta"))?;
        let mut events = StepWriter::create(&directory.join(&name), format, seen.sensor())?;
        let end = start + Micros(frames * MS.0);
        let cut = cut(&seen, TimeWindow { start, end });
        for frame in 0..frames {
            let t = Micros(frame * MS.0);
            // Ends of frames lie between the first and the last label.
            let Some(pose) = pose_at(labels, start + t + MS) else { continue };
            meta.hand(&pose)?;
            events.step(&cut.slice(TimeWindow { start: t, end: t + MS }))?;
        }
        let info = SequenceInfo { hand: side, ..SequenceInfo::foreign(seen.sensor(), 0) };
        info.write(&directory.join(&name))?;
        meta.finish()?;
        // Readers look for events: where they are, the labels are there.
        events.finish()?;
        report.sequences.push(WrittenSequence { name, start, labels: part.len() });
    }
    Ok(report)
}

/// Labels within a recording, in its clock.
fn select<T: Copy>(
    labels: &[LabelledHand<T>],
    start: Micros,
    events: &EventStream,
    path: &Path,
    report: &mut HandReport,
) -> Result<Vec<LabelledHand<T>>, ImportError> {
    let times: Vec<Micros> = labels.iter().map(|label| label.t + start).collect();
    let range = within(&times, events, path)?;
    report.outside_recording = labels.len() - range.len();
    let own = |index: usize| LabelledHand { t: times[index], label: labels[index].label };
    Ok(range.map(own).collect())
}

/// Fits every label, each from the one before.
fn fit_all(
    mut fitter: HandFitter,
    labels: &[LabelledHand<HandJoints>],
    options: &HandOptions,
    report: &mut HandReport,
    progress: &mut dyn FnMut(u64),
) -> Vec<LabelledHand<HandParams>> {
    if options.fit_scale {
        // A fit of the size is slow, and the median of some labels is as good.
        let every = labels.len().div_ceil(SIZE_LABELS).max(1);
        let sampled = labels.iter().step_by(every);
        let mut scales: Vec<f64> =
            sampled.filter_map(|label| fitter.fit_scale(&label.label)).collect();
        scales.sort_by(f64::total_cmp);
        if let Some(median) = scales.get(scales.len() / 2) {
            report.scale = *median;
            fitter = fitter.with_scale(*median);
        }
    }
    let mut poses: Vec<LabelledHand<HandParams>> = Vec::with_capacity(labels.len());
    for label in labels {
        // The best first guess, unless the hand had time to go elsewhere.
        let before = poses.last().filter(|before| label.t - before.t <= options.max_gap);
        match fitter.fit(&label.label, before.map(|before| &before.label)) {
            Some(fitted) => {
                report.residuals.push((label.t, fitted));
                poses.push(LabelledHand { t: label.t, label: fitted.params });
            }
            None => report.incomplete += 1,
        }
        progress(1);
    }
    let poor = report.residuals.iter().filter(|(_, fitted)| fitter.is_poor(fitted));
    report.poor = poor.copied().collect();
    report.poor.sort_by(|(_, a), (_, b)| b.residual_px.total_cmp(&a.residual_px));
    poses
}

/// The events of a recording in the view of a network, or those of their mirror image.
fn seen_by(mut adaptor: ViewAdaptor, events: &EventStream, is_mirrored: bool) -> EventStream {
    let mut seen = EventStream::empty(adaptor.view().sensor);
    adaptor.push(events, &mut seen);
    if !is_mirrored {
        return seen;
    }
    let last = seen.sensor().width - 1;
    let mut mirrored = EventStream::empty(seen.sensor());
    for mut event in seen.iter() {
        event.x = last - event.x;
        // On the sensor and in order, as before.
        let _ = mirrored.push(event);
    }
    mirrored
}

/// The end of the millisecond of a time stamp, or the time stamp itself if it is the start of one.
fn ceil_ms(t: Micros) -> Micros {
    floor_ms(t + Micros(MS.0 - 1))
}
