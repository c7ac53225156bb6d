//! `evpose gap`: comparison of a sensor model with a recording, and identification of missing effects.

mod args;
mod camera;
mod davis;
mod inputs;
mod note;
mod run;
mod steps;
mod verify;

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Result};
use evpose_gap::report::ReportData;
use evpose_gap::verdict::{Answer, OUT_OF_TIME};

pub use args::GapCommand;
use args::ReportArgs;

use crate::bad_input::BadInput;
use crate::pages::gap::{self as report, files, terminal};
use crate::progress::say;

/// Runs `evpose gap`.
pub fn run(command: &GapCommand) -> Result<ExitCode> {
    let done = |result: Result<()>| result.map(|()| ExitCode::SUCCESS);
    let exit = |answer: Answer, is_out_of_time: bool| {
        ExitCode::from(if is_out_of_time { OUT_OF_TIME } else { answer.exit_code() })
    };
    match command {
        GapCommand::Run(args) => run::run(args).map(ExitCode::from),
        GapCommand::Probe(args) => done(steps::probe(args)),
        GapCommand::Locate(args) => done(steps::locate(args)),
        GapCommand::Name(args) => steps::name(args).map(|(answer, is_cut)| exit(answer, is_cut)),
        GapCommand::Correct(args) => {
            steps::correct(args).map(|(answer, is_cut)| exit(answer, is_cut))
        }
        GapCommand::Ablate(args) => {
            steps::ablate(args).map(|(answer, is_cut)| exit(answer, is_cut))
        }
        GapCommand::Power(args) => done(steps::power(args)),
        GapCommand::Report(args) => done(again(args)),
        GapCommand::Verify(args) => done(verify::run(args)),
        GapCommand::Camera(args) => done(camera::run(args)),
    }
}

/// `evpose gap report`: renders the page again.
fn again(args: &ReportArgs) -> Result<()> {
    let data = read(&args.dir).context(BadInput)?;
    terminal::lines(&data).iter().for_each(say);
    let page = report::write(&args.dir, &data)?;
    say(format!("drawn     {}", page.display()));
    Ok(())
}

fn read(dir: &Path) -> Result<ReportData> {
    let path = dir.join(files::REPORT);
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("{}: is this a directory of `evpose gap run`?", path.display()))?;
    Ok(ReportData::from_json(&text, &path)?)
}
