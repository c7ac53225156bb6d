//! What is missing: from a gap to a name, or to the words that there is none.
//!
//! Numbers of the model come first: what refitting them removes is a parameter. Then effects are
//! tried, fitted on one part of the data and judged on another, one after the other as long as each
//! makes things clearly better. A name is given only where it explains most of the gap and nothing
//! else does so as well.

use evpose_sensor::SensorConfig;

use crate::closeness::distance;
use crate::fit::Fit;
use crate::hint::Hints;
use crate::parameters::Parameter;
use crate::search::{Found, judged, refit, search};
use crate::verdict::Answer;
use crate::{GapError, Lab};

/// Below this gap there is none: differences are within chance and tolerance. Two independent
/// simulators of the ideal sensor are 0.02 to 0.3 apart.
const CLOSED: f64 = 0.36;
/// Above this gap, a second effect is looked for.
const OPEN: f64 = 0.44;
/// Above this gap, something that matters is missing.
const WIDE: f64 = 0.9;
/// With more than this share of the misfit explained, a gap that is not wide is no second effect.
const NEARLY_ALL: f64 = 0.9;
/// A gain of the held-out misfit below this is none, whatever the share.
const LEAST_GAIN: f64 = 35.0;
/// An effect explains at least this share of the misfit that was left.
const LEAST_SHARE: f64 = 0.18;
/// The same where there is no gap any more, and for a second effect: what is left of the first may
/// be how it was simulated.
const LEAST_SHARE_OF_REST: f64 = 0.4;
/// Two candidates whose gains differ by less than this share cannot be told apart.
const AS_GOOD: f64 = 0.12;
/// Of these, one whose events are so much closer to the measured ones is the one.
const CLOSER: f64 = 0.92;
/// With less than this share of the misfit explained and the gap still open, what was found is not
/// what is missing: a relative of the true effect goes part of the way.
const EXPLAINS: f64 = 0.74;
/// The same where the gap is still wide.
const EXPLAINS_WIDE: f64 = 0.8;
/// At most so many effects are added.
const MOST_EFFECTS: usize = 2;
/// Runs that a model is judged by.
const RUNS: u64 = 4;
/// Beyond the best and one rival, candidates with a misfit so many times that of the best are not.
const FAR_BEHIND: f64 = 5.0;
/// Another form of a candidate is judged too if its misfit is at most so many times that of the best.
const FORMS: f64 = 1.5;
/// Candidates that are judged on what was held out.
const JUDGED: usize = 6;

/// The parts of the data that naming works on.
#[derive(Debug)]
pub struct Bench<'a> {
    /// A short part of the training data, for first tries.
    pub screen: Lab<'a>,
    /// What models are fitted to.
    pub train: Lab<'a>,
    /// What they are judged on.
    pub held: Lab<'a>,
}

/// A model and how well it does on what was held out.
#[derive(Debug, Clone)]
pub struct Judged {
    /// The model.
    pub model: SensorConfig,
    /// Its misfit.
    pub misfit: f64,
    /// Its gap.
    pub gap: f64,
}

/// One candidate, fitted and judged.
#[derive(Debug, Clone)]
pub struct Contender {
    /// The candidate.
    pub found: Found,
    /// What it does on what was held out.
    pub held: Judged,
}

/// One effect that was added.
#[derive(Debug, Clone)]
pub struct Step {
    /// All that were judged, the best first.
    pub contenders: Vec<Contender>,
    /// Names that do as well as the best.
    pub confusable: Vec<&'static str>,
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Named {
    /// The answer in one word.
    pub answer: Answer,
    /// The model as given.
    pub before: Judged,
    /// The model with its own numbers refitted.
    pub refitted: Judged,
    /// Effects in the order in which they were added.
    pub steps: Vec<Step>,
    /// The corrected model.
    pub after: Judged,
    /// Numbers of the model that had to move.
    pub moved: Vec<Parameter>,
}

impl Bench<'_> {
    fn judge(&self, model: &SensorConfig) -> Result<Judged, GapError> {
        let (misfit, gap) = judged(&self.held, model, RUNS)?;
        Ok(Judged { model: model.clone(), misfit, gap })
    }

