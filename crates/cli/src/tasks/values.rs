//! Tasks whose poses are the values of a [`PoseLayout`], and whose data sets are recordings with tables of
//! poses: a [`ValueModel`] has samples, `evpose infer`, `evpose eval` and `evpose live`.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use evpose_core::stats::bootstrap::Totals;
use evpose_core::{Micros, SensorSize};
use evpose_io::poses::{PoseKind, read_poses};
use evpose_io::{OpenOptions, Windows};
use evpose_live::page::Skeleton;
use evpose_pose::PoseLayout;
use evpose_pose::stream::{InferenceSchedule, InferenceWorker, PoseStream, StreamFrontend};
use evpose_sim::{SequenceSet, Shard};
use evpose_task::{Experiment, RecordingStream};
use evpose_train::body::BodyRecordings;
use glam::Vec2;

use super::args::{EvalArgs, InferArgs, OneRecordingArgs, SimulateArgs};
use super::infer_all::{infer_rows, write_rows};
use super::online::{OnlineStream, TaskStream};
use super::opening::OpeningArgs;
use super::own_args::{Live, NoArgs, TaskArgs};
use crate::json::write_json;
use crate::progress::{bar, say};
use crate::recorded::claim;

/// Share of the recordings that are for validation.
const VALIDATION: f64 = 0.2;

/// Inputs of a network, each with the values at its time.
pub type Samples<I> = Vec<(I, Vec<f32>)>;

