//! `gapbench calibrate`: probabilities and intervals from all stored cases, and how well they hold
//! of folders that a fit has not seen.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_gap::free_parameter::FreeParameter;
use evpose_gap::workflow::calibrate::{EstimateError, coverage, fit_errors, fit_probability};
use evpose_gap::workflow::{
    CALIBRATION, Calibration, ErrorScale, FEATURES, FindingEvidence, ParameterOwner,
};
use serde::Deserialize;

use super::opened::Opened;
use super::part::tier_name;
use super::stats::{Rate, Stated, bins, calibration_error};
use super::{outside, stored};
use evpose_report::format::short;

/// How well the fit holds, as a table.
pub(super) const NAME: &str = "calibration.md";
/// The fits that programs stated probabilities by whose rows have no evidence.
const STATED_BY: &str = "stated-by.json";
/// Tier of recordings of other programs.
const OUTSIDE: &str = "outside";

/// The fit that programs of some commits had.
#[derive(Deserialize)]
struct StatedBy {
    commits: Vec<String>,
    calibration: Calibration,
}

/// The names of a folder, and errors of its estimates.
#[derive(Debug, Default, Clone)]
pub(super) struct Folder {
    name: String,
    tier: &'static str,
    /// Evidence of each effect that was named, and whether it is there.
    names: Vec<(FindingEvidence, bool)>,
    /// The same without names of conventions, of recordings of other programs.
    strict: Vec<(FindingEvidence, bool)>,
    of_effect: Vec<EstimateError>,
    of_model: Vec<EstimateError>,
}

/// A fit, and how well it holds.
pub(super) struct Fit {
    pub(super) calibration: Calibration,
    folders: Vec<Folder>,
}

impl Fit {
    pub(super) fn of_stored(root: &Path) -> Result<Self> {
        let folders = folders(root)?;
        let all: Vec<&Folder> = folders.iter().collect();
        let calibration = fit(&all).context("names are all right, or there are none")?;
        Ok(Self { calibration, folders })
    }

    /// Probabilities that a fit without some folders states of folders: of all names, and of those
    /// that are no convention.
    #[cfg(test)]
    pub(super) fn stated_without(&self, without: &[&str], names: &[&str]) -> Option<[Stated; 2]> {
        let is_seen = |folder: &&Folder| !without.contains(&folder.name.as_str());
        let calibration = fit(&self.folders.iter().filter(is_seen).collect::<Vec<_>>())?;
        let of = |names_of: fn(&Folder) -> &Vec<(FindingEvidence, bool)>| {
            let these = self.folders.iter().filter(|folder| names.contains(&folder.name.as_str()));
            let stated = these.flat_map(|folder| stated(&calibration, names_of(folder)));
            Stated::of(&stated.collect::<Vec<_>>())
        };
        Some([of(|folder| &folder.names), of(|folder| &folder.strict)])
    }

    /// The fit, and how well it holds of each folder when it was fitted to the others.
    pub(super) fn markdown(&self) -> String {
        let Calibration { intercept, slopes, of_effect, of_model } = self.calibration;
        let mut text = format!(
            "Log-odds that a name is right: {} {}. Standard deviations: {} for effects, {} for \
             parameters of the model, in steps.\n\n",
            short(intercept),
            slopes
                .iter()
                .zip(FEATURES)
                .map(|(slope, name)| format!("{} {} x ({name})", sign(*slope), short(slope.abs())))
                .collect::<Vec<_>>()
                .join(" "),
            scale(&of_effect),
            scale(&of_model)
        );
        text += "| fitted without | names right | 95 % interval | stated | | error of stated \
                 probabilities | estimates inside 90 % intervals |\n|---|---|---|---|---|---|---|\n";
        let (mut unseen, mut strict) = (Vec::new(), Vec::new());
        for folder in &self.folders {
            // Fitted without the folder whose names are scored: a fit always suits its own data.
            let is_other = |other: &&Folder| other.name != folder.name;
            let others: Vec<&Folder> = self.folders.iter().filter(is_other).collect();
            let Some(calibration) = fit(&others) else { continue };
            let held = coverages(&calibration, folder);
            let names = stated(&calibration, &folder.names);
            text += &row(&format!("`{}` ({})", folder.name, folder.tier), &names, &held);
            strict.extend(stated(&calibration, &folder.strict));
            unseen.push((folder.tier, names, held));
        }
        // A tier pools its folders, each of them scored by the fit without it.
        for tier in ["plain", "home", OUTSIDE] {
            let of = || unseen.iter().filter(|(other, ..)| *other == tier);
            let names: Vec<_> = of().flat_map(|(_, names, _)| names.clone()).collect();
            let held: Vec<_> = of().flat_map(|(.., held)| held.clone()).collect();
            text += &row(&format!("each folder, all of {tier}"), &names, &held);
        }
        text += &row("each folder, all of outside, conventions aside", &strict, &[]);
        let names: Vec<_> = unseen.iter().flat_map(|(_, names, _)| names.clone()).collect();
        let held: Vec<_> = unseen.iter().flat_map(|(.., held)| held.clone()).collect();
        text + &row("each folder, all", &names, &held)
    }
}

