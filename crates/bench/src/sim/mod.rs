//! `evpose bench sim`: steps a second of the labelled hand simulation, and where the time goes.

mod mesh;
mod raster;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use evpose_body::BodyModel;
use evpose_sim::{Simulation, SimulationConfig, SimulationPart, record};
use rayon::prelude::*;
use serde::Serialize;

use crate::all::{Figure, threads};
use evpose_cli::configs;
use evpose_cli::json::write_json;
use evpose_cli::outputs::OutputFile;
use evpose_cli::progress::{bar, say};
use evpose_cli::provenance::Provenance;
use evpose_cli::ranges::{self, count, seconds};
use evpose_cli::threads::use_threads;
use evpose_core::stats::quantile::{nearest_rank, outlier_count};
use evpose_task::hand::HandConfig;
use raster::RasterTime;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose bench sim\n  evpose bench sim --quick\n  \
    evpose bench sim --sequences 2 --seconds 5 --json sim.json")]
pub struct BenchSimArgs {
    /// A TOML file, or an embedded config: its simulation is measured
    #[arg(long, default_value = "eventhands")]
    pub(crate) config: String,
    /// Sequences of each mesh
    #[arg(long, default_value_t = 10, value_parser = count::<u64>())]
    pub(crate) sequences: u64,
    /// Simulated seconds of each sequence
    #[arg(long, default_value_t = 50.0, value_parser = seconds())]
    pub(crate) seconds: f64,
    /// A short look: 4 sequences of 2 s, in which beginnings weigh more
    #[arg(long, conflicts_with_all = ["sequences", "seconds"])]
    pub(crate) quick: bool,
    /// Sequences at a time; one on each core by default
    #[arg(long, value_parser = ranges::threads())]
    pub(crate) threads: Option<usize>,
    /// Folder for the files, removed after each sequence [default: the system's for temporary
    /// files]
    #[arg(long)]
    pub(crate) scratch: Option<PathBuf>,
    /// Where to write the results as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
}

/// Sequences of each mesh, and their seconds, in a short look.
const QUICK: (u64, f64) = (4, 2.0);

/// Share of the image that the hand covers, on average, where figures are to be compared.
const MIN_COVERAGE: f64 = 0.1;

/// Content of the JSON file.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    image: String,
    sequences: u64,
    seconds: f64,
    meshes: Vec<Measured>,
}

