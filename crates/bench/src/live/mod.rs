//! `evpose bench live`: how much comes through, and how late.

mod args;
mod memory;
mod recording;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_core::{EventStream, Micros, SensorSize};
use evpose_infer::Precision;
use evpose_live::sink::Sinks;
use evpose_live::source::{Replay, ReplayOptions, Source};
use evpose_pose::PoseEstimate;
use evpose_pose::stream::StreamFrontend;
use evpose_pose::stream::InferenceWorker;
use evpose_pose::stream::PoseStream;
use evpose_live::{Control, LiveError, LiveOptions, Report};
use evpose_nn::{HandRegressorConfig, MoveEnetConfig};
use evpose_task::body::{BodyCheckpoint, BodyConfig};
use evpose_task::hand::{HandConfig, NetworkPredictor};
use serde::Serialize;

pub(crate) use args::BenchLiveArgs;

use evpose_app::json::write_json;
use evpose_app::live_task::{AnyTask, LiveTask, TaskOptions};
use evpose_app::machine::Machine;
use evpose_app::progress::{note, say};
use evpose_app::run_info::COMMIT;
use evpose_app::threads::use_threads;
use memory::{Memory, Watched};

/// A recording that is played again and again.
const ENDLESS: u64 = u64::MAX;

/// What is written for programs.
#[derive(Debug, Serialize)]
struct Measured {
    machine: Machine,
    commit: &'static str,
    recording: String,
    sensor: SensorSize,
    /// Of the recording, by its own clock.
    events_per_s: f64,
    rows: Vec<Row>,
}

/// A row of the table.
#[derive(Debug, Serialize)]
struct Row {
    what: String,
    speed: f64,
    /// Events a second that were offered.
    offered_per_s: f64,
    report: Report,
    memory: Option<Memory>,
}

/// A recording and how to play it.
struct Bench<'a> {
    args: &'a BenchLiveArgs,
    path: PathBuf,
    sensor: SensorSize,
    events_per_s: f64,
}

pub(crate) fn run(args: &BenchLiveArgs) -> Result<()> {
    use_threads(args.device.threads)?;
    let machine = Machine::this();
    say(format!("machine    {machine}"));
    let folder = tempfile::tempdir().context("making a folder for the recording")?;
    let path = match &args.source {
        Some(path) => path.clone(),
        None => {
            note("making a recording");
            match args.task {
                LiveTask::Body => recording::of_body(folder.path(), args.rate)?,
                LiveTask::Hand => recording::of_hand(folder.path(), args.rate)?,
            }
        }
    };
    let bench = Bench::new(args, path)?;
    let name = bench.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    say(format!(
        "recording  {name}: {}, {:.2} M events/s",
        bench.sensor,
        1e-6 * bench.events_per_s
    ));
    let rows = match args.soak {
        Some(events) => vec![bench.soak(events)?],
        None => bench.table()?,
    };
    let measured = Measured {
        machine,
        commit: COMMIT,
        recording: name,
        sensor: bench.sensor,
        events_per_s: bench.events_per_s,
        rows,
    };
    write_json(args.json.as_deref(), &measured)
}

impl<'a> Bench<'a> {
    fn new(args: &'a BenchLiveArgs, path: PathBuf) -> Result<Self> {
        let info = evpose_io::info(&path, &evpose_io::OpenOptions::default())?;
        let rate = info.rate_hz().with_context(|| format!("{}: too short", path.display()))?;
        let sensor = Replay::open(&path, ReplayOptions::default())?.sensor();
        Ok(Self { args, path, sensor, events_per_s: rate })
    }