    /// Finds what `model` lacks; effects of `left_out` are not looked for.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn name(
        &self,
        model: &SensorConfig,
        left_out: &[String],
        say: &dyn Fn(&str),
    ) -> Result<Named, GapError> {
        let before = self.judge(model)?;
        let (_, gap_of_train) = judged(&self.train, model, RUNS)?;
        if before.gap.max(gap_of_train) <= CLOSED {
            return Ok(Named {
                answer: Answer::NoGap,
                refitted: before.clone(),
                after: before.clone(),
                steps: Vec::new(),
                moved: Vec::new(),
                before,
            });
        }
        say("refitting the numbers of the model");
        let fit = refit(&self.train, model, 1)?;
        let mut refitted = self.judge(&fit.model)?;
        if refitted.misfit > before.misfit - LEAST_GAIN {
            refitted = before.clone();
        }
        let mut named = Named {
            answer: Answer::NoGap,
            moved: Vec::new(),
            after: refitted.clone(),
            steps: Vec::new(),
            before,
            refitted,
        };
        let hints = Hints::of(&self.train.events);
        while named.steps.len() < MOST_EFFECTS && self.is_to_go_on(&named, model) {
            say("trying every effect of the catalogue");
            let Some(step) = self.step(&named, model, &hints, left_out)? else { break };
            named.after = step.contenders[0].held.clone();
            named.steps.push(step);
        }
        if named.steps.len() < MOST_EFFECTS
            && is_partial(&named)
            && let Some(other) = self.behind_a_readout(&named, model, &hints, left_out)?
        {
            named = other;
        }
        without_parts(&mut named, model);
        named.moved = moved(model, &named.after.model, named.steps.is_empty());
        named.answer = answer(&named);
        Ok(named)
    }

    /// Another effect with a readout that stamps leave no doubt about: alone neither may help, since
    /// pixels that have more events than the camera's keep its bus busier.
    fn behind_a_readout(
        &self,
        named: &Named,
        model: &SensorConfig,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<Option<Named>, GapError> {
        let Some((name, trial)) = hints.sure(&named.refitted.model, left_out) else {
            return Ok(None);
        };
        let with = trial.beside(&named.before.model);
        let fit = Fit { misfit: judged(&self.train, &with, 1)?.0, model: with.clone() };
        let held = self.judge(&with)?;
        let mut behind = named.clone();
        behind.after = held.clone();
        let contenders = vec![Contender { found: Found { name, fit, trial }, held }];
        behind.steps = vec![Step { contenders, confusable: Vec::new() }];
        let Some(step) = self.step(&behind, model, hints, left_out)? else { return Ok(None) };
        behind.after = step.contenders[0].held.clone();
        behind.steps.push(step);
        Ok((!is_partial(&behind) && behind.after.misfit < named.after.misfit).then_some(behind))
    }

    /// Whether there is something left to be explained.
    fn is_to_go_on(&self, named: &Named, model: &SensorConfig) -> bool {
        let is_first = named.steps.is_empty();
        let is_open = named.after.gap > if is_first { CLOSED } else { OPEN };
        // What is left of a large gap may be how finely the effect was simulated.
        let is_rest = explained(&named.before, &named.after) > NEARLY_ALL && named.after.gap < WIDE;
        // Effects with noise of their own are taken for background where rates are free.
        let rates = [Parameter::NoiseOn, Parameter::NoiseOff];
        let is_refitted = |found: Vec<Parameter>| found.iter().any(|p| rates.contains(p));
        let is_noise = || is_refitted(moved(model, &named.after.model, true));
        if is_first { is_open || is_noise() } else { is_open && !is_rest }
    }

    /// The next effect, if one makes things clearly better.
    fn step(
        &self,
        named: &Named,
        model: &SensorConfig,
        hints: &Hints,
        left_out: &[String],
    ) -> Result<Option<Step>, GapError> {
        let mut starts = vec![named.after.model.clone()];
        // An effect may do what a refit of the numbers has taken on itself.
        let given = with_given_numbers(&named.after.model, model);
        if given != named.after.model {
            starts.push(given);
        }
        let found = search(&self.screen, &self.train, model, &starts, hints, left_out)?;
        let mut contenders: Vec<Contender> = Vec::new();
        for found in found {
            // Forms of one effect that differ by little here may differ by much in another scene.
            let is_known = |other: &Contender| {
                other.found.name == found.name
                    && (other.found.trial.is_form_of(&found.trial)
                        || found.fit.misfit > FORMS * other.found.fit.misfit + LEAST_GAIN)
            };
            if contenders.iter().any(is_known) {
                continue;
            }
            let least = contenders.iter().map(|c| c.found.fit.misfit).fold(f64::INFINITY, f64::min);
            if contenders.len() > 1 && found.fit.misfit > FAR_BEHIND * least {
                break;
            }
            let held = self.judge(&found.fit.model)?;
            contenders.push(Contender { found, held });
            if contenders.len() == JUDGED {
                break;
            }
        }
        contenders.sort_by(|a, b| a.held.misfit.total_cmp(&b.held.misfit));
        let mut names = Vec::new();
        contenders.retain(|one| {
            let is_new = !names.contains(&one.found.name);
            names.push(one.found.name);
            is_new
        });
        let Some(best) = contenders.first() else { return Ok(None) };
        let gain = named.after.misfit - best.held.misfit;
        if named.steps.is_empty() {
            self.closest_first(&mut contenders, gain)?;
        }
        let best = &contenders[0];
        // What numbers of the model close already has to be much better another way.
        let is_open = named.after.gap > CLOSED;
        let is_first = named.steps.is_empty();
        let least_share = if is_open && is_first { LEAST_SHARE } else { LEAST_SHARE_OF_REST };
        if gain < LEAST_GAIN.max(least_share * named.after.misfit) {
            return Ok(None);
        }
        let is_as_good = |other: &&Contender| is_as_good(other, best, gain);
        let confusable = contenders.iter().skip(1).filter(is_as_good).map(|c| c.found.name);
        let confusable = confusable.collect();
        Ok(Some(Step { contenders, confusable }))
    }

    /// Puts the candidate first whose events are closest to the measured ones, of those that are as
    /// good as the first.
    fn closest_first(&self, contenders: &mut [Contender], gain: f64) -> Result<(), GapError> {
        let best = &contenders[0];
        let rivals = contenders.iter().skip(1).take_while(|other| is_as_good(other, best, gain));
        let (mut first, mut least) = (0, None);
        for i in 1..=rivals.count() {
            let of_first = match least {
                Some(known) => known,
                None => distance(&self.held, &contenders[0].held.model)?,
            };
            let other = distance(&self.held, &contenders[i].held.model)?;
            let is_closer = other < CLOSER * of_first;
            (first, least) = if is_closer { (i, Some(other)) } else { (first, Some(of_first)) };
        }
        contenders[..=first].rotate_right(1);
        Ok(())
    }
}