/// One mesh.
#[derive(Debug, Serialize)]
struct Measured {
    mesh: &'static str,
    vertices: usize,
    triangles: usize,
    /// Share of the image that the hand covers, on average.
    coverage: f64,
    events_per_step: f64,
    /// Steps a second of one sequence, sorted; as many run at a time as there are threads.
    sequence_steps_per_s: Vec<f64>,
    /// Median of those, times the threads.
    median_steps_per_s: f64,
    /// All steps over all time, starts and ends of sequences included.
    overall_steps_per_s: f64,
    outliers: usize,
    /// Microseconds a step on one thread.
    parts_us: Vec<(&'static str, f64)>,
    rasterisers: Vec<RasterTime>,
}

/// One sequence.
struct Timed {
    steps_per_s: f64,
    parts_s: [f64; SimulationPart::ALL.len()],
    total_s: f64,
    coverage: f64,
    events: u64,
}

pub(crate) fn run(args: &BenchSimArgs) -> Result<()> {
    write_json(args.json.as_deref(), &measure_all(args)?)
}

pub(crate) fn figures(args: &BenchSimArgs) -> Result<Vec<Figure>> {
    let report = measure_all(args)?;
    let figure = |measured: &Measured| {
        let work =
            format!("{} hand, {}", measured.mesh, threads(report.provenance.machine.threads));
        Figure::rate("sim", work, "steps/s", measured.median_steps_per_s)
    };
    Ok(report.meshes.iter().map(figure).collect())
}

fn measure_all(args: &BenchSimArgs) -> Result<Report> {
    use_threads(args.threads)?;
    let mut config: HandConfig = configs::load(&args.config, &[])?;
    let (sequences, seconds) = if args.quick { QUICK } else { (args.sequences, args.seconds) };
    config.simulation.sequences = sequences as usize;
    config.simulation.seconds = seconds;
    // Sequences and seconds are not those of the file, whose check says nothing of them.
    config.simulation.validate()?;
    // A disk of the user's choice: writing is a part of the time.
    let scratch = match &args.scratch {
        Some(folder) => tempfile::tempdir_in(folder),
        None => tempfile::tempdir(),
    }
    .context("making a folder for the recordings")?;
    let simulation = &config.simulation;
    let mut report = Report {
        provenance: Provenance::this(),
        image: simulation.image_size().to_string(),
        sequences,
        seconds,
        meshes: Vec::new(),
    };
    say(format!("machine   {}", report.provenance.machine));
    say(format!(
        "steps     of {} ms at {}, {} sequences of {} s for each mesh, files written",
        simulation.step().as_seconds() * 1e3,
        report.image,
        report.sequences,
        report.seconds
    ));
    // The mesh of SMPL+H cannot be shipped: one with as many vertices stands for it.
    let arm = BodyModel::procedural_arm();
    let fine = mesh::refined(arm.clone(), mesh::SMPLH_VERTICES);
    for (name, body) in [("procedural", arm), ("as fine as SMPL+H", fine)] {
        let measured = measure(name, simulation, config.seed, body, scratch.path())?;
        measured.say(report.provenance.machine.threads, &report.image);
        report.meshes.push(measured);
    }
    Ok(report)
}

fn measure(
    mesh: &'static str,
    config: &SimulationConfig,
    seed: u64,
    body: BodyModel,
    scratch: &Path,
) -> Result<Measured> {
    let rasterisers = raster::measure(config, &body);
    let (vertices, triangles) = (body.template_m.len(), body.faces.len());
    let simulation = Simulation::with_body(config, seed, body)?;
    let progress = bar(mesh, config.sequences as u64 * config.frames(), "steps");
    let begin = Instant::now();
    let sequences: Vec<Timed> = (0..config.sequences)
        .into_par_iter()
        // Sequences are the unit of work, as in `evpose simulate`.
        .with_max_len(1)
        .map(|index| sequence(&simulation, index as u64, scratch, &|steps| progress.inc(steps)))
        .collect::<Result<_>>()?;
    let overall_s = begin.elapsed().as_secs_f64();
    progress.finish_and_clear();

    let steps = config.frames() as f64;
    let count = sequences.len() as f64;
    let per_step_us = |s: f64| s / (count * steps) * 1e6;
    let mut parts_us: Vec<(&'static str, f64)> = SimulationPart::ALL
        .into_iter()
        .map(|part| {
            let sum_s: f64 = sequences.iter().map(|timed| timed.parts_s[part as usize]).sum();
            (part.name(), per_step_us(sum_s))
        })
        .collect();
    let total_us = per_step_us(sequences.iter().map(|timed| timed.total_s).sum());
    let known_us: f64 = parts_us.iter().map(|(_, us)| us).sum();
    // The rest is what no stopwatch measured.
    parts_us.push(("write and rest", total_us - known_us));
    parts_us.push(("step", total_us));
    let mut rates: Vec<f64> = sequences.iter().map(|timed| timed.steps_per_s).collect();
    rates.sort_by(f64::total_cmp);
    // Threads beyond the number of sequences have nothing to do.
    let at_a_time = rayon::current_num_threads().min(sequences.len()) as f64;
    Ok(Measured {
        mesh,
        vertices,
        triangles,
        coverage: sequences.iter().map(|timed| timed.coverage).sum::<f64>() / count,
        events_per_step: sequences.iter().map(|timed| timed.events as f64).sum::<f64>()
            / (count * steps),
        median_steps_per_s: nearest_rank(&rates, 0.5) * at_a_time,
        overall_steps_per_s: count * steps / overall_s,
        outliers: outlier_count(&rates),
        sequence_steps_per_s: rates,
        parts_us,
        rasterisers,
    })
}

/// Records one sequence, from its first draw to its files, and removes them.
fn sequence(
    simulation: &Simulation,
    index: u64,
    scratch: &Path,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Timed> {
    let frames = simulation.config().frames();
    let begin = Instant::now();
    let mut simulator = simulation.sequence(index)?.timed();
    let stem = scratch.join(format!("{index:04}"));
    // Files are written: that is part of a step.
    let recorded = record(&mut simulator, frames, &stem, progress)?;
    let total_s = begin.elapsed().as_secs_f64();
    for ending in ["evc", "meta", "toml"] {
        std::fs::remove_file(stem.with_extension(ending))
            .with_context(|| format!("removing {}", stem.display()))?;
    }
    let watch = simulator.stopwatch();
    Ok(Timed {
        steps_per_s: frames as f64 / total_s,
        parts_s: SimulationPart::ALL.map(|part| watch.time(part).as_secs_f64()),
        total_s,
        coverage: watch.coverage(),
        events: recorded.events,
    })
}

impl Measured {
    fn say(&self, threads: usize, image: &str) {
        say(format!(
            "\n{}: {} vertices, {} triangles, {:.1} % of the image, {:.0} events a step",
            self.mesh,
            self.vertices,
            self.triangles,
            100.0 * self.coverage,
            self.events_per_step
        ));
        say(format!(
            "  {:.0} steps/s on {threads} threads: median sequence of {} ({:.0} over all time)",
            self.median_steps_per_s,
            self.sequence_steps_per_s.len(),
            self.overall_steps_per_s
        ));
        let total_us = self.parts_us.last().map_or(1.0, |(_, us)| *us);
        for (name, us) in &self.parts_us {
            say(format!("  {name:16} {us:8.1} µs {:5.1} %", 100.0 * us / total_us));
        }
        if self.coverage < MIN_COVERAGE {
            say("  note: less than 10 % of the image; with more to shade a step takes longer");
        }
        say(format!("  rasteriser alone, {} flat triangles at {image}, one core:", self.triangles));
        for time in &self.rasterisers {
            say(format!(
                "  {:20} {:8.1} µs, {:.2} times ours ({:.0} pixels)",
                time.name, time.median_us, time.ratio, time.covered
            ));
        }
        if self.outliers * 10 > self.sequence_steps_per_s.len() {
            say("  warning: some sequences were outliers: the machine was busy, measure again");
        }
    }
}
