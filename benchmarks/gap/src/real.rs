//! `gapbench real`: whether the names that recordings of real cameras get are properties of the
//! camera.
//!
//! # Method
//! Nobody knows what a real camera has, but a name must not depend on how the recording is looked
//! at: each half of it, its mirror images, and the recording with its time stretched by a tenth are
//! tested without a scene, by `evpose gap run --scene none`. Names must be those of the whole;
//! values in time must be stretched as well.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use evpose_core::{Event, EventStream, Micros, TimeWindow};
use evpose_gap::input::load_recording;
use evpose_gap::run_files;
use evpose_gap::verdict::{Finding, Quantity, Verdict};
use evpose_io::OpenOptions;
use evpose_io::format_for;
use evpose_sensor::STAGES;
use serde::Serialize;

use crate::bad_input::BadInput;
use crate::files;
use crate::program::{Program, ProgramArgs};
use crate::terminal::say;

/// Factor by which time is stretched.
const STRETCH: f64 = 1.1;
/// Relative difference up to which values agree.
const TOLERANCE: f64 = 0.05;

/// Arguments of `gapbench real`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    gapbench real davis.aedat4 evk.raw --out runs/real\n\n\
    Writes real.md and real.json. Each row is a recording as a whole, one of its halves, a mirror image, \
    or the recording with its time stretched by 1.1.")]
pub(crate) struct RealArgs {
    /// Recordings of real cameras, in any format
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// Directory for the table
    #[arg(long)]
    out: PathBuf,
    /// Fewer surrogates
    #[arg(long)]
    quick: bool,
    /// Seed of the surrogates
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    program: ProgramArgs,
}

/// A way of looking at a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Aspect {
    Whole,
    FirstHalf,
    SecondHalf,
    LeftRight,
    TopBottom,
    Stretched,
}

impl Aspect {
    const ALL: [Self; 6] = [
        Self::Whole,
        Self::FirstHalf,
        Self::SecondHalf,
        Self::LeftRight,
        Self::TopBottom,
        Self::Stretched,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::FirstHalf => "first half",
            Self::SecondHalf => "second half",
            Self::LeftRight => "mirrored left to right",
            Self::TopBottom => "mirrored top to bottom",
            Self::Stretched => "time x 1.1",
        }
    }

    /// The recording seen in this way.
    fn of(self, events: &EventStream) -> Result<EventStream> {
        let size = events.sensor();
        let (first, last) = match (events.t().first(), events.t().last()) {
            (Some(first), Some(last)) => (*first, *last),
            _ => return Ok(events.clone()),
        };
        let middle = Micros(first.0 + (last.0 - first.0) / 2);
        // A window excludes its end.
        let end = last + Micros(1);
        let seen = |change: &dyn Fn(Event) -> Event| {
            EventStream::from_events(size, events.iter().map(change))
        };
        let seen = match self {
            Self::Whole => return Ok(events.clone()),
            Self::FirstHalf => return Ok(events.slice(TimeWindow { start: first, end: middle })),
            Self::SecondHalf => return Ok(events.slice(TimeWindow { start: middle, end })),
            Self::LeftRight => seen(&|event| Event { x: size.width - 1 - event.x, ..event }),
            Self::TopBottom => seen(&|event| Event { y: size.height - 1 - event.y, ..event }),
            Self::Stretched => seen(&|event| {
                let since = (event.t.0 - first.0) as f64;
                Event { t: first + Micros((STRETCH * since).round() as i64), ..event }
            }),
        };
        seen.map_err(|error| anyhow!("{error}"))
    }

    /// Factor on a parameter with this unit.
    fn factor(self, unit: &str) -> f64 {
        match (self, unit) {
            (Self::Stretched, "us" | "ms" | "s") => STRETCH,
            (Self::Stretched, "Hz") => 1.0 / STRETCH,
            _ => 1.0,
        }
    }
}

/// Names and values of one way of looking at a recording.
#[derive(Debug, Serialize)]
struct Seen {
    aspect: Aspect,
    events: usize,
    seconds: f64,
    effects: BTreeMap<String, BTreeMap<String, (f64, String)>>,
}

#[derive(Debug, Serialize)]
struct Recording {
    file: String,
    aspects: Vec<Seen>,
}

impl Seen {
    /// Runs the program on one way of looking at a recording, with files in `folder`.
    fn new(
        aspect: Aspect,
        events: &EventStream,
        args: &RealArgs,
        program: &Program,
        folder: &Path,
    ) -> Result<Self> {
        let seen = aspect.of(events)?;
        let ends = seen.t().first().zip(seen.t().last());
        let seconds = ends.map_or(0.0, |(first, last)| (*last - *first).as_seconds());
        // A half may be empty, and is no recording then.
        let effects = match seen.is_empty() {
            true => Vec::new(),
            false => verdict(&seen, args, program, folder)?.effects,
        };
        let parameters = |finding: &Finding| {
            let value = |(key, quantity): (&String, &Quantity)| {
                (key.clone(), (quantity.value, quantity.unit.clone()))
            };
            (finding.name.clone(), finding.parameters.iter().map(value).collect())
        };
        let effects = effects.iter().map(parameters).collect();
        Ok(Self { aspect, events: seen.len(), seconds, effects })
    }