    fn table(&self) -> Result<Vec<Row>> {
        say(format!(
            "{:<28}{:>9}{:>9}{:>9}{:>10}{:>24}{:>10}{:>24}{:>9}",
            "",
            "offered",
            "followed",
            "dropped",
            "network",
            "p50 / 95 / 99 / max ms",
            "between",
            "p50 / 95 / 99 / max ms",
            "memory"
        ));
        say(format!(
            "{:<28}{:>9}{:>9}{:>9}{:>10}{:>24}{:>10}{:>24}{:>9}",
            "", "M ev/s", "M ev/s", "%", "poses/s", "", "poses/s", "", "MiB"
        ));
        let mut rows = Vec::new();
        for &millions in &self.args.input {
            let speed = 1e6 * millions / self.events_per_s;
            let task = || Ok(Task { eye: Nobody, network: Nobody });
            rows.push(self.row("input alone", speed, 0.0, task)?);
        }
        for &speed in &self.args.speeds {
            rows.push(self.row_of_task(&format!("all of it, {speed}x"), speed)?);
        }
        Ok(rows)
    }

    fn row_of_task(&self, what: &str, speed: f64) -> Result<Row> {
        let task = self.task()?;
        let propagate_hz = task.usual_between_hz();
        // So many a second of this machine's clock.
        let hz = propagate_hz / speed;
        match task {
            AnyTask::Body(task) => self.row(what, speed, hz, || Ok(*task)),
            AnyTask::Hand(task, _) => self.row(what, speed, hz, || Ok(*task)),
        }
    }

    fn row<E: StreamFrontend, N: InferenceWorker<Input = F::Input, Output = F::Output>>(
        &self,
        what: &str,
        speed: f64,
        propagate_hz: f64,
        task: impl FnOnce() -> Result<Task<E, N>>,
    ) -> Result<Row> {
        let task = task()?;
        let (report, memory) =
            self.play(task, speed, propagate_hz, |report| report.seconds >= self.args.seconds)?;
        let row = Row {
            what: what.to_owned(),
            speed,
            offered_per_s: speed * self.events_per_s,
            report,
            memory,
        };
        say(row.line());
        if row.report.slipped_us > 0 {
            let slipped_s = 1e-6 * row.report.slipped_us as f64;
            say(format!("{:<28}read {slipped_s:.1} s later than it was to be played", ""));
        }
        Ok(row)
    }

    /// Plays until `is_over`, and watches the memory.
    fn play<E: StreamFrontend, N: InferenceWorker<Input = F::Input, Output = F::Output>>(
        &self,
        task: Task<E, N>,
        speed: f64,
        propagate_hz: f64,
        is_over: impl Fn(&Report) -> bool + Sync,
    ) -> Result<(Report, Option<Memory>)> {
        let options = ReplayOptions {
            speed,
            times: ENDLESS,
            // Packets of a millisecond of this machine's clock.
            packet: Micros(if speed.is_finite() {
                (1e3 * speed).round().max(1.0) as i64
            } else {
                1_000
            }),
            ..ReplayOptions::default()
        };
        let source = Replay::open(&self.path, options)?;
        let control = Control::default();
        let live = LiveOptions {
            propagate_hz,
            stride: Micros((1e3 * speed.min(1e3)).round().max(1.0) as i64),
            most_events: 1 << 23,
            ..LiveOptions::default()
        };
        let watched = std::thread::scope(|scope| {
            let watcher = scope.spawn(|| {
                let mut watched = Watched::default();
                while !control.is_stopped() {
                    std::thread::sleep(Duration::from_millis(50));
                    let report = control.meter.report();
                    watched.infer(report.events);
                    if is_over(&report) {
                        control.stop();
                    }
                }
                watched
            });
            let ran = evpose_live::run(source, task, &mut Sinks::new(), &live, &control);
            control.stop();
            let watched = watcher.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            ran.map(|report| (report, watched))
        });
        let (report, watched) = watched?;
        Ok((report, watched.memory()))
    }

