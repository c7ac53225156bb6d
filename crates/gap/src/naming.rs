//! What is missing: from a gap to a name, or to the words that there is none.
//!
//! Numbers of the model come first: what refitting them removes is a parameter. Then effects are
//! tried, fitted on one part of the data and judged on another, one after the other as long as each
//! makes things clearly better. A name is given only where it explains most of the gap and nothing
//! else does so as well.

use evpose_sensor::SensorConfig;

pub use crate::answer::reduction;
use crate::answer::{CLOSED, WIDE, answer, explained, is_partial, moved, without_parts};
use crate::hint::Hints;
use crate::parameters::Parameter;
use crate::search::{Found, judged, refit};
use crate::step::{LEAST_GAIN, accepted};
use crate::verdict::Answer;
use crate::{GapError, Lab};

/// Above this gap, a second effect is looked for. Simulators of one sensor are closer as a rule.
pub(crate) const AS_CHANCE: f64 = 0.3;
/// Above this gap, a second effect need not close all of it.
pub(crate) const OPEN: f64 = 0.44;
/// With more than this share of the misfit explained, what is left of a gap that is not wide may be
/// how finely the effect was simulated.
const NEARLY_ALL: f64 = 0.9;
/// At most so many effects are added.
const MOST_EFFECTS: usize = 2;
/// Runs that a model is judged by.
const RUNS: u64 = 4;

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
    /// The misfit without it.
    pub without: f64,
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
    pub(crate) fn judge(&self, model: &SensorConfig) -> Result<Judged, GapError> {
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
        let mut others = Vec::new();
        while named.steps.len() < MOST_EFFECTS && named.is_to_go_on(model) {
            say("trying every effect of the catalogue");
            let contenders = self.contenders(&named, model, &hints, left_out)?;
            if named.steps.is_empty() {
                others.clone_from(&contenders);
            }
            let Some(step) = accepted(&named, contenders) else { break };
            named.after = step.contenders[0].held.clone();
            named.steps.push(step);
        }
        if named.steps.len() == MOST_EFFECTS && is_partial(&named) {
            self.polish(&mut named)?;
        }
        if is_partial(&named) {
            say("trying two effects at once");
            if let Some(pair) = self.pair(&named, &others, model, &hints, left_out)? {
                named = pair;
            }
        }
        if !is_partial(&named) {
            self.exchange(&mut named)?;
        }
        without_parts(&mut named, model);
        named.moved = moved(model, &named.after.model, named.steps.is_empty());
        named.answer = answer(&named);
        Ok(named)
    }
}

impl Named {
    /// Whether what is left may be how finely the effects were simulated.
    pub(crate) fn is_nearly_closed(&self) -> bool {
        let is_rest = explained(&self.before, &self.after) > NEARLY_ALL && self.after.gap < WIDE;
        is_rest || self.after.gap < OPEN
    }

    /// Whether there is something left to be explained.
    fn is_to_go_on(&self, model: &SensorConfig) -> bool {
        if !self.steps.is_empty() {
            return self.after.gap > AS_CHANCE;
        }
        // Effects with noise of their own are taken for background where rates are free.
        let is_rate = |p: &Parameter| matches!(p, Parameter::NoiseOn | Parameter::NoiseOff);
        self.after.gap > CLOSED || moved(model, &self.after.model, true).iter().any(is_rate)
    }
}