/// Whether two candidates cannot be told apart by what was held out, of which the better gains so
/// much.
fn is_as_good(other: &Contender, best: &Contender, gain: f64) -> bool {
    other.held.misfit - best.held.misfit < (AS_GOOD * gain).max(LEAST_GAIN / 2.0)
}

/// A model with the numbers that `given` has anyway.
fn with_given_numbers(model: &SensorConfig, given: &SensorConfig) -> SensorConfig {
    let mut model = model.clone();
    for parameter in Parameter::ALL {
        parameter.set(&mut model, parameter.value(given));
    }
    model
}

/// Numbers that differ between two models by more than chance would move them.
fn moved(from: &SensorConfig, to: &SensorConfig, all: bool) -> Vec<Parameter> {
    let least = if all { 0.8 } else { 1.5 };
    let is_moved = |parameter: &&Parameter| {
        parameter.steps(parameter.value(from), parameter.value(to)).abs() >= least
    };
    Parameter::ALL.iter().filter(is_moved).copied().collect()
}

/// The share of the gap that is gone.
pub fn reduction(before: &Judged, after: &Judged) -> f64 {
    let excess = |gap: f64| (gap - CLOSED).max(0.0);
    if excess(before.gap) > 0.0 {
        1.0 - excess(after.gap) / excess(before.gap)
    } else {
        explained(before, after)
    }
}

/// The share of the misfit that is gone.
fn explained(before: &Judged, after: &Judged) -> f64 {
    1.0 - after.misfit / before.misfit.max(1e-9)
}

/// Whether what was found leaves too much.
fn is_partial(named: &Named) -> bool {
    let least = if named.after.gap > WIDE { EXPLAINS_WIDE } else { EXPLAINS };
    named.after.gap > CLOSED && explained(&named.before, &named.after) < least
}

/// The answer, from what moved and what was added.
fn answer(named: &Named) -> Answer {
    let is_open = named.after.gap > CLOSED;
    let is_wide = named.after.gap > WIDE;
    match (named.steps.len(), named.moved.is_empty()) {
        (0, true) if is_wide => Answer::NoneOfCatalogue,
        (0, true) if is_open => Answer::Undecided,
        (0, true) => Answer::NoGap,
        _ if is_partial(named) => Answer::NoneOfCatalogue,
        (0, false) => Answer::Parameter,
        _ if named.steps.iter().any(|step| step.confusable.len() > 2) => Answer::Undecided,
        _ => Answer::Effects,
    }
}

/// Effects that explain only a part of what numbers of the model leave are taken back, if these
/// explain most of the whole.
fn without_parts(named: &mut Named, model: &SensorConfig) {
    let is_part = !named.steps.is_empty()
        && named.after.gap > CLOSED
        && explained(&named.refitted, &named.after) < EXPLAINS;
    let numbers_do =
        explained(&named.before, &named.refitted) > EXPLAINS && named.refitted.gap < WIDE;
    if is_part && numbers_do && !moved(model, &named.refitted.model, true).is_empty() {
        named.steps.clear();
        named.after = named.refitted.clone();
    }
}
