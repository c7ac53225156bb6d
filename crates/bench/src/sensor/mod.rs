//! `evpose bench sensor`: what a step costs per pixel, beside other simulators.

mod peer;
mod scene;

use std::time::Instant;

use anyhow::{Context, Result};
use evpose_core::{Micros, Plane};
use evpose_io::frames::write_codes;
use evpose_sensor::{SensorConfig, SensorModel};
use serde::Serialize;

use crate::all::{Figure, threads};
use evpose_cli::json::write_json;
use evpose_cli::machine::Machine;
use evpose_cli::outputs::OutputFile;
use evpose_cli::progress::say;
use evpose_cli::provenance::Provenance;
use evpose_cli::ranges::{seconds, within};
use evpose_cli::threads::sensor_threads;
use evpose_core::stats::quantile::{nearest_rank, outlier_count};
use peer::Peer;

#[derive(Debug, clap::Args)]
#[command(
    after_help = "A peer is a program that is started once for each setting. In its words, which \
    spaces divide,\n  {frames}   is an .npy file of u1 (frames, height, width), to be shown over and \
    over,\n  {fps}      the frames per second,\n  {setting}  `thresholds` (thresholds that differ \
    from pixel to pixel) or `all`\n             (and low-pass, leak, shot noise and a refractory \
    period),\n  {seconds}  for how long to measure.\n\
    It prints its nanoseconds per pixel and step, on one core, as its last line.\n\n\
    Examples:\n  evpose bench sensor\n  \
    evpose bench sensor --json sensor.json --peer \"other=./other {frames} {fps} {setting}\""
)]
/// Arguments of `evpose bench sensor`.
pub struct BenchSensorArgs {
    /// Seconds for each setting and peer
    #[arg(long, default_value_t = 3.0, value_parser = seconds())]
    pub(crate) seconds: f64,
    /// Threads of a second measurement of each setting, none with 1 [default: two, where there are]
    #[arg(long, value_parser = within(1..=1024_u32))]
    pub(crate) threads: Option<u32>,
    /// Another simulator to be timed on the same frames (may be repeated)
    #[arg(long, value_name = "NAME=COMMAND")]
    pub(crate) peer: Vec<String>,
    /// Where to write the results as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
}

/// Content of the JSON file.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    sensor: String,
    frames: usize,
    fps: u32,
    settings: Vec<Measured>,
}

/// One chain and its peers. Times are per pixel and step.
#[derive(Debug, Serialize)]
struct Measured {
    setting: &'static str,
    effects: Vec<String>,
    passes: usize,
    min_ns: f64,
    median_ns: f64,
    p90_ns: f64,
    outliers: usize,
    events_per_pixel_step: f64,
    events_per_second: f64,
    peers: Vec<PeerTime>,
    /// The same on several threads, if there are.
    parallel: Option<ParallelTime>,
}

/// Times of one sensor on several threads.
#[derive(Debug, Serialize)]
struct ParallelTime {
    threads: usize,
    min_ns: f64,
    median_ns: f64,
}

#[derive(Debug, Serialize)]
struct PeerTime {
    name: String,
    ns: f64,
    ratio: f64,
}

pub(crate) fn run(args: &BenchSensorArgs) -> Result<()> {
    write_json(args.json.as_deref(), &measure_all(args)?)
}

pub(crate) fn figures(args: &BenchSensorArgs) -> Result<Vec<Figure>> {
    let figures_of = |measured: &Measured| {
        let of = |work: &str, ns| Figure::time("sensor", work, "ns/pixel/step", ns);
        let alone = of(measured.setting, measured.median_ns);
        let alone =
            measured.peers.iter().fold(alone, |figure, peer| figure.beside(&peer.name, peer.ns));
        let parallel = measured.parallel.as_ref().map(|parallel| {
            let work = format!("{}, {}", measured.setting, threads(parallel.threads));
            of(&work, parallel.median_ns)
        });
        std::iter::once(alone).chain(parallel)
    };
    Ok(measure_all(args)?.settings.iter().flat_map(figures_of).collect())
}