fn sign(value: f64) -> char {
    if value < 0.0 { '-' } else { '+' }
}

fn scale(scale: &ErrorScale) -> String {
    format!("{} times the computed one and {} in quadrature", short(scale.factor), scale.floor)
}

fn row(title: &str, names: &[(f64, bool)], held: &[bool]) -> String {
    let stated = Stated::of(names);
    let held = Rate::from_outcomes(held.iter().copied());
    let held = match held.share {
        None => "-".to_owned(),
        Some(share) => format!("{}/{} ({})", held.of, held.n, super::table::percent(share)),
    };
    let right = &stated.right;
    format!(
        "| {title} | {}/{} | {:.3} to {:.3} | {} | {} | {} | {held} |\n",
        right.of,
        right.n,
        right.lo95,
        right.hi95,
        stated.mean.map_or_else(|| "-".to_owned(), |mean| format!("{mean:.3}")),
        // Outside: the mean of what was stated is not in the interval of the share that is right.
        if stated.holds() { "inside" } else { "**outside**" },
        calibration_error(&bins(names))
            .map_or_else(|| "-".to_owned(), |error| format!("{error:.3}"))
    )
}

/// The fit to some folders. Of too few estimates, errors keep the scale that is in use.
fn fit(folders: &[&Folder]) -> Option<Calibration> {
    let names: Vec<_> = folders.iter().flat_map(|folder| folder.names.clone()).collect();
    let errors = |of: fn(&Folder) -> &Vec<EstimateError>, kept: ErrorScale| {
        let errors: Vec<_> = folders.iter().flat_map(|folder| of(folder).clone()).collect();
        fit_errors(&errors, kept.floor).unwrap_or(kept)
    };
    let (intercept, slopes) = fit_probability(&names)?;
    Some(Calibration {
        intercept,
        slopes,
        of_effect: errors(|folder| &folder.of_effect, CALIBRATION.of_effect),
        of_model: errors(|folder| &folder.of_model, CALIBRATION.of_model),
    })
}

/// Probabilities that a fit states of names, and whether these are right.
fn stated(calibration: &Calibration, names: &[(FindingEvidence, bool)]) -> Vec<(f64, bool)> {
    let names = names.iter();
    names.map(|(evidence, is_right)| (calibration.probability(evidence), *is_right)).collect()
}

/// Whether each estimate of a folder is inside the interval that a fit makes of its error.
fn coverages(calibration: &Calibration, folder: &Folder) -> Vec<bool> {
    let of = |errors: &[EstimateError], scale: ErrorScale| -> Vec<bool> {
        errors.iter().map(|error| coverage(&[*error], &scale) == Some(1.0)).collect()
    };
    let of_effect = of(&folder.of_effect, calibration.of_effect);
    of_effect.into_iter().chain(of(&folder.of_model, calibration.of_model)).collect()
}

fn folders(root: &Path) -> Result<Vec<Folder>> {
    let path = root.join(STATED_BY);
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let fits: Vec<StatedBy> =
        serde_json::from_str(&text).with_context(|| path.display().to_string())?;
    // The fit of its commit turns a probability back into the evidence that it was stated for.
    let fit_of = |commit: &String| {
        let fit = fits.iter().find(|fit| fit.commits.contains(commit));
        fit.with_context(|| format!("{}: no fit of commit {commit}", path.display()))
    };
    let name = |dir: &PathBuf| dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let [plans, others] = stored::sources(root)?;
    let mut folders = Vec::new();
    for dir in &plans {
        let (opened, _) = stored::cases(std::slice::from_ref(dir))?;
        folders.push(Folder { name: name(dir), ..of_plan(&opened) });
    }
    for dir in &others {
        let opened = outside::read(std::slice::from_ref(dir))?;
        let names = |is_strict| -> Result<Vec<_>> {
            let mut names = Vec::new();
            for case in &opened {
                let by = &fit_of(&case.row.commit)?.calibration;
                // Without a gap afterwards there was no answer, and no probability.
                let Some(gap_after) = case.row.gap_after else { continue };
                let evidence = |(p, is_right)| (by.evidence(p, gap_after), is_right);
                names.extend(case.stated(is_strict).into_iter().map(evidence));
            }
            Ok(names)
        };
        let (names, strict) = (names(false)?, names(true)?);
        folders.push(Folder { name: name(dir), tier: OUTSIDE, names, strict, ..Folder::default() });
    }
    Ok(folders)
}

