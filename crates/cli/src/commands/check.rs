//! `evpose check`: whether a recording can be used as it is, on one page.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use evpose_clean::{Checkup, Findings, RateCheck, RateFindings};
use evpose_io::{Info, IoError, OpenOptions, info};
use serde::Serialize;

use super::clean::passes::Passes;
use crate::json::write_json;
use crate::outputs::OutputFile;
use crate::progress::say;
use crate::tasks::opening::OpeningArgs;

/// Exit codes.
const WITH_CHANGES: u8 = 10;
const UNUSABLE: u8 = 11;
/// Hot pixels among so many that are too many.
const HOT_ONE_IN: usize = 1_000;

/// Arguments of `evpose check`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  evpose check rec.aedat4\n  evpose check rec.csv --sensor 346x260 --json check.json\n\n\
    Exit codes: 0 usable as it is, 10 usable with the changes that are named, 11 not usable."
)]
pub struct CheckArgs {
    /// Recording in any supported format
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) opening: OpeningArgs,
    /// Also write the results as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<OutputFile>,
}

/// Whether a recording can be used.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
enum Usable {
    AsItIs,
    WithChanges,
    #[default]
    No,
}

/// Results, as written to JSON.
#[derive(Debug, Default, Serialize)]
struct Report {
    usable: Usable,
    format: Option<&'static str>,
    sensor: Option<[u16; 2]>,
    duration_s: Option<f64>,
    events: u64,
    rate_hz: Option<f64>,
    /// Times of the first event and of the last.
    span_s: Option<[f64; 2]>,
    /// Whether events were written by time, on one clock.
    is_in_order: Option<bool>,
    /// Of which all time stamps are multiples.
    step_us: Option<u64>,
    /// First and last column and row that fire.
    columns: Option<(u16, u16)>,
    rows: Option<(u16, u16)>,
    on_share: Option<f64>,
    rates: RateFindings,
    /// Faults and what to do about each.
    changes: Vec<String>,
    /// Remarks that need no change.
    remarks: Vec<String>,
    /// The command to go on with.
    next: String,
}

/// Runs `evpose check`.
pub fn run(args: &CheckArgs) -> Result<ExitCode> {
    let path = &args.input;
    // Of every command that is named: what was stated of the recording holds for it, too.
    let named = format!("{}{}", path.display(), args.opening.words());
    let checked = args.opening.options(path).and_then(|options| {
        let info = info(path, &options)?;
        report(path, &info, options, &named)
    });
    let report = match checked {
        Ok(report) => report,
        // What cannot be read is a result like any other, but for a file that is not there.
        Err(error) if matches!(error.downcast_ref(), Some(IoError::File { .. })) => {
            return Err(error);
        }
        Err(error) => unreadable(&named, &error),
    };
    print(path, &report);
    write_json(args.json.as_deref(), &report)?;
    Ok(ExitCode::from(match report.usable {
        Usable::AsItIs => 0,
        Usable::WithChanges => WITH_CHANGES,
        Usable::No => UNUSABLE,
    }))
}

/// A recording that no command reads as it is.
fn unreadable(named: &str, error: &anyhow::Error) -> Report {
    // A clock or a size that options settle is no damage.
    let is_settled = matches!(
        error.downcast_ref(),
        Some(
            IoError::ClockRestart { .. }
                | IoError::NoOrder { .. }
                | IoError::Outside { .. }
                | IoError::SmallerSensor { .. }
                | IoError::OtherSensor { .. }
                | IoError::SensorTooLarge { .. }
        )
    );
    Report {
        usable: if is_settled { Usable::WithChanges } else { Usable::No },
        changes: vec![format!("{error:#}")],
        next: match error.downcast_ref() {
            Some(IoError::Outside { is_turned: true, .. }) => {
                format!("evpose check {named} --swap-xy")
            }
            _ if is_settled => format!("evpose check {named} with one of these options"),
            _ => "evpose convert --help lists what is read".to_owned(),
        },
        ..Report::default()
    }
}

