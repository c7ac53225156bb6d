//! The search as a whole.

use evpose_sensor::{Domain, SensorConfig};

use super::StageCallback;
use super::decision::is_within_tolerance;
use super::direct_estimates::DirectEstimates;
use super::elimination::{changed_parameters, eliminate};
use super::explanation::{Tested, TestedNames, explain};
use super::formula_terms::FORMULA;
use super::identification::{DataSplits, FittedCandidate, Identification, ModelScore, SCORE_RUNS};
use super::proposals::Proposals;
use super::recording_marks::Recording;
use super::refit::refit;
use super::screening::ScreeningBase;
use super::selection::{SelectedEffect, Selection};
use super::significance::unexplained;
use super::stepwise::Forward;
use super::swap_move::swap;
use crate::GapError;
use crate::fit::Fit;
use crate::free_parameter::FreeParameter;
use crate::parameters::ModelParameter;

/// Rounds of the joint fit of the final model.
const FINAL_ROUNDS: usize = 4;
/// Steps that a parameter was refitted by from which the catalogue is also screened beside the
/// parameters as given.
const FAR_OFF: f64 = 2.0;

impl DataSplits<'_> {
    /// Identifies the effects that `model` lacks; those of `left_out` are excluded from the search.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub fn identify(
        &self,
        model: &SensorConfig,
        left_out: &[String],
        progress: StageCallback<'_>,
    ) -> Result<Identification, GapError> {
        let before = self.score(model)?;
        // On both parts: a gap that one of them shows is a gap.
        let (_, gap_of_train) = self.train.score(model, SCORE_RUNS)?;
        if is_within_tolerance(&before) && gap_of_train <= super::decision::TOLERATED_GAP {
            return Identification::without_gap(self, before);
        }
        let known = self.train.reference_scene;
        let recording = Recording {
            events: &self.train.events,
            expected: &known.expected,
            scene: Some(&known.scene),
        };
        let estimates = DirectEstimates::from_recording(&recording);
        let mut selection = Selection::without_effects(self, model)?;
        self.add_proven(&mut selection, &estimates, left_out)?;
        progress("refitting the parameters of the model");
        let unfitted = selection.model.clone();
        let fit = refit(&self.train, &unfitted, 1)?;
        let refitted = self.score(&fit.model)?;
        // A refit that is worse on held-out data has learned noise.
        if refitted.discrepancy < selection.held_out.discrepancy {
            selection.model = fit.model;
            selection.train_discrepancy = fit.discrepancy;
            selection.held_out = refitted;
        }
        let refitted = selection.held_out.clone();
        progress("trying every effect of the catalogue");
        // A delay of the pixels is no offset of the clock: also start without one.
        let mut without_offset = selection.model.clone();
        let offset = ModelParameter::ClockOffset;
        offset.set(&mut without_offset, offset.value(model));
        // Nor are wrong thresholds what makes fewer events: start with the offset alone as well.
        let mut offset_alone = unfitted.clone();
        offset.set(&mut offset_alone, offset.value(&selection.model));
        let mut bases = vec![self.screening_base(&estimates, &refitted.model)?];
        let is_far_off = |parameter: &ModelParameter| {
            parameter.steps(parameter.value(model), parameter.value(&refitted.model)).abs()
                > FAR_OFF
        };
        if ModelParameter::ALL.iter().any(is_far_off) {
            // Beside parameters that absorbed an effect no effect shows what it does.
            bases.push(self.screening_base(&estimates, &unfitted)?);
        }
        let proposals = Proposals::screen(&bases, left_out)?;
        let chance = unexplained(&self.held_out, model)?.chance;
        let excess = before.discrepancy - chance;
        let forward =
            Forward { splits: self, proposals: &proposals, estimates: &estimates, excess, chance };
        let starts = [unfitted.clone(), without_offset, offset_alone];
        let mut is_cut = forward.run(&mut selection, &starts, progress)?;
        progress(&format!("testing: {}", selection.names()));
        selection.refine(self, model)?;
        selection.fit_together(self, FINAL_ROUNDS)?;
        let test = |selection: &Selection| self.tested(selection, &forward, &refitted);
        let mut tested = test(&selection)?;
        // Beside changed parameters, only an explanation that leaves nothing is complete.
        let is_complete = if tested.parameters.is_empty() {
            !forward.is_partial(&tested.selection)
        } else {
            is_within_tolerance(&tested.selection.held_out)
        };
        is_cut |= !is_complete && !self.allows_rivals();
        if !is_complete && self.allows_rivals() {
            let other = test(&forward.with_parameters_as_given(&tested.selection, progress)?)?;
            // Changed parameters are the plainer explanation: more effects must explain more, and
            // more than a refit without any.
            if other.selection.held_out.discrepancy < refitted.discrepancy
                && forward.is_worth_trying(&tested.selection, &other.selection)?
            {
                tested = other;
            }
        }
        forward.add_relatives(&mut tested.selection)?;
        let (is_swapped, mut compared) = swap(self, &mut tested.selection)?;
        if is_swapped {
            // Another effect changes what the others are worth.
            tested = test(&tested.selection)?;
            compared = swap(self, &mut tested.selection)?.1;
        }
        progress("testing each name by what only it does");
        let mut names = TestedNames::new(self, &tested)?;
        let failed: Vec<usize> =
            (0..tested.selection.effects.len()).filter(|i| names.is_failed(*i)).collect();
        let is_left = forward.is_partial(&tested.selection) || !failed.is_empty();
        if is_left && self.allows_rivals() && !left_out.iter().any(|name| name == FORMULA) {
            progress("looking for a formula of what has no name");
            let bare =
                Selection { given: model.clone(), ..Selection::without_effects(self, &unfitted)? };
            if let Some(with) = forward.formula(&tested.selection, &failed, &bare)? {
                let with = test(&with)?;
                // What is dropped again beside the others leaves the answer as it was.
                if with.selection.has(FORMULA) {
                    tested = with;
                    compared = swap(self, &mut tested.selection)?.1;
                    names = TestedNames::new(self, &tested)?;
                }
            }
        }
        progress("what each effect explains");
        explain(self, (tested, names), before, refitted, compared, excess, is_cut)
    }

    /// Drops from a selection what is not worth its name. Parameters of the model come first: one
    /// that is free to change without need takes over what a dropped effect explained. Where that
    /// leaves more than a refit of the parameters alone, `refitted`, effects come first.
    fn tested(
        &self,
        given: &Selection,
        forward: &Forward<'_>,
        refitted: &ModelScore,
    ) -> Result<Tested, GapError> {
        let mut selection = given.clone();
        let mut parameters = changed_parameters(self, &mut selection, forward.excess)?;
        selection.fit_together(self, FINAL_ROUNDS)?;
        let count = selection.effects.len();
        let mut dropped = eliminate(self, forward, &mut selection)?;
        if selection.effects.len() < count {
            // Parameters may explain something of what the dropped effects did.
            let mut again = selection.clone();
            let changed = changed_parameters(self, &mut again, forward.excess)?;
            if again.fitted != selection.fitted {
                (selection, parameters) = (again, changed);
                dropped = eliminate(self, forward, &mut selection)?;
            }
        }
        if selection.held_out.discrepancy > refitted.discrepancy {
            selection = Selection { fitted: ModelParameter::ALL.to_vec(), ..given.clone() };
            selection.fit_together(self, FINAL_ROUNDS)?;
            dropped = eliminate(self, forward, &mut selection)?;
            parameters = changed_parameters(self, &mut selection, forward.excess)?;
        }
        Ok(Tested { selection, dropped, parameters })
    }

    fn screening_base<'a>(
        &'a self,
        estimates: &'a DirectEstimates,
        model: &'a SensorConfig,
    ) -> Result<ScreeningBase<'a>, GapError> {
        ScreeningBase::new(&self.screen, estimates, model, FreeParameter::of_model())
    }

    fn allows_rivals(&self) -> bool {
        self.budget.is_none_or(|budget| budget.allows_rivals())
    }

    /// Adds what the time stamps prove, so that it hides nothing else.
    fn add_proven(
        &self,
        selection: &mut Selection,
        estimates: &DirectEstimates,
        left_out: &[String],
    ) -> Result<(), GapError> {
        for (name, forms) in estimates.proven(&selection.model, left_out) {
            // The lines of a readout are a grid of their own, and no clock.
            let is_clock = forms.iter().any(|trial| trial.spec.domain == Domain::Clock);
            if is_clock && selection.effects.iter().any(|effect| effect.candidate.is_readout()) {
                continue;
            }
            let mut fitted = Vec::new();
            for trial in forms {
                let model = trial.added_to(&selection.model);
                let discrepancy = self.train.discrepancy(&model, 1)?;
                fitted.push(FittedCandidate { name, fit: Fit { model, discrepancy }, trial });
            }
            let best =
                fitted.into_iter().min_by(|a, b| a.fit.discrepancy.total_cmp(&b.fit.discrepancy));
            let Some(candidate) = best else { continue };
            let held_out = self.score(&candidate.fit.model)?;
            // A wrong readout is worse than none, whatever the time stamps say.
            if held_out.discrepancy < selection.held_out.discrepancy {
                selection.model.clone_from(&candidate.fit.model);
                selection.train_discrepancy = candidate.fit.discrepancy;
                selection.held_out = held_out;
                selection.effects.push(SelectedEffect {
                    candidate,
                    rivals: Vec::new(),
                    is_proven: true,
                });
            }
        }
        Ok(())
    }
}
