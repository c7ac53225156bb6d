//! What tasks share whose poses are the values of a [`PoseLayout`], and whose data sets are recordings with
//! tables of poses.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use evpose_core::stats::bootstrap::Totals;
use evpose_core::{Micros, SensorSize};
use evpose_io::poses::{PoseKind, TimedPose, read_poses, write_poses_from};
use evpose_io::{OpenOptions, Windows};
use evpose_pose::stream::{InferenceSchedule, InferenceWorker, PoseStream, StreamFrontend};
use evpose_pose::{PoseLayout, PoseOrigin};
use evpose_sim::{SequenceSet, Shard};
use evpose_task::{RecordingStream, TaskConfig};
use evpose_train::body::BodyRecordings;
use glam::Vec2;

use super::args::{EvalArgs, InferArgs, SimulateArgs};
use super::infer_all;
use super::opening::OpeningArgs;
use crate::json::write_json;
use crate::progress::{bar, say};
use crate::recorded::claim;

/// Share of the recordings that are for validation.
const VALIDATION: f64 = 0.2;

/// Inputs of a network, each with the values at its time.
pub type Samples<I> = Vec<(I, Vec<f32>)>;

/// Records the sequences of `set` that are missing, each by `record`.
///
/// # Errors
/// If the directory is of another config, or a sequence cannot be recorded.
pub fn record_values(
    args: &SimulateArgs,
    config: &impl TaskConfig,
    set: &SequenceSet,
    record: impl Fn(u64) -> Result<()>,
) -> Result<()> {
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    claim(set, config, shard, args.resume)?;
    let unfinished = set.unfinished(shard);
    let progress = bar("simulating", unfinished.len() as u64, "sequences");
    for &sequence in &unfinished {
        record(sequence)?;
        set.seal(sequence)?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    set.write_manifest()?;
    say(format!("{} sequences: {}", unfinished.len(), args.out.display()));
    Ok(())
}

/// The values in a table of poses of `layout`, where they are known.
fn read_values(path: &Path, layout: &'static PoseLayout) -> Result<BTreeMap<Micros, Vec<f32>>> {
    let sequence = read_poses(path)?;
    let is_ours = sequence.kind == PoseKind::Values(layout);
    ensure!(is_ours, "{}: not poses of `{}`", path.display(), layout.name);
    Ok(sequence.poses.into_iter().filter_map(|pose| Some((pose.t, pose.values?))).collect())
}

/// What a network learns from in the directory `data`, by recordings in the order of their names: inputs so
/// often, from the first such time on, with the values of `layout` at their times. The second part is for
/// validation. Inputs are those of `stream`, which before a sensor is that of inference.
///
/// # Errors
/// If the data cannot be read, or a part is empty.
pub fn read_samples<F, W>(
    data: &Path,
    layout: &'static PoseLayout,
    every: Micros,
    stream: impl Fn(SensorSize) -> Result<PoseStream<F, W>>,
) -> Result<[Samples<F::Input>; 2]>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    let files = BodyRecordings::open(data)?.files;
    let learnt = files.len() - (VALIDATION * files.len() as f64).ceil() as usize;
    let mut parts = [Vec::new(), Vec::new()];
    for (index, (events, table)) in files.iter().enumerate() {
        let windows = Windows::open(events, &OpenOptions::default())?;
        let stream = stream(windows.sensor())?;
        let mut recording = RecordingStream::new(windows, stream, InferenceSchedule::Every(every));
        let at_times = read_values(table, layout)?.into_iter();
        for (t, values) in at_times.filter(|(t, _)| t.0 > 0 && t.0 % every.0 == 0) {
            recording.advance(t)?;
            let input = recording.stream().frontend.input(t, None);
            parts[usize::from(index >= learnt)].extend(input.map(|input| (input, values)));
        }
    }
    let too_few = || format!("{}: too few recordings to train and validate", data.display());
    ensure!(parts.iter().all(|part| !part.is_empty()), too_few());
    Ok(parts)
}

/// The mean of the values of samples.
///
/// # Panics
/// If one has fewer values.
pub fn mean_values<I, const N: usize>(samples: &Samples<I>) -> [f32; N] {
    let sum = |k: usize| samples.iter().map(|(_, values)| f64::from(values[k])).sum::<f64>();
    std::array::from_fn(|k| (sum(k) / samples.len() as f64) as f32)
}

/// The poses of the recording `path`, `every` so often, as every command has them.
fn infer_values<F, W>(
    path: &Path,
    (opening, every): (&OpeningArgs, Micros),
    stream: &impl Fn(SensorSize) -> Result<PoseStream<F, W>>,
) -> Result<Vec<TimedPose>>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    let windows = Windows::open(path, &opening.options_with_sensor(path)?)?;
    let stream = stream(windows.sensor())?;
    let mut recording = RecordingStream::new(windows, stream, InferenceSchedule::Every(every));
    let span = recording.span()?.with_context(|| format!("{}: no events", path.display()))?;
    let mut poses = Vec::new();
    infer_all(&mut recording, path, span, |frontend, inferred| {
        poses.extend(inferred.poses.iter().map(|(t, pose)| TimedPose {
            origin: Some(PoseOrigin::Network),
            ..TimedPose::new(*t, &frontend.estimate(pose))
        }));
    })?;
    Ok(poses)
}

