//! `evpose prepare hands`: a user's own recordings of hands, with labels.

use std::path::Path;

use crate::commands::account::Account;
use crate::progress::{bar, say};
use crate::{configs, run_info};
use anyhow::{Context, Result};
use burn::tensor::Device;
use evpose_core::Micros;
use evpose_datasets::import::hand::{
    FitOptions, HandLabels, HandOptions, HandReport, LabelChoice, import_hand, read_hand_labels,
};
use evpose_task::hand::{HandCheckpoint, HandConfig, calibration_for};

use super::own_args::{HandScale, HandsArgs};
use super::{SHOWN, say_sequences};

pub(super) fn run(args: &HandsArgs) -> Result<()> {
    let config = config(&args.target)?;
    let choice = LabelChoice { on_image: args.on_image, frame: args.frame };
    let pairs = args.own.pairs()?;
    // Labels are small: all faults in them are found before anything is written.
    let labels = pairs.iter().map(|(_, path, _)| read_hand_labels(path, choice));
    let labels = labels.collect::<Result<Vec<_>, _>>()?;
    let import = args.own.begin()?;
    let options = HandOptions { replace: import.replaces, ..options(args) };
    let count = labels.iter().map(|labels| match labels {
        HandLabels::Parameters(labels) => labels.len(),
        HandLabels::Joints(labels) => labels.len(),
    });
    let progress = bar("importing", count.sum::<usize>() as u64, "labels");
    let mut sequences = 0;
    for ((recording, path, name), labels) in pairs.iter().zip(&labels) {
        let read = evpose_io::open_as(recording, &args.opening.options(recording)?)
            .with_context(|| format!("reading {}", recording.display()))?;
        progress.suspend(|| Account::from_recording(&read).print());
        let calibration = calibration_for(&config, read.stream.sensor(), args.camera.as_deref())?;
        let report = import_hand(
            &read.stream,
            &calibration,
            (labels, path),
            &config,
            &options,
            (&args.own.out, name),
            &mut |count| progress.inc(count),
        )?;
        progress.suspend(|| {
            if let Some(note) = &calibration.note {
                say(format!("note: {note}"));
            }
            print(name, &report);
        });
        sequences += report.sequences.len();
    }
    progress.finish_and_clear();
    // Of a directory that is added to, the description of how it began is kept. The config says which
    // hand and camera the labels are of.
    if !args.own.out.join(run_info::CONFIG).exists() {
        run_info::write(&args.own.out, config.seed, Some(&config))?;
    }
    import.end()?;
    let out = args.own.out.display();
    say(format!("sequences: {sequences}, in {out}"));
    say(format!("next: evpose train CONFIG --data {out} --start-from CHECKPOINT --out RUN"));
    Ok(())
}

/// The config of a network: by name, from a file, or of a checkpoint.
fn config(target: &str) -> Result<HandConfig> {
    let path = Path::new(target);
    let is_config = path.extension().is_some_and(|ending| ending == "toml");
    // What does not exist goes to the configs as well, whose error lists all names.
    if configs::CONFIGS.find(target).is_some() || is_config || !path.exists() {
        return configs::load(target, &[]);
    }
    let checkpoint = HandCheckpoint::load(path, &Device::flex());
    Ok(checkpoint.with_context(|| format!("--for {target}: no network of hands"))?.config)
}

fn options(args: &HandsArgs) -> HandOptions {
    let scale = match args.scale {
        HandScale::Given(scale) => scale,
        HandScale::Fitted => 1.0,
    };
    HandOptions {
        start: Micros(args.own.start_us),
        max_gap: args.own.max_gap(),
        side: args.side,
        fit_scale: args.scale == HandScale::Fitted,
        fit: FitOptions { scale, ..FitOptions::default() },
        ..HandOptions::default()
    }
}

fn print(name: &str, report: &HandReport) {
    say_sequences(name, &report.sequences);
    if let Some((px, metres)) = report.mean_residual() {
        let in_space = metres.map(|m| format!(", {:.2} mm", 1e3 * m)).unwrap_or_default();
        let scale = report.scale;
        say(format!("  fit: mean residual {px:.2} px{in_space}; size of the hand {scale:.3}"));
    }
    if !report.poor.is_empty() {
        // No error: the fit shows users where labels are mixed up, and the rest is of use.
        let count = report.poor.len();
        say(format!("  warning: {count} labels are not those of such a hand, the worst ones at"));
        for (t, fitted) in report.poor.iter().take(SHOWN) {
            let in_space = fitted.residual_m.map(|m| format!(", {:.1} mm", 1e3 * m));
            let in_space = in_space.unwrap_or_default();
            say(format!("    {:.6} s: {:.1} px{in_space}", t.as_seconds(), fitted.residual_px));
        }
    }
    if report.is_mirrored {
        say("  note: the mirror image was written: the network predicts the other hand");
    }
    for (count, remark) in [
        (report.outside_recording, "labels outside of the recording are skipped"),
        (report.incomplete, "labels with too few joints are skipped"),
        (report.isolated, "labels in stretches that are too short are skipped"),
    ] {
        if count > 0 {
            say(format!("  note: {count} {remark}"));
        }
    }
}
