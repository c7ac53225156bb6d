//! `evpose bench live`: throughput and latency of the online pipeline.

mod args;
mod memory;
mod no_task;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result};
use evpose_core::{Micros, SensorSize};
use evpose_live::sink::Sinks;
use evpose_live::source::{Replay, ReplayOptions, Source};
use evpose_live::{Control, LiveOptions, Report};
use serde::Serialize;

pub(crate) use args::BenchLiveArgs;

use evpose_cli::args::DeviceArgs;
use evpose_cli::json::write_json;
use evpose_cli::progress::{note, say};
use evpose_cli::provenance::Provenance;
use evpose_cli::tasks::TaskArgs;
use evpose_cli::tasks::online::OnlineStream;
use memory::{Memory, MemorySamples};
use no_task::no_task;

/// Minimum score of a joint, as of the published online program.
const MIN_CONFIDENCE: f32 = 0.01;
/// Repetitions of an endless replay.
const ENDLESS: u64 = u64::MAX;

/// Results, as written to JSON.
#[derive(Debug, Serialize)]
struct Measured {
    #[serde(flatten)]
    provenance: Provenance,
    recording: String,
    sensor: SensorSize,
    /// Event rate of the recording in event time.
    events_per_s: f64,
    rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    name: String,
    speed: f64,
    /// Events per second of host time at the playback speed.
    offered_per_s: f64,
    report: Report,
    memory: Option<Memory>,
}

/// A recording and the options of its measurements.
struct Bench<'a> {
    args: &'a BenchLiveArgs,
    path: PathBuf,
    sensor: SensorSize,
    events_per_s: f64,
}

