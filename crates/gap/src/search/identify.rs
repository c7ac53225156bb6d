//! The search as a whole.

use evpose_sensor::{Domain, SensorConfig};

use super::StageCallback;
use super::decision::is_within_tolerance;
use super::direct_estimates::DirectEstimates;
use super::elimination::{changed_parameters, eliminate};
use super::explanation::{SearchResults, explain};
use super::identification::{DataSplits, FittedCandidate, Identification, SCORE_RUNS};
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

/// Effects that are added at most.
const MAX_EFFECTS: usize = 10;
/// Rounds of the joint fit of the final model.
const FINAL_ROUNDS: usize = 4;

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
        let estimates = DirectEstimates::from_recording(self.train.catalogue(), &recording);
        let mut selection = Selection::without_effects(self, model)?;
        self.add_proven(&mut selection, &estimates, left_out)?;
        progress("refitting the parameters of the model");
        let unfitted = selection.model.clone();
        let fit = refit(&self.train, &unfitted, 1)?;
        let refitted = self.score(&fit.model)?;
        if refitted.discrepancy < selection.held_out.discrepancy {
            selection.model = fit.model;
            selection.train_discrepancy = fit.discrepancy;
            selection.held_out = refitted;
        }
        let refitted = selection.held_out.clone();
        progress("trying every effect of the catalogue");
        let nuisance = FreeParameter::of_model();
        let base = ScreeningBase::new(&self.screen, &estimates, &refitted.model, nuisance)?;
        let proposals = Proposals::screen(&base, left_out)?;
        let excess = before.discrepancy - unexplained(&self.held_out, model)?.chance;
        let forward =
            Forward { splits: self, proposals: &proposals, estimates: &estimates, excess };
        // A delay of the pixels is no offset of the clock: also start without one.
        let mut without_offset = selection.model.clone();
        let offset = ModelParameter::ClockOffset;
        offset.set(&mut without_offset, offset.value(model));
        // Nor are wrong thresholds what makes fewer events: start with the offset alone as well.
        let mut offset_alone = unfitted.clone();
        offset.set(&mut offset_alone, offset.value(&selection.model));
        let starts = [unfitted, without_offset, offset_alone];
        let mut is_cut = false;
        while selection.effects.len() < MAX_EFFECTS && !is_within_tolerance(&selection.held_out) {
            if self.budget.is_some_and(|budget| !budget.allows_finding()) {
                is_cut = true;
                break;
            }
            progress(&format!("adding an effect to: {}", names(&selection)));
            if !forward.step(&mut selection, &starts)? {
                break;
            }
        }
        progress(&format!("testing: {}", names(&selection)));
        if self.budget.is_none_or(|budget| budget.allows_rivals()) {
            swap(self, &mut selection)?;
        }
        selection.refine(self, model)?;
        selection.fit_together(self, FINAL_ROUNDS)?;
        let tried = proposals.len();
        let mut dropped = eliminate(self, &estimates, &mut selection, excess, tried)?;
        let mut parameters = changed_parameters(self, &mut selection, model, excess)?;
        let is_complete = parameters.is_empty() || is_within_tolerance(&selection.held_out);
        if !is_complete
            && self.budget.is_none_or(|budget| budget.allows_rivals())
            && forward.replace_parameters(&mut selection, &parameters)?
        {
            while selection.effects.len() < MAX_EFFECTS && forward.step(&mut selection, &[])? {}
            dropped = eliminate(self, &estimates, &mut selection, excess, tried)?;
            parameters = changed_parameters(self, &mut selection, model, excess)?;
        }
        let (is_swapped, compared) = swap(self, &mut selection)?;
        let dropped = if is_swapped {
            eliminate(self, &estimates, &mut selection, excess, tried)?
        } else {
            dropped
        };
        let compared = if is_swapped { swap(self, &mut selection)?.1 } else { compared };
        progress("what each effect explains");
        explain(
            self,
            SearchResults {
                before,
                refitted,
                selection,
                dropped,
                compared,
                parameters,
                excess,
                is_cut,
            },
        )
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

/// Names of the selected effects.
fn names(selection: &Selection) -> String {
    let names: Vec<&str> = selection.effects.iter().map(|effect| effect.candidate.name).collect();
    if names.is_empty() { "the model".to_owned() } else { names.join(" + ") }
}