/// Runs `evpose simulate` of a config to which its arguments were applied: `record` makes a sequence.
///
/// # Errors
/// If the directory is of another config, or a sequence cannot be recorded.
pub fn record_values<C: Experiment>(
    args: &SimulateArgs,
    config: &C,
    set: &SequenceSet,
    record: impl Fn(u64) -> Result<()>,
) -> Result<()> {
    let NoArgs {} = args.own.of(C::TASK)?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    claim(set, config, shard, args.resume)?;
    let unfinished = set.unfinished(shard);
    let progress = bar("simulating", unfinished.len() as u64, "sequences");
    for &sequence in &unfinished {
        record(sequence)?;
        // Sequences are sealed one by one, so that a killed run repeats only the one it was at.
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

/// The mean of the values of samples.
///
/// # Panics
/// If one has fewer values.
pub fn mean_values<I, const N: usize>(samples: &Samples<I>) -> [f32; N] {
    let sum = |k: usize| samples.iter().map(|(_, values)| f64::from(values[k])).sum::<f64>();
    std::array::from_fn(|k| (sum(k) / samples.len() as f64) as f32)
}

/// A model whose poses are values.
pub trait ValueModel {
    /// Follows events.
    type Frontend: StreamFrontend + 'static;
    /// Infers.
    type Worker: InferenceWorker<
            Input = <Self::Frontend as StreamFrontend>::Input,
            Output = <Self::Frontend as StreamFrontend>::Output,
        > + 'static;

    /// Names and units of the values of a pose.
    fn layout(&self) -> &'static PoseLayout;

    /// Time between inputs, unless the user says otherwise.
    fn every(&self) -> Micros;

    /// The stream before a sensor.
    ///
    /// # Errors
    /// If the network does not suit it.
    fn open_stream(&self, sensor: SensorSize) -> Result<PoseStream<Self::Frontend, Self::Worker>>;

    /// The stream of a recording, with an input `every` so often.
    ///
    /// # Errors
    /// If it cannot be read, or the network does not suit its sensor.
    fn open_recording(
        &self,
        path: &Path,
        every: Micros,
        options: &OpenOptions,
    ) -> Result<RecordingStream<Self::Frontend, Self::Worker>> {
        let windows = Windows::open(path, options)?;
        let stream = self.open_stream(windows.sensor())?;
        Ok(RecordingStream::new(windows, stream, InferenceSchedule::Every(every)))
    }

    /// Inputs with the values at their times, of the recordings in the directory `data` by their names. The
    /// second part is for validation.
    ///
    /// # Errors
    /// If the data cannot be read, or a part is empty.
    fn samples(
        &self,
        data: &Path,
    ) -> Result<[Samples<<Self::Frontend as StreamFrontend>::Input>; 2]> {
        let (files, every) = (BodyRecordings::open(data)?.files, self.every());
        let learnt = files.len() - (VALIDATION * files.len() as f64).ceil() as usize;
        let mut parts = [Vec::new(), Vec::new()];
        for (index, (events, table)) in files.iter().enumerate() {
            let mut recording = self.open_recording(events, every, &OpenOptions::default())?;
            let at_times = read_values(table, self.layout())?.into_iter();
            // What is learnt is what is scored: the times at which `infer` has an input.
            for (t, values) in at_times.filter(|(t, _)| t.0 > 0 && t.0 % every.0 == 0) {
                recording.advance(t)?;
                let input = recording.stream().frontend.input(t, None);
                parts[usize::from(index >= learnt)].extend(input.map(|input| (input, values)));
            }
        }
        let is_whole = parts.iter().all(|part| !part.is_empty());
        ensure!(is_whole, "{}: too few recordings to train and validate", data.display());
        Ok(parts)
    }

    /// The stream of the recording `path`, as every command has it.
    ///
    /// # Errors
    /// As [`Self::open_recording`].
    fn open_values(
        &self,
        path: &Path,
        stride_ms: Option<u32>,
        opening: &OpeningArgs,
    ) -> Result<RecordingStream<Self::Frontend, Self::Worker>> {
        let every = stride_ms.map_or(self.every(), |ms| Micros(1_000 * i64::from(ms.max(1))));
        self.open_recording(path, every, &opening.options_with_sensor(path)?)
    }

    /// Runs `evpose infer`.
    ///
    /// # Errors
    /// If the recording cannot be inferred, or the file not be written.
    fn write_values(&self, args: &InferArgs) -> Result<()> {
        let own: OneRecordingArgs = args.own.of(self.layout().name)?;
        let mut recording = self.open_values(&own.events, args.stride_ms, &args.opening)?;
        write_rows(&mut recording, PoseKind::Values(self.layout()), args, &own)
    }

    /// Runs `evpose eval`: the poses that [`Self::write_values`] writes of each recording against the table
    /// beside it, linear between its rows, and the constant `mean` in their place. Errors are distances of
    /// points, and differences of other values.
    ///
    /// # Errors
    /// If the data cannot be read, or a recording not be inferred.
    fn evaluate_values(&self, args: &EvalArgs, mean: &[f32]) -> Result<()> {
        let layout = self.layout();
        let NoArgs {} = args.own.of(layout.name)?;
        let data = args.data.as_deref().context("--data, a directory of recordings, is missing")?;
        let mut errors = [BTreeMap::<String, Totals>::new(), BTreeMap::new()];
        for (events, table) in BodyRecordings::open(data)?.files {
            let truth = read_values(&table, layout)?;
            let mut recording =
                self.open_values(&events, args.stride_ms, &OpeningArgs::default())?;
            let kind = PoseKind::Values(layout);
            for pose in infer_rows(&mut recording, &events, kind, |_| None)?.0 {
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

    /// The stream for `evpose live`, its poses as they are inferred.
    ///
    /// # Errors
    /// As [`Self::open_stream`], or if an option is for another task.
    fn stream_values(
        &self,
        sensor: SensorSize,
        args: &TaskArgs<Live>,
    ) -> Result<Box<dyn OnlineStream>> {
        let NoArgs {} = args.of(self.layout().name)?;
        let skeleton = Skeleton::Points(self.layout());
        Ok(Box::new(TaskStream::new(self.open_stream(sensor)?, 0.0, skeleton)))
    }
}

/// The values at `t`, between those of the labels before and behind; none outside of them.
fn values_at(labels: &BTreeMap<Micros, Vec<f32>>, t: Micros) -> Option<Vec<f32>> {
    let (before, from) = labels.range(..=t).next_back()?;
    let (behind, to) = labels.range(t..).next()?;
    // At a label, both are the same one: 0 / 1 leaves its values.
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
            // The second coordinate of a point was counted with its first.
            continue;
        } else {
            ((*name).to_owned(), (values[index] - truth[index]).abs())
        };
        errors.entry(name).or_default().push(f64::from(error));
    }
}