pub(crate) fn run(args: &BenchLiveArgs) -> Result<()> {
    // First: a device that cannot be used is reported before a recording is made.
    args.device.open()?;
    let provenance = Provenance::this();
    say(format!("machine    {}", provenance.machine));
    let folder = tempfile::tempdir().context("making a folder for the recording")?;
    let path = match &args.source {
        Some(path) => path.clone(),
        None => {
            note("making a recording");
            evpose_cli::tasks::task_by_name(&args.task)?
                .studied()?
                .benchmark_recording(folder.path(), args.rate)?
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
        provenance,
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
            "processed",
            "dropped",
            "network",
            "p50 / 95 / 99 / max ms",
            "propagated",
            "p50 / 95 / 99 / max ms",
            "memory"
        ));
        say(format!(
            "{:<28}{:>9}{:>9}{:>9}{:>10}{:>24}{:>10}{:>24}{:>9}",
            "", "M ev/s", "M ev/s", "%", "poses/s", "", "poses/s", "", "MiB"
        ));
        let mut rows = Vec::new();
        for &millions in &self.args.input {
            // Speed that offers this many million events per second.
            let speed = 1e6 * millions / self.events_per_s;
            // Without a network: what the input alone can do.
            rows.push(self.row("input alone", speed, 0.0, no_task())?);
        }
        for &speed in &self.args.speeds {
            rows.push(self.task_row(&format!("whole pipeline, {speed}x"), speed)?);
        }
        Ok(rows)
    }

    fn task_row(&self, label: &str, speed: f64) -> Result<Row> {
        let stream = self.stream()?;
        // Propagated poses per second of this machine's clock.
        let propagate_hz = stream.propagate_hz() / speed;
        self.row(label, speed, propagate_hz, stream)
    }

    fn row(
        &self,
        name: &str,
        speed: f64,
        propagate_hz: f64,
        stream: Box<dyn OnlineStream>,
    ) -> Result<Row> {
        let (report, memory) =
            self.play(stream, speed, propagate_hz, |report| report.seconds >= self.args.seconds)?;
        let row = Row {
            name: name.to_owned(),
            speed,
            offered_per_s: speed * self.events_per_s,
            report,
            memory,
        };
        say(row.line());
        // The clock of a replay that is set back offers fewer events than the row says.
        if row.report.slipped_us > 0 {
            let slipped_s = 1e-6 * row.report.slipped_us as f64;
            say(format!(
                "{:<28}replay clock set back by {slipped_s:.1} s: the recording could not be read in time",
                ""
            ));
        }
        Ok(row)
    }

    /// Plays until `is_over`, and samples the memory.
    fn play(
        &self,
        stream: Box<dyn OnlineStream>,
        speed: f64,
        propagate_hz: f64,
        is_over: impl Fn(&Report) -> bool + Sync,
    ) -> Result<(Report, Option<Memory>)> {
        let options = ReplayOptions {
            speed,
            times: ENDLESS,
            is_real_time: true,
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
            // Strides grow with the speed, so that inputs per second of host time stay the same.
            stride: Micros((1e3 * speed.min(1e3)).round().max(1.0) as i64),
            max_events: 1 << 23,
            ..LiveOptions::default()
        };
        let samples = std::thread::scope(|scope| {
            let sampler = scope.spawn(|| {
                let mut samples = MemorySamples::default();
                while !control.is_stopped() {
                    std::thread::sleep(Duration::from_millis(50));
                    let report = control.meter.report();
                    samples.sample(report.events);
                    if is_over(&report) {
                        control.stop();
                    }
                }
                samples
            });
            let ran = stream.run(Box::new(source), &mut Sinks::new(), &live, &control);
            // The scope waits for the sampler, which would never end after an error.
            control.stop();
            let samples = sampler.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            ran.map(|report| (report, samples))
        });
        let (report, samples) = samples?;
        Ok((report, samples.memory()))
    }

    /// Plays many events, as fast as they are processed.
    fn soak(&self, events: f64) -> Result<Row> {
        let stream = self.stream()?;
        note(format!("{events:.0} events, as fast as possible"));
        let is_over = |report: &Report| report.events as f64 >= events;
        let propagate_hz = stream.propagate_hz();
        let (report, memory) = self.play(stream, f64::INFINITY, propagate_hz, is_over)?;
        let row = Row {
            name: "soak".to_owned(),
            speed: f64::INFINITY,
            // As fast as possible, so that what was read is what was offered.
            offered_per_s: report.per_second(report.events),
            report,
            memory,
        };
        say(format!(
            "{} events in {:.1} s, {:.1} M events/s; {:.1} M/s processed, the others dropped",
            report.events,
            report.seconds,
            1e-6 * report.per_second(report.events),
            1e-6 * report.per_second(report.followed)
        ));
        if let Some(memory) = &row.memory {
            say(format!(
                "memory: {:.1} MiB after a tenth of the events, {:.1} MiB at most from then on, {:.1} MiB at the end",
                memory.settled_mib, memory.max_mib, memory.end_mib
            ));
        }
        Ok(row)
    }

    /// The stream of the checkpoint, or of the published size with random weights: it takes as long
    /// as any.
    fn stream(&self) -> Result<Box<dyn OnlineStream>> {
        // The thread pool is running.
        let device = DeviceArgs { threads: None, ..self.args.device };
        let model = match &self.args.checkpoint {
            Some(checkpoint) => evpose_cli::tasks::open(checkpoint, &device)?,
            None => {
                let task = evpose_cli::tasks::task_by_name(&self.args.task)?;
                task.studied()?.published(&device.open()?)?
            }
        };
        // People of random weights are found as often as those of trained ones.
        let confidence = MIN_CONFIDENCE.to_string();
        let own: &[&str] =
            if model.task() == "body" { &["--confidence", &confidence] } else { &[] };
        model.stream(self.sensor, &TaskArgs::parse(own.iter().copied())?)
    }
}

impl Row {
    fn line(&self) -> String {
        let report = &self.report;
        // Packets that are on their way when the time is up are not lost.
        let percent = 100.0 * report.dropped_events as f64 / report.events.max(1) as f64;
        let latency = |l: &evpose_live::LatencySummary| match l.poses {
            0 => "-".to_owned(),
            _ => format!("{:.1} / {:.1} / {:.1} / {:.1}", l.p50_ms, l.p95_ms, l.p99_ms, l.max_ms),
        };
        format!(
            "{:<28}{:>9.1}{:>9.1}{:>9.2}{:>10.0}{:>24}{:>10.0}{:>24}{:>9}",
            self.name,
            1e-6 * self.offered_per_s,
            1e-6 * report.per_second(report.followed),
            percent,
            report.per_second(report.network.poses),
            latency(&report.network),
            report.per_second(report.propagated.poses),
            latency(&report.propagated),
            self.memory.as_ref().map_or_else(|| "-".to_owned(), |m| format!("{:.0}", m.max_mib)),
        )
    }
}
