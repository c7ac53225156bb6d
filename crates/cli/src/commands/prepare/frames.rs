//! Conversion of recordings to a set of frames, in parallel.

use std::fmt::Display;
use std::path::Path;

use anyhow::{Context, Result, bail};
use evpose_datasets::{Annotation, ErosFrameOptions, FrameSet, LabelledRecording};
use rayon::prelude::*;
use serde::Serialize;

use super::args::FrameSetArgs;
use super::{REPORT, list, say_next};
use crate::json::write_json;
use crate::progress::{bar, say};
use crate::run_info;
use crate::threads::use_threads;

pub(super) enum Reading<T = LabelledRecording> {
    /// Streams of its cameras, or their frames, and remarks in whole sentences.
    Seen { recordings: Vec<T>, remarks: Vec<String> },
    /// Reason why it is skipped.
    LeftOut(String),
}

/// Source of frames.
pub(super) struct Job<'a, T> {
    /// Name of a recording in messages.
    pub(super) unit: &'a str,
    pub(super) recordings: &'a [T],
    pub(super) is_test: fn(&T) -> bool,
    pub(super) options: ErosFrameOptions,
    pub(super) seed: u64,
}

/// Report of the made frames.
#[derive(Debug, Default, Serialize)]
struct Prepared {
    recordings: usize,
    frames_to_train: usize,
    frames_to_test: usize,
    left_out: Vec<Note>,
    remarks: Vec<Note>,
}

/// A remark about a recording.
#[derive(Debug, Serialize)]
struct Note {
    recording: String,
    note: String,
}

impl Note {
    fn line(&self) -> String {
        format!("{}: {}", self.recording, self.note)
    }
}

/// Writes a set of frames into the folder of `args`, and prints a report. Recordings that `read`
/// skips are listed; an error of `read` ends the conversion.
pub(super) fn prepare<T: Display + Sync>(
    args: &FrameSetArgs,
    job: &Job<'_, T>,
    read: impl Fn(&T) -> Result<Reading> + Sync,
) -> Result<()> {
    use_threads(args.threads)?;
    // Before anything is read: a set of hours must not be overwritten.
    let complete = ["train.json", "test.json"].map(|name| args.out.join(name));
    if let Some(path) = complete.iter().find(|path| path.exists()) {
        bail!(
            "{}: a set is there already: choose another --out, or remove that one",
            path.display()
        );
    }
    let mut set = FrameSet::new(&args.out, job.options);
    let progress = bar("drawing", job.recordings.len() as u64, job.unit);
    let drawn = job.recordings.par_iter().map(|recording| {
        let drawn = draw(&set, read(recording)?)?;
        progress.inc(1);
        Ok(drawn)
    });
    // In the order of recordings, whichever thread was first: the set is the same on any machine.
    let drawn = drawn.collect::<Result<Vec<_>>>()?;
    progress.finish_and_clear();
    let mut prepared = Prepared::default();
    for (recording, drawn) in job.recordings.iter().zip(drawn) {
        let note = |note| Note { recording: recording.to_string(), note };
        match drawn {
            Reading::Seen { recordings: frames, remarks } => {
                set.add(frames, (job.is_test)(recording));
                prepared.recordings += 1;
                prepared.remarks.extend(remarks.into_iter().map(note));
            }
            // A broken recording is a note, not the end: others of hundreds are good.
            Reading::LeftOut(reason) => prepared.left_out.push(note(reason)),
        }
    }
    if prepared.recordings == 0 {
        let first = prepared.left_out.first().map_or_else(String::new, Note::line);
        bail!("none of {} {} can be used. {first}", job.recordings.len(), job.unit);
    }
    [prepared.frames_to_train, prepared.frames_to_test] = set.finish()?;
    write_json(Some(&args.out.join(REPORT)), &prepared)?;
    run_info::write(&args.out, job.seed, None)?;
    print(&prepared, job.unit, &args.out);
    Ok(())
}

fn draw(set: &FrameSet, reading: Reading) -> Result<Reading<Annotation>> {
    let (recordings, mut remarks) = match reading {
        Reading::Seen { recordings, remarks } => (recordings, remarks),
        Reading::LeftOut(reason) => return Ok(Reading::LeftOut(reason)),
    };
    let mut frames = Vec::new();
    for recording in &recordings {
        let drawn = set.draw(recording).with_context(|| format!("drawing {}", recording.name))?;
        if drawn.is_empty() {
            remarks.push(format!("{}: no frame with a known joint", recording.name));
        }
        frames.extend(drawn);
    }
    Ok(Reading::Seen { recordings: frames, remarks })
}

fn print(prepared: &Prepared, unit: &str, out: &Path) {
    let Prepared { recordings, frames_to_train, frames_to_test, left_out, remarks } = prepared;
    say(format!("{frames_to_train} frames to train on and {frames_to_test} to test on"));
    say(format!("of {recordings} {unit}"));
    let lines = |notes: &[Note]| notes.iter().map(Note::line).collect::<Vec<_>>();
    list("left out", &lines(left_out));
    list("remarks", &lines(remarks));
    say(format!("written to {}", out.display()));
    if *frames_to_train > 0 {
        say_next("finetune", out);
    }
}