fn measure_all(args: &BenchSensorArgs) -> Result<Report> {
    // A mistake in --peer is reported before minutes of measurements.
    let peers = args.peer.iter().map(|text| Peer::parse(text)).collect::<Result<Vec<_>>>()?;
    let frames = scene::frames();
    let worth = sensor_threads(scene::SIZE);
    let most = args.threads.map_or(worth, |threads| threads as usize);
    // One step is one pass of one thread, whatever the machine has.
    let mut report = Report {
        provenance: Provenance::new(Machine { threads: 1, ..Machine::this() }),
        sensor: scene::SIZE.to_string(),
        frames: scene::FRAMES,
        fps: scene::FPS,
        settings: Vec::new(),
    };
    say(format!("machine   {}", report.provenance.machine));
    say(format!(
        "frames    {} of {} at {} fps, 8 bit, in memory",
        report.frames, report.sensor, report.fps
    ));
    let folder = tempfile::tempdir().context("making a folder for the frames of peers")?;
    let file = folder.path().join("frames.npy");
    // Peers get the code values that our frames were made of.
    let codes: Vec<Vec<u8>> = (0..scene::FRAMES).map(scene::codes).collect();
    write_codes(&file, scene::SIZE, &codes)?;
    for (setting, config) in [("thresholds", scene::thresholds()), ("all", scene::all())] {
        let mut measured = measure(setting, &config, &frames, args.seconds)?;
        measured.say();
        for peer in &peers {
            let ns = peer.measure(&file, scene::FPS, setting, args.seconds)?;
            let ratio = ns / measured.median_ns;
            say(format!("  {:18} {ns:8.2} ns: {ratio:.1} times ours", peer.name));
            measured.peers.push(PeerTime { name: peer.name.clone(), ns, ratio });
        }
        if most > 1 {
            let parallel = ParallelTime::measure(&config, &frames, args.seconds, most)?;
            parallel.say(&measured);
            measured.parallel = Some(parallel);
        }
        report.settings.push(measured);
    }
    if report.settings.iter().any(|measured| measured.outliers * 10 > measured.passes) {
        say("warning   many passes were outliers: the machine was busy, measure again");
    }
    Ok(report)
}

fn measure(
    setting: &'static str,
    config: &SensorConfig,
    frames: &[Plane<f32>],
    seconds: f64,
) -> Result<Measured> {
    let (times_ns, events_per_pixel_step) = pass_times(config, frames, seconds, 1)?;
    let median_ns = nearest_rank(&times_ns, 0.5);
    Ok(Measured {
        setting,
        effects: config.effects.iter().map(|effect| effect.name.clone()).collect(),
        passes: times_ns.len(),
        // Sorted: the first is the least.
        min_ns: times_ns[0],
        median_ns,
        p90_ns: nearest_rank(&times_ns, 0.9),
        outliers: outlier_count(&times_ns),
        events_per_pixel_step,
        events_per_second: events_per_pixel_step / median_ns * 1e9,
        peers: Vec::new(),
        parallel: None,
    })
}

/// Shows the frames over and over, a pass at a time. Times per pixel and step, sorted, and the events
/// of one.
fn pass_times(
    config: &SensorConfig,
    frames: &[Plane<f32>],
    seconds: f64,
    threads: usize,
) -> Result<(Vec<f64>, f64)> {
    let model = SensorModel::from_config(config)?.with_threads(threads);
    let mut run = model.start(scene::SIZE, 1);
    let step = 1_000_000 / i64::from(scene::FPS);
    let pixel_steps = (frames.len() * scene::SIZE.pixels()) as f64;
    let mut now = 0;
    // Time goes on from pass to pass: a sensor does not go back.
    let mut pass = || -> Result<(f64, usize)> {
        let begin = Instant::now();
        let mut events = 0;
        for frame in frames {
            events += run.expose(frame, Micros(now))?.len();
            now += step;
        }
        Ok((begin.elapsed().as_secs_f64() * 1e9 / pixel_steps, events))
    };
    // The first passes fill caches, and pixels get used to the light.
    for _ in 0..3 {
        pass()?;
    }
    let begin = Instant::now();
    let (mut times_ns, mut events) = (Vec::new(), 0);
    // At least five, or the median of a slow setting would be one value.
    while begin.elapsed().as_secs_f64() < seconds || times_ns.len() < 5 {
        let (ns, count) = pass()?;
        times_ns.push(ns);
        events += count;
    }
    times_ns.sort_by(f64::total_cmp);
    let events_per_pixel_step = events as f64 / (times_ns.len() as f64 * pixel_steps);
    Ok((times_ns, events_per_pixel_step))
}

impl ParallelTime {
    fn measure(
        config: &SensorConfig,
        frames: &[Plane<f32>],
        seconds: f64,
        threads: usize,
    ) -> Result<Self> {
        let (times_ns, _) = pass_times(config, frames, seconds, threads)?;
        Ok(Self { threads, min_ns: times_ns[0], median_ns: nearest_rank(&times_ns, 0.5) })
    }

    fn say(&self, alone: &Measured) {
        say(format!(
            "  {:18} {:8.2} ns (min {:.2}): {:.2} times as fast as one",
            format!("on {}", threads(self.threads)),
            self.median_ns,
            self.min_ns,
            alone.median_ns / self.median_ns,
        ));
    }
}

impl Measured {
    fn say(&self) {
        say(format!("{}: {}", self.setting, self.effects.join(", ")));
        say(format!(
            "  {:18} {:8.2} ns per pixel and step (median of {} passes; min {:.2}, p90 {:.2}), \
             {:.1} million events/s ({:.2} % of pixel steps)",
            "evpose",
            self.median_ns,
            self.passes,
            self.min_ns,
            self.p90_ns,
            1e-6 * self.events_per_second,
            100.0 * self.events_per_pixel_step,
        ));
    }
}
