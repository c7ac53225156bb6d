//! `evpose events`: frames to events.
//!
//! Frames are read one at a time; events are in memory until they are written, 13 bytes each.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use evpose_core::{EventStream, Micros, Plane, Polarity, is_same_file};
use evpose_io::{FrameSource, OpenOptions, format_for};
use evpose_sensor::{EffectConfig, SensorConfig, SensorModel, SensorRun};

use super::opening::FrameArgs;
use crate::outputs::{OutputFile, write_file};
use crate::progress::{bar, say};
use crate::ranges::{threads, within};
use crate::run_info;
use crate::sensor_source as source;
use crate::threads::{sensor_threads, use_threads};

/// Arguments of `evpose events`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    evpose events --frames video/ --fps 120 --encoding srgb --sensor davis346 --out events.npz\n  \
    evpose events --frames clip.mp4 --encoding srgb --upsample 10 --sensor davis346 --out events.npz\n  \
    evpose events --frames frames.npy --fps 1000 --sensor v2e-clean --out events.txt")]
pub struct EventsArgs {
    #[command(flatten)]
    pub(crate) frames: FrameArgs,
    /// A preset or a TOML file of effects
    #[arg(long)]
    pub(crate) sensor: String,
    /// Where to write the events: .npz, .txt or .evc; the config and seed are written to OUT.toml
    #[arg(long)]
    pub(crate) out: OutputFile,
    /// Simulation steps per frame; luminance is interpolated linearly
    #[arg(long, default_value_t = 1, value_parser = within(1..=1_000_u32))]
    pub(crate) upsample: u32,
    /// Per-pixel thresholds as .npy (height, width): one file for ON and OFF, or one each
    #[arg(long, value_name = "FILE.npy", num_args = 1..=2)]
    pub(crate) threshold_map: Vec<PathBuf>,
    /// Topic of the events beside the images, of a recording of ROS that holds several
    #[arg(long, value_name = "NAME")]
    pub(crate) topic: Option<String>,
    /// Seed of fixed patterns and noise
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// CPU threads; all cores by default, of which the sensor uses up to four
    #[arg(long, value_parser = threads())]
    pub(crate) threads: Option<usize>,
}

/// Runs `evpose events`.
pub fn run(args: &EventsArgs) -> Result<()> {
    // An unknown ending is an error before anything is simulated.
    let format = format_for(&args.out)?;
    // The extension is appended, not replaced: OUT with `.toml` could be the sensor's file.
    let mut beside = args.out.as_os_str().to_owned();
    beside.push(".toml");
    let beside = PathBuf::from(beside);
    for input in [args.frames.frames.as_path(), Path::new(&args.sensor)] {
        let path = beside.display();
        ensure!(
            !is_same_file(&beside, input),
            "{path}: is read, and written beside --out: name another --out"
        );
    }
    let sensor = sensor(args)?;
    use_threads(args.threads)?;
    let model = SensorModel::from_config(&sensor)?;
    let options = OpenOptions { topic: args.topic.clone(), ..OpenOptions::default() };
    let mut source = args.frames.open(&options)?;
    ensure!(
        args.topic.is_none() || source.start().is_some(),
        "--topic is for frames of a recording of ROS"
    );
    ensure!(
        source.frames() > 1,
        "{}: at least two frames are required",
        args.frames.frames.display()
    );
    let clock = match args.frames.stated_times(&source)? {
        Some(times) => FrameClock::of_times(times, args.upsample)?,
        None => FrameClock::new(args.frames.rate()?, args.upsample)?,
    };
    let model = model.with_threads(sensor_threads(source.size()));
    let mut run = model.start(source.size(), args.seed);
    let events = convert(&mut source, &clock, &mut run)?;
    format.write(&args.out, &events.stream)?;
    write_file(&beside, provenance(args, &source, &sensor)?)?;
    events.report(&source, &clock, run.repaired_pixels());
    say(format!("written to {}, its config to {}", args.out.display(), beside.display()));
    Ok(())
}