fn of_plan(opened: &[Opened]) -> Folder {
    Folder {
        name: String::new(),
        tier: opened.first().map_or("", |case| tier_name(case.truth.plan.tier)),
        names: names(opened),
        strict: Vec::new(),
        of_effect: misses(opened, ParameterOwner::OfEffect),
        of_model: misses(opened, ParameterOwner::OfModel),
    }
}

fn names(opened: &[Opened]) -> Vec<(FindingEvidence, bool)> {
    let of = |case: &Opened| -> Vec<(FindingEvidence, bool)> {
        let named = case.row.named();
        let evidence = named.filter_map(|effect| {
            Some((*case.row.evidence.get(&effect.name)?, case.truth.holds(&effect.name)))
        });
        evidence.collect()
    };
    opened.iter().flat_map(of).collect()
}

/// Errors of the estimated values of right names, in steps.
fn misses(opened: &[Opened], kind: ParameterOwner) -> Vec<EstimateError> {
    let of = |case: &Opened| -> Vec<EstimateError> {
        // Wrong names have no true value that an estimate could miss.
        let miss = |(finding, key, truth): &(String, String, f64)| {
            let estimate = case.estimate(finding, key)?.value;
            let raw = case.row.errors.get(finding)?.get(key)?.steps();
            let free_parameter = FreeParameter::by_name(finding, key)?;
            let parameter_kind = match free_parameter {
                FreeParameter::Model(_) => ParameterOwner::OfModel,
                FreeParameter::Effect(..) => ParameterOwner::OfEffect,
            };
            (parameter_kind == kind)
                .then(|| EstimateError { steps: free_parameter.steps(*truth, estimate), raw })
        };
        case.truth.values.iter().filter_map(miss).collect()
    };
    opened.iter().filter(|case| case.counts_for_error()).flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    /// Two folders of the plan, in which a name of a case in `wrong` is not there and has even odds.
    fn folders(wrong: usize) -> [Folder; 2] {
        let mut opened = example::opened();
        for case in opened.iter_mut().step_by(wrong) {
            for effect in &mut case.row.effects {
                let name = std::mem::replace(&mut effect.name, "no such effect".to_owned());
                let evidence = case.row.evidence.remove(&name);
                let wrong = evidence.map(|e| FindingEvidence { log_odds: 1.0, ..e });
                case.row.evidence.extend(wrong.map(|e| (effect.name.clone(), e)));
            }
        }
        let half = opened.len() / 2;
        let folder = |name: &str, of| Folder { name: name.to_owned(), ..of_plan(of) };
        [folder("a", &opened[..half]), folder("b", &opened[half..])]
    }

    #[test]
    fn values_that_are_two_percent_off_are_a_fraction_of_a_step_off() {
        let misses = misses(&example::opened(), ParameterOwner::OfEffect);
        // Steps of values on a logarithmic scale are 12 %.
        let step = 1.02_f64.ln() / 1.12_f64.ln();
        let near = misses.iter().filter(|miss| (miss.steps - step).abs() < 1e-9).count();
        assert!(near > misses.len() / 2, "{near} of {}", misses.len());
    }

    #[test]
    fn a_folder_that_a_fit_has_not_seen_is_stated_as_it_is_where_folders_are_alike() {
        let folders = folders(4).to_vec();
        let calibration = fit(&folders.iter().collect::<Vec<_>>()).unwrap();
        let fit = Fit { calibration, folders };
        let [stated, _] = fit.stated_without(&["b"], &["b"]).unwrap();
        assert!(stated.holds() && stated.right.n > 100, "{stated:?}");
        assert!(stated.right.of < stated.right.n, "{stated:?}");
        assert!(fit.markdown().contains("| `a` (plain) |"), "{}", fit.markdown());
    }

    #[test]
    fn without_a_wrong_name_there_is_no_fit() {
        let folders = folders(usize::MAX);
        // `step_by` begins with the first case, whose name alone is wrong.
        let [mut first, rest] = folders;
        first.names.retain(|(_, is_right)| *is_right);
        assert!(fit(&[&first, &rest]).is_none());
    }
}
