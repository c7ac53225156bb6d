//! A model with the effects that were selected so far, fitted to the training data.

use evpose_sensor::SensorConfig;

use super::identification::{DataSplits, FittedCandidate, ModelScore};
use super::initial_guess::with_thresholds;
use crate::GapError;
use crate::candidate::without_effect;
use crate::fit::{Fit, descend};
use crate::free_parameter::FreeParameter;
use crate::parameters::ModelParameter;

/// An effect of a selection, and the candidates that came next when it was selected.
#[derive(Debug, Clone)]
pub(super) struct SelectedEffect {
    pub(super) candidate: FittedCandidate,
    /// Other candidates for its place, the best first.
    pub(super) rivals: Vec<FittedCandidate>,
    /// Whether the time stamps prove it, with its parameters, which are then not fitted.
    pub(super) is_proven: bool,
}

#[derive(Debug, Clone)]
pub(super) struct Selection {
    pub(super) given: SensorConfig,
    /// The model, fitted to the training data.
    pub(super) model: SensorConfig,
    /// Its discrepancy there.
    pub(super) train_discrepancy: f64,
    pub(super) held_out: ModelScore,
    /// Its effects, in the order in which they were selected.
    pub(super) effects: Vec<SelectedEffect>,
    /// Parameters of the model that are fitted; the others stay as they are.
    pub(super) fitted: Vec<ModelParameter>,
}

impl Selection {
    /// A model without added effects.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn without_effects(
        splits: &DataSplits<'_>,
        model: &SensorConfig,
    ) -> Result<Self, GapError> {
        Ok(Self {
            given: model.clone(),
            model: model.clone(),
            train_discrepancy: splits.train.discrepancy(model, 1)?,
            held_out: splits.score(model)?,
            effects: Vec::new(),
            fitted: ModelParameter::ALL.to_vec(),
        })
    }

    /// Discrepancy on training and held-out data together, by which rivals are compared.
    pub(super) fn discrepancy(&self) -> f64 {
        self.train_discrepancy + self.held_out.discrepancy
    }

    pub(super) fn names(&self) -> String {
        let names: Vec<&str> = self.effects.iter().map(|effect| effect.candidate.name).collect();
        if names.is_empty() { "the model".to_owned() } else { names.join(" + ") }
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.effects.iter().any(|effect| effect.candidate.name == name)
    }

    /// The fitted parameters of the model, but for the offset of its clock, which is fitted at the
    /// beginning alone.
    pub(super) fn free_parameters_of_model(&self) -> Vec<FreeParameter> {
        let is_fitted = |free: &FreeParameter| self.fitted.iter().any(|one| free.is_model(*one));
        FreeParameter::of_model().into_iter().filter(is_fitted).collect()
    }

    /// The fitted parameters of the model and of all selected effects.
    pub(super) fn free_parameters(&self) -> Vec<FreeParameter> {
        let mut free = self.free_parameters_of_model();
        let fitted = self.effects.iter().filter(|effect| !effect.is_proven);
        free.extend(fitted.flat_map(|effect| FreeParameter::of_effect(&effect.candidate.trial)));
        free
    }

    /// Fits all parameters together and scores the model again.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn fit_together(
        &mut self,
        splits: &DataSplits<'_>,
        rounds: usize,
    ) -> Result<(), GapError> {
        let free = self.free_parameters();
        // Gradient descent does not cross a threshold error of a third.
        let mut start = self.model.clone();
        let thresholds = [ModelParameter::ThresholdOn, ModelParameter::ThresholdOff];
        // Counts set both, so both have to be free.
        if thresholds.iter().all(|threshold| self.fitted.contains(threshold)) {
            let counted = with_thresholds(&splits.train, &self.model)?;
            // Effects change counts, too: only where it helps.
            if splits.train.discrepancy(&counted, 1)? < splits.train.discrepancy(&start, 1)? {
                start = counted;
            }
        }
        let fit = descend(&splits.train, &start, &free, None, 1, rounds)?;
        self.train_discrepancy = fit.discrepancy;
        if fit.model != self.model || self.held_out.model != self.model {
            self.model = fit.model;
            self.held_out = splits.score(&self.model)?;
        }
        Ok(())
    }

    /// Adds parameters of each effect that help, drops those that do not, and gives effects that
    /// are faster than the frames of the scene their short time steps.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn refine(
        &mut self,
        splits: &DataSplits<'_>,
        given: &SensorConfig,
    ) -> Result<(), GapError> {
        let train = &splits.train;
        for effect in self.effects.iter_mut().filter(|effect| !effect.is_proven) {
            let candidate = &mut effect.candidate;
            candidate.fit =
                Fit { model: self.model.clone(), discrepancy: train.discrepancy(&self.model, 1)? };
            candidate.add_parameters(train, given)?;
            candidate.drop_parameters(train, given)?;
            // Short steps come last, since every run with them takes several times as long.
            candidate.refine_time_steps(train)?;
            self.model.clone_from(&candidate.fit.model);
            self.train_discrepancy = candidate.fit.discrepancy;
        }
        self.held_out = splits.score(&self.model)?;
        Ok(())
    }

    /// The selection without effect number `i`, its other parameters fitted again.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn without(
        &self,
        splits: &DataSplits<'_>,
        i: usize,
        rounds: usize,
    ) -> Result<Self, GapError> {
        let mut rest = self.clone();
        let dropped = rest.effects.remove(i);
        rest.model = without_effect(&self.model, &self.given, dropped.candidate.name);
        rest.fit_together(splits, rounds)?;
        Ok(rest)
    }
}