/// The sensor of the arguments, with per-pixel thresholds after its other effects.
fn sensor(args: &EventsArgs) -> Result<SensorConfig> {
    let mut sensor = source::sensor(&args.sensor)?.config;
    // No map: the sensor stays as the preset or the file has it.
    let (on, off) = match args.threshold_map.as_slice() {
        [] => return Ok(sensor),
        [both] => (both, both),
        [on, off, ..] => (on, off),
    };
    let name = "fixed_pattern";
    // The map belongs to an effect that the sensor may not have.
    if sensor.effect(name).is_none() {
        sensor.effects.push(EffectConfig::new(name));
    }
    for (key, path) in [("threshold_on", on), ("threshold_off", off)] {
        let path = path.to_str().context("a path of a map must be text")?;
        sensor.set(name, key, path)?;
    }
    Ok(sensor)
}

/// Time stamps of frames and of the steps between them.
struct FrameClock {
    /// The mean rate, for frames that state their times.
    fps: f64,
    times_s: Option<Vec<f64>>,
    steps: u32,
}

impl FrameClock {
    fn new(fps: f64, steps: u32) -> Result<Self> {
        if !(fps > 0.0 && fps * f64::from(steps) <= 1e6) {
            bail!(
                "--fps {fps} in --upsample {steps} steps: expected up to a million steps a second"
            );
        }
        Ok(Self { fps, times_s: None, steps })
    }

    fn of_times(times_s: &[f64], steps: u32) -> Result<Self> {
        let duration_s = times_s.last().copied().unwrap_or(0.0);
        let fps = (times_s.len() as f64 - 1.0) / duration_s;
        Ok(Self { times_s: Some(times_s.to_vec()), ..Self::new(fps, steps)? })
    }

    /// Time stamp of a step towards a frame: the last step is the frame itself.
    fn at(&self, frame: u64, step: u32) -> Micros {
        // Steps are counted back from the frame, so that its own time stamp is exact.
        let share = f64::from(self.steps - step) / f64::from(self.steps);
        Micros::from_seconds(match &self.times_s {
            None => (frame as f64 - share) / self.fps,
            Some(times) => {
                let time = times[frame as usize];
                let before = (frame as usize).checked_sub(1).map_or(time, |before| times[before]);
                time - (time - before) * share
            }
        })
    }
}

/// The events of a sequence, with counts and times.
struct Converted {
    stream: EventStream,
    steps: u64,
    duration: Micros,
    elapsed: Duration,
}

fn convert(source: &mut FrameSource, clock: &FrameClock, run: &mut SensorRun) -> Result<Converted> {
    let size = source.size();
    let mut stream = EventStream::empty(size);
    let mut show = |run: &mut SensorRun, luminance: &Plane<f32>, t| -> Result<()> {
        for event in run.expose(luminance, t)?.iter() {
            stream.push(event)?;
        }
        Ok(())
    };
    // Three planes are reused: a frame may have megapixels, and there are thousands.
    let [mut before, mut frame, mut between] = [0; 3].map(|_| Plane::for_sensor(size, 0.0));
    let progress = bar("events of", source.frames(), "frames");
    let begin = Instant::now();
    let (mut index, mut steps) = (0, 0);
    while source.next_into(&mut frame)? {
        // The first frame has none before it to be interpolated from.
        let parts = if index == 0 { 1 } else { clock.steps };
        for part in 1..parts {
            let share = part as f32 / parts as f32;
            // Linear in light, as exposure is; a logarithm comes later, in the sensor.
            for ((y, a), b) in between.data_mut().iter_mut().zip(before.data()).zip(frame.data()) {
                *y = a + (b - a) * share;
            }
            show(run, &between, clock.at(index, part))?;
        }
        // The frame itself, without rounding of the interpolation.
        show(run, &frame, clock.at(index, clock.steps))?;
        steps += u64::from(parts);
        std::mem::swap(&mut before, &mut frame);
        index += 1;
        progress.inc(1);
    }
    progress.finish_and_clear();
    let duration = clock.at(index.saturating_sub(1), clock.steps);
    Ok(Converted { stream, steps, duration, elapsed: begin.elapsed() })
}

