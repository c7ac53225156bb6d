//! `evpose convert`: a recording in another format.
//!
//! Files that state their sensor are converted window by window, in constant memory.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use evpose_core::{EventStream, Micros, TimeWindow};
use evpose_io::{
    EventSink, FORMATS, Format, OpenOptions, SensorOrigin, Windows, format_for, open_as,
};

use super::account::Account;
use super::opening::RecordingArgs;
use crate::outputs::OutputFile;
use crate::progress::{say, spinner};
use crate::ranges::{seconds, since_start};

/// Arguments of `evpose convert`.
#[derive(Debug, clap::Args)]
#[command(after_help = format!("Examples:\n  evpose convert rec.aedat4 rec.npz\n  \
    evpose convert rec.raw part.txt --from 1.5 --to 2 --zero-time\n  \
    evpose convert rec.txt rec.raw --format evt2 --sensor 640x480\n\n{}", formats()))]
pub struct ConvertArgs {
    #[command(flatten)]
    pub(crate) recording: RecordingArgs,
    /// File to write, in the format of its extension or of --format
    pub(crate) out: OutputFile,
    /// Name of the format to write
    #[arg(long)]
    pub(crate) format: Option<String>,
    /// Begin so many seconds after the first event
    #[arg(long, value_name = "SECONDS", value_parser = since_start())]
    pub(crate) from: Option<f64>,
    /// End so many seconds after the first event
    #[arg(long, value_name = "SECONDS", value_parser = seconds())]
    pub(crate) to: Option<f64>,
}

/// Event time of a window.
const STEP: Micros = Micros(20_000);

/// Runs `evpose convert`.
pub fn run(args: &ConvertArgs) -> Result<()> {
    let format = format(&args.out, args.format.as_deref())?;
    let options = args.recording.opening.options(&args.recording.input)?;
    // Opening counts as well: for a user, speed is events over the whole wait.
    let begin = Instant::now();
    let done = match windows(args, format, &options)? {
        Some(done) => done,
        None => whole(args, format, &options)?,
    };
    done.account.print();
    let events = done.events;
    let speed = events as f64 / begin.elapsed().as_secs_f64().max(1e-9) / 1e6;
    say(format!(
        "{}: {events} events of a {} sensor, as {} ({speed:.1} M events/s)",
        args.out.display(),
        done.account.sensor,
        format.name
    ));
    Ok(())
}

pub(super) fn format(out: &Path, name: Option<&str>) -> Result<&'static Format> {
    let Some(name) = name else { return Ok(format_for(out)?) };
    FORMATS.find(name).with_context(|| {
        let names = FORMATS.names().join(", ");
        format!("no format is called `{name}`; there are {names}")
    })
}

/// The table of formats for the help text.
pub(crate) fn formats() -> String {
    let mut text = "Formats, detected by content when read:\n".to_owned();
    for format in &FORMATS {
        let written = match format.create {
            Some(_) => format.endings.join(" "),
            None => "read only".to_owned(),
        };
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {:12} {:14} {}", format.name, written, format.summary);
    }
    text
}

struct Done {
    events: u64,
    account: Account,
}

/// Time window to convert, and the offset of its time stamps.
struct Cut {
    window: TimeWindow,
    shift: Micros,
}

impl Cut {
    fn new(args: &ConvertArgs, first: Micros) -> Result<Self> {
        let after = |seconds: f64| Micros(first.0.saturating_add(Micros::from_seconds(seconds).0));
        let start = args.from.map_or(Micros(i64::MIN), after);
        let end = args.to.map_or(Micros(i64::MAX), after);
        ensure!(start < end, "--from lies behind --to");
        // Without --from, the cut starts at the smallest time there is, which is no origin.
        let origin = if start < first { first } else { start };
        let is_zeroed = args.recording.opening.zero_time;
        let shift = if is_zeroed { Micros(0) - origin } else { Micros(0) };
        Ok(Self { window: TimeWindow { start, end }, shift })
    }

    /// Writes the events inside the cut, and returns their count.
    fn write(&self, events: &EventStream, sink: &mut dyn EventSink) -> Result<u64> {
        let taken = events.slice(self.window);
        if taken.is_empty() {
            return Ok(0);
        }
        let count = taken.len() as u64;
        // The usual case needs no copy.
        if self.shift == Micros(0) {
            sink.write(&taken)?;
        } else {
            let shifted = taken.iter().map(|mut event| {
                event.t = event.t + self.shift;
                event
            });
            sink.write(&EventStream::from_events(taken.sensor(), shifted)?)?;
        }
        Ok(count)
    }
}

/// Converts window by window. None if that would lose events or need all of them.
fn windows(args: &ConvertArgs, format: &Format, options: &OpenOptions) -> Result<Option<Done>> {
    let mut windows = Windows::open(&args.recording.input, options)?;
    // The header of the output has the sensor before the first event is known.
    if windows.sensor_origin() == SensorOrigin::Inferred {
        return Ok(None);
    }
    let sensor = windows.sensor();
    let mut sink = format.create(&args.out, sensor)?;
    let mut events = EventStream::empty(sensor);
    let mut written = 0;
    let progress = spinner();
    if let Some(first) = windows.start() {
        let cut = Cut::new(args, first)?;
        let mut start = if cut.window.start < first { first } else { cut.window.start };
        while start < cut.window.end && !windows.is_over_at(start)? {
            let window = TimeWindow { start, end: start + STEP };
            windows.read(window, &mut events)?;
            // Known only as events come: what was written so far is thrown away with the sink.
            let is_assumed = windows.sensor_origin() == SensorOrigin::Assumed;
            let is_too_small = is_assumed && windows.outside() > 0;
            if is_too_small {
                return Ok(None);
            }
            written += cut.write(&events, sink.as_mut())?;
            progress.set_message(format!("{written} events"));
            // Silences are jumped over, whatever their length.
            start = window.end.max(windows.next_after(window.end));
        }
    }
    progress.finish_and_clear();
    sink.finish()?;
    Ok(Some(Done { events: written, account: Account::from_windows(&windows) }))
}

fn whole(args: &ConvertArgs, format: &Format, options: &OpenOptions) -> Result<Done> {
    let read = open_as(&args.recording.input, options)?;
    let mut sink = format.create(&args.out, read.stream.sensor())?;
    let cut = Cut::new(args, read.stream.t().first().copied().unwrap_or(Micros(0)))?;
    let events = cut.write(&read.stream, sink.as_mut())?;
    sink.finish()?;
    Ok(Done { events, account: Account::from_recording(&read) })
}