    /// Parameters that are not those of the whole recording, of names that both have.
    fn moved(&self, whole: &Self) -> Vec<String> {
        let mut moved = Vec::new();
        for (name, parameters) in &self.effects {
            for (key, (value, unit)) in parameters {
                // What the catalogue lacks describes the recording, which the change alters.
                let is_compared = is_compared(name, key);
                let Some((of_whole, _)) = whole.effects.get(name).and_then(|p| p.get(key)) else {
                    continue;
                };
                // Stretching time changes what is measured in seconds or hertz.
                let expected = of_whole * self.aspect.factor(unit);
                if is_compared && (value - expected).abs() > TOLERANCE * expected.abs() {
                    moved.push(format!("{name}.{key} {value:.4} for {expected:.4} {unit}"));
                }
            }
        }
        moved
    }
}

/// Whether the catalogue knows the parameter: others describe the recording.
fn is_compared(effect: &str, key: &str) -> bool {
    let spec = STAGES.find(effect);
    spec.is_some_and(|spec| spec.number_params().any(|param| param.name == key))
}

/// The verdict of the program on a recording without a scene.
fn verdict(
    events: &EventStream,
    args: &RealArgs,
    program: &Program,
    folder: &Path,
) -> Result<Verdict> {
    let (recording, seed) = (folder.join("events.npz"), args.seed.to_string());
    format_for(&recording)?.write(&recording, events)?;
    let mut arguments = ["--scene", "none", "--seed", &seed, "--measured"].map(OsStr::new).to_vec();
    arguments.push(recording.as_os_str());
    arguments.extend(args.quick.then_some(OsStr::new("--quick")));
    program.gap_run(&arguments, &folder.join("report"))?.read(run_files::VERDICT)
}

/// `gapbench real`.
pub(crate) fn run(args: &RealArgs) -> Result<()> {
    let program = Program::find(&args.program)?;
    // Files of one run at a time.
    let folder = args.out.join("run");
    files::create(&folder)?;
    let mut all = Vec::new();
    for path in &args.recordings {
        all.push(recording(path, args, &program, &folder)?);
    }
    files::remove(&folder)?;
    let table = markdown(&all);
    table.lines().for_each(say);
    files::write(&args.out, "real.md", table.as_bytes())?;
    files::write_json(&args.out, "real.json", &all)
}

fn recording(path: &Path, args: &RealArgs, program: &Program, folder: &Path) -> Result<Recording> {
    let events = load_recording(path, None, &OpenOptions::default()).context(BadInput)?.events;
    let seen = Aspect::ALL.into_iter().map(|a| Seen::new(a, &events, args, program, folder));
    let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    Ok(Recording { file, aspects: seen.collect::<Result<_>>()? })
}

fn markdown(all: &[Recording]) -> String {
    let mut text = "| recording | seen | events | s | names | as the whole | values |\n\
                    | --- | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for Recording { file, aspects } in all {
        // The recording itself comes first; all other ways of looking are compared with it.
        let Some(whole) = aspects.first() else { continue };
        for one in aspects {
            let names: Vec<&str> = one.effects.keys().map(String::as_str).collect();
            let moved = one.moved(whole);
            let cells = [
                file.clone(),
                one.aspect.name().to_owned(),
                one.events.to_string(),
                format!("{:.3}", one.seconds),
                if names.is_empty() { "none".to_owned() } else { names.join(", ") },
                if one.effects.keys().eq(whole.effects.keys()) { "yes" } else { "no" }.to_owned(),
                if moved.is_empty() { "agree".to_owned() } else { moved.join("; ") },
            ];
            text += &format!("| {} |\n", cells.join(" | "));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use evpose_core::{Polarity, SensorSize};

    use super::*;

    fn events() -> EventStream {
        let event = |k: u16| Event {
            t: Micros(1_000 + 1_000 * i64::from(k)),
            x: k % 7,
            y: k % 5,
            polarity: Polarity::from_on(k.is_multiple_of(2)),
        };
        EventStream::from_events(SensorSize { width: 7, height: 5 }, (0..101).map(event)).unwrap()
    }

    #[test]
    fn halves_share_all_events_and_mirrors_keep_them() {
        let all = events();
        let of = |aspect: Aspect| aspect.of(&all).unwrap();
        assert_eq!(of(Aspect::FirstHalf).len() + of(Aspect::SecondHalf).len(), all.len());
        let mirrored = of(Aspect::LeftRight);
        assert_eq!(mirrored.get(3).unwrap().x, 3);
        assert_eq!(mirrored.get(1).unwrap().x, 5);
        assert_eq!(of(Aspect::TopBottom).get(1).unwrap().y, 3);
        assert_eq!(of(Aspect::Stretched).get(100).unwrap().t, Micros(111_000));
    }

    #[test]
    fn times_are_stretched_and_rates_fall() {
        let seen = |aspect, value: f64, unit: &str| Seen {
            aspect,
            events: 1,
            seconds: 1.0,
            effects: BTreeMap::from([(
                "refractory".to_owned(),
                BTreeMap::from([("period_us".to_owned(), (value, unit.to_owned()))]),
            )]),
        };
        let whole = seen(Aspect::Whole, 1_000.0, "us");
        assert!(seen(Aspect::Stretched, 1_100.0, "us").moved(&whole).is_empty());
        assert_eq!(seen(Aspect::Stretched, 1_000.0, "us").moved(&whole).len(), 1);
        assert_eq!(seen(Aspect::FirstHalf, 1_200.0, "us").moved(&whole).len(), 1);
        assert!((Aspect::Stretched.factor("Hz") - 1.0 / 1.1).abs() < 1e-12);
    }
}
