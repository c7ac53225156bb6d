//! The commands about plans.

use std::path::Path;

use anyhow::{Context, Result};
use gapbench_pixel::Case;

use crate::args::{CalibrateArgs, CasesArgs, RunArgs, ScoreArgs};
use crate::bad_input::BadInput;
use crate::merge::{self, Merged};
use crate::opened::{self, Opened};
use crate::own::{self, OwnRow};
use crate::part::{self, PlanId};
use crate::program::Program;
use crate::terminal::{bar, say};
use crate::{
    calibrate, case_files, files, naming, page, score, stored, table, tables, use_threads,
};

/// `gapbench run`.
pub(crate) fn run(args: &RunArgs) -> Result<()> {
    use_threads(args.program.threads)?;
    let plan = PlanId::new(&args.cases.plan).context(BadInput)?;
    let cases = part::cases(&args.cases, plan).context(BadInput)?;
    let program = Program::find(&args.program)?;
    files::create(&args.out)?;
    naming::run(args, &program, plan, &cases)?;
    // A shard publishes nothing: scores of a part invite conclusions from it.
    if part::is_whole(&args.cases.plan.shard) {
        let dirs = [args.out.clone()];
        let Merged { rows, own } = merge::merge(&dirs, &cases, false)?;
        say(format!("opening   the labels of {} cases", rows.len()));
        let opened = opened::open(plan, &cases, rows, &Case::label)?;
        publish(&opened, &own, Vec::new(), &args.out)
    } else {
        say(format!(
            "done; score all parts with `gapbench score ... --plan {} --tier {}`",
            args.cases.plan.plan,
            plan.tier_name()
        ));
        Ok(())
    }
}

/// `gapbench cases`.
pub(crate) fn cases(args: &CasesArgs) -> Result<()> {
    let plan = PlanId::new(&args.cases.plan).context(BadInput)?;
    let cases = part::cases(&args.cases, plan).context(BadInput)?;
    let progress = bar("writing", cases.len() as u64, "cases");
    for case in cases {
        let folder = args.out.join(case_files::FOLDER).join(&case.id);
        case_files::write(&folder, &case)?;
        if args.truth {
            files::write_json(&folder, "truth.json", &case.label())?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    say(format!("written to {}", args.out.join(case_files::FOLDER).display()));
    Ok(())
}

/// `gapbench score`.
pub(crate) fn score(args: &ScoreArgs) -> Result<()> {
    use_threads(args.threads)?;
    let Some(out) = &args.out else {
        return args.dirs.iter().try_for_each(|root| stored::again(root)).context(BadInput);
    };
    files::create(out)?;
    let Some(plan) = &args.plan else {
        let (opened, own) = stored::cases(&args.dirs).context(BadInput)?;
        return publish(&opened, &own, stored::names(&args.dirs, out), out);
    };
    let plan = PlanId::of_seed(plan, args.tier).context(BadInput)?;
    let cases = plan.cases();
    let Merged { rows, own } = merge::merge(&args.dirs, &cases, args.partial).context(BadInput)?;
    say(format!("opening   the labels of {} cases", rows.len()));
    let opened = opened::open(plan, &cases, rows, &Case::label)?;
    let is_same = args.dirs.contains(out);
    for (name, text) in stored::lines(&opened)? {
        // Rows stay as their program wrote them.
        if !(is_same && name == naming::RESULTS) {
            files::write(out, name, text.as_bytes())?;
        }
    }
    if !(is_same || own.is_empty()) {
        files::write(out, own::NAME, own::text(&own).as_bytes())?;
    }
    publish(&opened, &own, Vec::new(), out)
}

/// `gapbench calibrate`.
pub(crate) fn calibrate(args: &CalibrateArgs) -> Result<()> {
    let fit = calibrate::Fit::of_stored(&args.stored).context(BadInput)?;
    let table = fit.markdown();
    table.lines().for_each(say);
    files::write(&args.stored, calibrate::NAME, table.as_bytes())?;
    let text = files::json(&fit.calibration)?;
    evpose_core::atomic_write(&args.out, text.as_bytes())
        .with_context(|| format!("writing {}", args.out.display()))?;
    say(format!("written to {}", args.out.display()));
    Ok(())
}

/// Prints the scores of opened cases and writes tables and page.
fn publish(opened: &[Opened], own: &[OwnRow], folders: Vec<String>, out: &Path) -> Result<()> {
    let scores = score::score_cases(opened, own::summary(own), folders);
    table::lines(&scores).iter().for_each(say);
    files::write_json(out, files::SCORES, &scores)?;
    files::write(out, files::TABLE, table::markdown(&scores).as_bytes())?;
    tables::write(out, opened, &scores)?;
    files::write(out, page::NAME, page::page(opened, &scores, own)?.as_bytes())?;
    say(format!("written to {}", out.display()));
    Ok(())
}