fn report(path: &Path, info: &Info, options: OpenOptions, named: &str) -> Result<Report> {
    let (passes, account) = Passes::open(path, options)?;
    let (mut checkup, mut survey) = (Checkup::new(account.sensor), RateCheck::new(account.sensor));
    passes.read("checking", |events| {
        checkup.push(events);
        survey.push(events);
        Ok(())
    })?;
    let (findings, counts) = (checkup.findings(), survey.findings());
    // What an option settles is a change.
    let (doubts, mut remarks): (Vec<_>, Vec<_>) =
        info.warnings.iter().cloned().partition(|warning| warning.contains("--time-unit"));
    let doubts = doubts.into_iter().map(|text| {
        let next = format!("evpose check {named} --time-unit s|ms|us|ns");
        Change { text, next: Some(next) }
    });
    let mut changes = changes(&findings, &counts, named);
    changes.extend(doubts);
    remarks.extend(findings.remarks.iter().cloned());
    if counts.gaps > 0 {
        remarks.push(format!("{} silences of 20 ms and more: packets may be lost", counts.gaps));
    }
    if let Some(hz) = counts.saturated_at_hz {
        remarks.push(format!(
            "the rate never exceeds {:.1} M events/s: the bus may be full, see `evpose gap`",
            hz * 1e-6
        ));
    }
    // Faults that no command mends come first, so that the first one decides.
    let (usable, next) = match changes.first().map(|first| first.next.clone()) {
        None => {
            let next = format!("evpose infer --checkpoint body --events {named} --out poses.csv");
            (Usable::AsItIs, next)
        }
        Some(Some(next)) => (Usable::WithChanges, next),
        Some(None) => (Usable::No, format!("evpose info {named}")),
    };
    Ok(Report {
        usable,
        format: Some(info.format),
        sensor: Some([info.sensor.width, info.sensor.height]),
        duration_s: Some(info.duration.as_seconds()),
        events: info.events,
        rate_hz: info.rate_hz(),
        span_s: info.span.map(|(first, last)| [first.as_seconds(), last.as_seconds()]),
        is_in_order: Some(!info.warnings.iter().any(|warning| warning.contains("sorted by time"))),
        step_us: findings.step_us,
        columns: findings.columns,
        rows: findings.rows,
        on_share: info.on_share(),
        rates: counts,
        changes: changes.into_iter().map(|change| change.text).collect(),
        remarks,
        next,
    })
}

/// A fault of a recording.
struct Change {
    text: String,
    /// The command that mends it; none if no command does.
    next: Option<String>,
}

/// Faults of a recording for a network, those that no command mends first.
fn changes(findings: &Findings, counts: &RateFindings, named: &str) -> Vec<Change> {
    let mut changes = Vec::new();
    let mut add = |text: String, next: Option<String>| changes.push(Change { text, next });
    if findings.events == 0 {
        add("there are no events".to_owned(), None);
    }
    if findings.events > 1 && findings.step_us.is_none() {
        add("all events have one time stamp: store times with more digits".to_owned(), None);
    }
    // Only the part that fires counts, since a recording may be a crop of its sensor.
    let pixels = findings.columns.zip(findings.rows).map_or(0, |((left, right), (top, bottom))| {
        usize::from(right - left + 1) * usize::from(bottom - top + 1)
    });
    if counts.hot_pixels * HOT_ONE_IN > pixels {
        let next = format!("evpose clean {named} clean.npz --with hot");
        add(format!("{} hot pixels: {next}", counts.hot_pixels), Some(next));
    }
    if let Some(hz) = counts.flicker_hz {
        let next = format!("evpose clean {named} clean.npz --with deflicker");
        add(format!("light flickers at {hz:.0} Hz: {next}"), Some(next));
    }
    changes
}

fn print(path: &Path, report: &Report) {
    say(path.display());
    let line = |name: &str, value: String| say(format!("  {name:9} {value}"));
    if let (Some(format), Some([width, height])) = (report.format, report.sensor) {
        line("format", format.to_owned());
        line("sensor", format!("{width}x{height}"));
    }
    if let Some(seconds) = report.duration_s {
        let rate = report.rate_hz.map(|hz| format!(", {:.1} thousand a second", hz * 1e-3));
        let rate = rate.unwrap_or_default();
        line("events", format!("{} in {seconds:.6} s{rate}", report.events));
    }
    if let Some([first, last]) = report.span_s {
        let step = report.step_us.map(|us| format!(", in steps of {us} µs")).unwrap_or_default();
        line("times", format!("{first:.6} s to {last:.6} s{step}"));
    }
    if let Some(in_order) = report.is_in_order {
        let said = if in_order { "by time, one clock" } else { "sorted by time, one clock" };
        line("order", said.to_owned());
    }
    if let Some(((left, right), (top, bottom))) = report.columns.zip(report.rows) {
        line("axes", format!("columns {left} to {right}, rows {top} to {bottom} fire"));
    }
    if let Some(on) = report.on_share {
        line("polarity", format!("{:.1} % ON", 100.0 * on));
    }
    if report.format.is_some() {
        line("hot", format!("{} pixels", report.rates.hot_pixels));
        let lamp = report.rates.flicker_hz.map(|hz| format!("of {hz:.0} Hz"));
        line("flicker", lamp.unwrap_or_else(|| "none of 100 or 120 Hz".to_owned()));
        let full = report.rates.saturated_at_hz.map(|hz| format!("at {:.1} M/s", hz * 1e-6));
        line("bus", full.unwrap_or_else(|| "no ceiling".to_owned()));
        line("gaps", report.rates.gaps.to_string());
    }
    report.remarks.iter().for_each(|remark| line("note", remark.clone()));
    report.changes.iter().for_each(|change| line("change", change.clone()));
    let usable = match report.usable {
        Usable::AsItIs => "as it is",
        Usable::WithChanges => "with these changes",
        Usable::No => "no",
    };
    line("usable", usable.to_owned());
    line("next", report.next.clone());
}