impl Converted {
    fn report(&self, source: &FrameSource, clock: &FrameClock, repaired: u64) {
        let rate = match clock.times_s {
            None => format!("{} fps", clock.fps),
            Some(_) => format!("{:.3} fps on average, at the times that they state", clock.fps),
        };
        say(format!(
            "frames    {} of {} at {rate}, {} steps each; {}, {}, white at {}",
            source.frames(),
            source.size(),
            clock.steps,
            source.depth(),
            source.encoding(),
            source.white(),
        ));
        let on = self.stream.polarity().iter().filter(|p| **p == Polarity::On).count();
        let (all, duration_s) = (self.stream.len(), self.duration.as_seconds());
        say(format!(
            "events    {all}: {on} ON, {} OFF in {duration_s:.6} s, {:.1} thousand per second",
            all - on,
            1e-3 * all as f64 / duration_s,
        ));
        // A coarse clock may show no time at all: rates should not be infinite.
        let elapsed_s = self.elapsed.as_secs_f64().max(1e-9);
        say(format!(
            "speed     {:.0} steps/s, {:.2} million events/s, reading included",
            self.steps as f64 / elapsed_s,
            1e-6 * all as f64 / elapsed_s,
        ));
        if repaired > 0 {
            say(format!(
                "warning   {repaired} values were negative or NaN, and were taken as darkness"
            ));
        }
    }
}

/// Run, frames and sensor as TOML, with absolute paths.
fn provenance(args: &EventsArgs, source: &FrameSource, sensor: &SensorConfig) -> Result<String> {
    // Absolute: the file is read from other folders, too.
    let whole = |path: &Path| -> Result<String> {
        Ok(std::path::absolute(path)?.to_string_lossy().into_owned())
    };
    let mut frames = toml::Table::new();
    frames.insert("path".into(), whole(source.path())?.into());
    frames.insert("count".into(), i64::try_from(source.frames())?.into());
    frames.insert("width".into(), i64::from(source.size().width).into());
    frames.insert("height".into(), i64::from(source.size().height).into());
    // Without it, the times are those of the video.
    if let Some(fps) = args.frames.fps {
        frames.insert("fps".into(), fps.into());
    }
    frames.insert("upsample".into(), i64::from(args.upsample).into());
    frames.insert("encoding".into(), source.encoding().name().into());
    frames.insert("white".into(), source.white().into());
    let mut table = run_info::table(args.seed)?;
    table.insert("frames".into(), frames.into());
    // Paths of maps are relative to the working folder here: they become absolute, too.
    let sensor = sensor.clone().relative_to(&std::env::current_dir()?);
    table.insert("sensor".into(), toml::Table::try_from(sensor)?.into());
    Ok(table.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_frames_are_even_and_the_last_is_the_frame() -> Result<()> {
        let clock = FrameClock::new(100.0, 4)?;
        let times = [1, 2, 3, 4].map(|step| clock.at(1, step).0);
        assert_eq!(times, [2_500, 5_000, 7_500, 10_000]);
        assert_eq!(FrameClock::new(30.0, 1)?.at(2, 1), Micros(66_667));
        assert_eq!(FrameClock::new(1000.0, 1)?.at(0, 1), Micros(0));
        let clock = FrameClock::of_times(&[0.0, 0.04, 0.14], 2)?;
        let times =
            [(0, 2), (1, 1), (1, 2), (2, 1), (2, 2)].map(|(frame, step)| clock.at(frame, step).0);
        assert_eq!(times, [0, 20_000, 40_000, 90_000, 140_000]);
        Ok(())
    }

    #[test]
    fn rates_that_microseconds_cannot_resolve_are_refused() {
        for (fps, steps) in [(0.0, 1), (-5.0, 1), (f64::NAN, 1), (2e6, 1), (1e6, 2)] {
            assert!(FrameClock::new(fps, steps).is_err(), "{fps} {steps}");
        }
    }
}