/// The time between poses: of `--stride-ms`, or else `every`.
fn stride(stride_ms: Option<u32>, every: Micros) -> Micros {
    stride_ms.map_or(every, |ms| Micros(1_000 * i64::from(ms.max(1))))
}

/// Runs `evpose infer` with the poses of `stream`, by default `every` so often.
///
/// # Errors
/// If the recording cannot be read, the network fails, or the file cannot be written.
pub fn write_values<F, W>(
    args: &InferArgs,
    layout: &'static PoseLayout,
    every: Micros,
    stream: impl Fn(SensorSize) -> Result<PoseStream<F, W>>,
) -> Result<()>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    args.refuse_others(layout.name)?;
    let every = stride(args.stride_ms, every);
    let poses = infer_values(args.recording()?, (&args.opening, every), &stream)?;
    let count = poses.len();
    let kind = PoseKind::Values(layout);
    write_poses_from(&args.out, kind, None, &mut poses.into_iter(), args.format)?;
    say(format!("{count} poses: {}", args.out.display()));
    Ok(())
}

/// Runs `evpose eval`: the poses that [`write_values`] writes of each recording against the table beside it,
/// linear between its rows, and the constant `mean` in their place. Errors are distances of points, and differences of other values.
///
/// # Errors
/// If the data cannot be read, or a recording not be inferred.
pub fn evaluate_values<F, W>(
    args: &EvalArgs,
    layout: &'static PoseLayout,
    mean: &[f32],
    every: Micros,
    stream: impl Fn(SensorSize) -> Result<PoseStream<F, W>>,
) -> Result<()>
where
    F: StreamFrontend,
    W: InferenceWorker<Input = F::Input, Output = F::Output>,
{
    args.refuse_others(layout.name)?;
    let every = stride(args.stride_ms, every);
    let data = args.data.as_deref().context("--data, a directory of recordings, is missing")?;
    let mut errors = [BTreeMap::<String, Totals>::new(), BTreeMap::new()];
    for (events, table) in BodyRecordings::open(data)?.files {
        let truth = read_values(&table, layout)?;
        for pose in infer_values(&events, (&OpeningArgs::default(), every), &stream)? {
            let known = pose.values.as_ref().zip(values_at(&truth, pose.t));
            let Some((values, truth)) = known else { continue };
            for (errors, values) in errors.iter_mut().zip([&values[..], mean]) {
                push_errors(errors, layout, values, &truth);
            }
        }
    }
    let [network, constant] = errors.map(|errors| -> BTreeMap<String, Option<f64>> {
        errors.into_iter().map(|(name, totals)| (name, totals.mean())).collect()
    });
    ensure!(!network.is_empty(), "{}: no pose at a time with labels", data.display());
    let means = BTreeMap::from([("network", network), ("mean pose", constant)]);
    for (method, means) in &means {
        let cell = |(name, mean): (&String, &Option<f64>)| {
            format!("  {name} {:.2}", mean.unwrap_or(f64::NAN))
        };
        say(format!("{method:<10}{}", means.iter().map(cell).collect::<String>()));
    }
    write_json(args.json.as_deref(), &means)
}

/// The values at `t`, between those of the labels before and behind; none outside of them.
fn values_at(labels: &BTreeMap<Micros, Vec<f32>>, t: Micros) -> Option<Vec<f32>> {
    let (before, from) = labels.range(..=t).next_back()?;
    let (behind, to) = labels.range(t..).next()?;
    let part = (t - *before).0 as f32 / (*behind - *before).0.max(1) as f32;
    Some(from.iter().zip(to).map(|(from, to)| from + part * (to - from)).collect())
}

/// Adds the errors of a pose: `NAME_px` of a point, and of any other value under its own name.
fn push_errors(
    errors: &mut BTreeMap<String, Totals>,
    layout: &'static PoseLayout,
    values: &[f32],
    truth: &[f32],
) {
    let points: Vec<_> = layout.points().collect();
    for (index, name) in layout.values.iter().enumerate() {
        let (name, error) = if let Some((point, _)) = points.iter().find(|(_, at)| *at == index) {
            let at = |values: &[f32]| Vec2::new(values[index], values[index + 1]);
            (format!("{point}_px"), at(values).distance(at(truth)))
        } else if points.iter().any(|(_, at)| at + 1 == index) {
            continue;
        } else {
            ((*name).to_owned(), (values[index] - truth[index]).abs())
        };
        errors.entry(name).or_default().push(f64::from(error));
    }
}
