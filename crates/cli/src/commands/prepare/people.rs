//! `evpose prepare people`: a user's own recordings of people, with labels.

use crate::progress::{bar, say};
use crate::run_info;
use anyhow::{Context, Result};
use evpose_datasets::import::body::{
    BODY_LABEL_FORMATS, BodyOptions, BodyReport, import_body, read_body_labels,
};
use evpose_pose::body::JOINT_NAMES;

use super::own_args::PeopleArgs;
use super::say_sequences;
use crate::commands::account::Account;

pub(super) fn run(args: &PeopleArgs) -> Result<()> {
    let format = args.format.as_deref().map(|name| {
        BODY_LABEL_FORMATS.find(name).with_context(|| {
            let names = BODY_LABEL_FORMATS.names().join(", ");
            format!("no label format is called `{name}`; there are {names}")
        })
    });
    let format = format.transpose()?;
    let mut options =
        BodyOptions { clock: args.clock(), max_gap: args.own.max_gap(), ..BodyOptions::default() };
    let pairs = args.own.pairs()?;
    // Labels are small: all faults in them are found before anything is written.
    let labels = pairs.iter().map(|(_, path, _)| read_body_labels(path, format));
    let labels = labels.collect::<Result<Vec<_>, _>>()?;
    let import = args.own.begin()?;
    options.replace = import.replaces;
    let progress = bar("importing", pairs.len() as u64, "recordings");
    let mut sequences = 0;
    for ((recording, path, name), images) in pairs.iter().zip(&labels) {
        let read = evpose_io::open_as(recording, &args.opening.options(recording)?)
            .with_context(|| format!("reading {}", recording.display()))?;
        progress.suspend(|| Account::from_recording(&read).print());
        let report = import_body(&read.stream, images, path, &options, &args.own.out, name)?;
        progress.suspend(|| print(name, &report));
        sequences += report.sequences.len();
        progress.inc(1);
    }
    progress.finish_and_clear();
    // A directory of simulated recordings keeps the description of how they were made.
    if !args.own.out.join(run_info::CONFIG).exists() {
        run_info::write(&args.own.out, 0, None)?;
    }
    import.end()?;
    let out = args.own.out.display();
    say(format!("sequences: {sequences}, in {out}"));
    say(format!("next: evpose check-labels {out}"));
    Ok(())
}

fn print(name: &str, report: &BodyReport) {
    say_sequences(name, &report.sequences);
    let never: Vec<&str> = JOINT_NAMES
        .iter()
        .zip(report.joint_counts)
        .filter_map(|(joint, count)| (count == 0).then_some(*joint))
        .collect();
    if !never.is_empty() {
        say(format!("  note: never labelled: {}", never.join(", ")));
    }
    if let Some([width, height]) = report.scaled_from {
        say(format!(
            "  note: labels on {width}x{height} pixels were scaled to those of the sensor"
        ));
    }
    for (count, remark) in [
        (report.outside_recording, "labels outside of the recording are skipped"),
        (report.without_person, "images without annotations are skipped"),
        (report.several_persons, "images have several persons: the largest is used"),
        (report.outside_image, "joints outside of the image are skipped"),
    ] {
        if count > 0 {
            say(format!("  note: {count} {remark}"));
        }
    }
}