    /// Many events, as fast as they are followed.
    fn soak(&self, events: f64) -> Result<Row> {
        let task = self.task()?;
        note(format!("{events:.0} events, as fast as they come"));
        let is_over = |report: &Report| report.events as f64 >= events;
        let (report, memory) = match task {
            AnyTask::Body(task) => self.play(*task, f64::INFINITY, 500.0, is_over)?,
            AnyTask::Hand(task, _) => self.play(*task, f64::INFINITY, 1_000.0, is_over)?,
        };
        let row = Row {
            what: "soak".to_owned(),
            speed: f64::INFINITY,
            offered_per_s: report.per_second(report.events),
            report,
            memory,
        };
        say(format!(
            "{} events in {:.1} s, {:.1} M events/s; {:.1} M/s followed, the others dropped",
            report.events,
            report.seconds,
            1e-6 * report.per_second(report.events),
            1e-6 * report.per_second(report.followed)
        ));
        if let Some(memory) = &row.memory {
            say(format!(
                "memory: {:.1} MiB after a tenth of the events, {:.1} MiB at most from then on, {:.1} MiB at the end",
                memory.settled_mib, memory.most_mib, memory.end_mib
            ));
        }
        Ok(row)
    }

    fn task(&self) -> Result<AnyTask> {
        let options = TaskOptions {
            precision: Precision::F32,
            device: &self.args.device,
            batch: None,
            confidence: 0.01,
        };
        if let Some(checkpoint) = &self.args.checkpoint {
            return AnyTask::load(checkpoint, None, self.sensor, &options);
        }
        self.published(&options)
    }

    /// The network of the published size, with random weights: it takes as long as any.
    fn published(&self, options: &TaskOptions<'_>) -> Result<AnyTask> {
        let device = Device::flex();
        match self.args.task {
            LiveTask::Body => {
                let network = MoveEnetConfig::default().init(1, &device)?;
                let config = BodyConfig::default();
                let checkpoint = BodyCheckpoint { config, network, mean_pose: None, data: None };
                AnyTask::of_body(&checkpoint, self.sensor, options)
            }
            LiveTask::Hand => {
                let network = HandRegressorConfig::default().init(1, &device)?;
                let predictor = NetworkPredictor::new(network, device);
                AnyTask::of_hand(&HandConfig::default(), predictor, self.sensor, options)
            }
        }
    }
}

impl Row {
    fn line(&self) -> String {
        let report = &self.report;
        // Packets that are on their way when the time is up are not lost.
        let percent = 100.0 * report.dropped_events as f64 / report.events.max(1) as f64;
        let latency = |l: &evpose_live::Latency| match l.poses {
            0 => "-".to_owned(),
            _ => format!("{:.1} / {:.1} / {:.1} / {:.1}", l.p50_ms, l.p95_ms, l.p99_ms, l.max_ms),
        };
        format!(
            "{:<28}{:>9.1}{:>9.1}{:>9.2}{:>10.0}{:>24}{:>10.0}{:>24}{:>9}",
            self.what,
            1e-6 * self.offered_per_s,
            1e-6 * report.per_second(report.followed),
            percent,
            report.per_second(report.network.poses),
            latency(&report.network),
            report.per_second(report.between.poses),
            latency(&report.between),
            self.memory.as_ref().map_or_else(|| "-".to_owned(), |m| format!("{:.0}", m.most_mib)),
        )
    }
}

/// Follows nothing: what is left is the way to it.
struct Nobody;

impl StreamFrontend for Nobody {
    type Input = ();
    type Output = ();

    fn push(&mut self, _: &EventStream) -> Result<(), LiveError> {
        Ok(())
    }

    fn image(&mut self, _: Micros, _: Option<()>) -> Option<()> {
        None
    }

    fn found(&mut self, _: Micros, (): &(), (): (), _: Micros) -> Vec<(Micros, PoseEstimate)> {
        Vec::new()
    }

    fn propagate(&mut self, _: Micros) -> Option<PoseEstimate> {
        None
    }

    fn reset(&mut self) {}
}

impl InferenceWorker for Nobody {
    type Input = ();
    type Output = ();

    fn infer(&mut self, (): &()) -> Result<(), LiveError> {
        Ok(())
    }
}
