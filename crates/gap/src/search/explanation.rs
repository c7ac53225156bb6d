//! The explanation: what each effect and parameter explains, and what is left.

use super::decision::{Findings, Worth, decide, fraction_left, is_left_significant};
use super::elimination::Dropped;
use super::identification::{
    AddedEffect, ChangedParameter, Contender, DataSplits, ExplainedFraction, FittedCandidate,
    Identification, Left, ModelScore,
};
use super::selection::Selection;
use super::significance::unexplained;
use super::swap_move::Compared;
use crate::GapError;
use crate::candidate::Trial;
use crate::fit::{Fit, descend};
use crate::free_parameter::FreeParameter;
use crate::goodness::{NameTests, control_false_names};
use crate::parameters::ModelParameter;
use crate::verdict::{Answer, SignatureTest};

/// Rounds of the fit of an effect alone.
const ROUNDS: usize = 2;

/// A selection whose effects are all significant.
pub(super) struct Tested {
    pub(super) selection: Selection,
    /// Evidence for each effect.
    pub(super) dropped: Vec<Dropped>,
    pub(super) parameters: Vec<(ModelParameter, Worth)>,
}

/// Tests of the names of a selection, in its order; none of a name without a test.
pub(super) struct TestedNames {
    effects: Vec<Option<SignatureTest>>,
    parameters: Vec<Option<SignatureTest>>,
}

impl TestedNames {
    /// Tests each name by the signature of its effect, and all together.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn new(splits: &DataSplits<'_>, tested: &Tested) -> Result<Self, GapError> {
        let Tested { selection, dropped, parameters } = tested;
        if selection.effects.is_empty() && parameters.is_empty() {
            return Ok(Self { effects: Vec::new(), parameters: Vec::new() });
        }
        let tests = NameTests::new(&splits.held_out, &selection.model)?;
        let names = selection.effects.iter().map(|effect| effect.candidate.name);
        let effects = names.zip(dropped).map(|(name, one)| tests.test(name, &one.rest.model));
        let mut effects = effects.collect::<Result<Vec<_>, GapError>>()?;
        let p = dropped.iter().map(|one| one.worth.difference.p);
        let named = effects.iter_mut().zip(p).filter_map(|(test, p)| Some((test.as_mut()?, p)));
        control_false_names(&mut named.collect::<Vec<_>>());
        let parameters = parameters.iter().map(|(parameter, _)| tests.test_parameter(*parameter));
        Ok(Self { effects, parameters: parameters.collect() })
    }

    /// Whether the name of effect number `i` failed its test.
    pub(super) fn is_failed(&self, i: usize) -> bool {
        self.effects[i].as_ref().is_some_and(|test| !test.passes)
    }
}

/// Turns the result of the search into an identification; `is_cut` where its time was over.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub(super) fn explain(
    splits: &DataSplits<'_>,
    (tested, names): (Tested, TestedNames),
    before: ModelScore,
    refitted: ModelScore,
    compared: Vec<Compared>,
    excess: f64,
    is_cut: bool,
) -> Result<Identification, GapError> {
    let Tested { selection, dropped, parameters } = tested;
    let explained = |alone: &ModelScore, worth: &Worth| ExplainedFraction {
        alone: (before.discrepancy - alone.discrepancy) / excess.max(1e-9),
        beside_others: worth.fraction(),
        p: worth.difference.p,
        worsened: worth.difference.worsened,
    };
    let after = selection.held_out.clone();
    let mut added_effects = Vec::new();
    let evidence = dropped.into_iter().zip(compared).zip(names.effects);
    for (effect, ((dropped, compared), test)) in selection.effects.iter().zip(evidence) {
        let own = selection.model.effect(effect.candidate.name);
        // With the values of the joint fit: the candidate's own are from before others were added.
        let trial = Trial {
            effect: own.unwrap_or(&effect.candidate.trial.effect).clone(),
            ..effect.candidate.trial.clone()
        };
        let free = FreeParameter::of_effect(&trial);
        // Alone it is fitted once more: its strength beside the others would overshoot without
        // them.
        let alone = trial.added_to(&before.model);
        let alone = descend(&splits.train, &alone, &free, None, 1, ROUNDS)?;
        let alone = splits.score(&alone.model)?;
        let fit = Fit { model: selection.model.clone(), discrepancy: selection.train_discrepancy };
        let candidate = FittedCandidate { name: effect.candidate.name, fit, trial };
        let mut contenders = vec![Contender { candidate, held_out: after.clone() }];
        contenders.extend(compared.rivals);
        added_effects.push(AddedEffect {
            contenders,
            confusable: compared.confusable,
            discrepancy_without: dropped.rest.held_out.discrepancy,
            model_without: dropped.rest.model,
            test,
            explained: explained(&alone, &dropped.worth),
        });
    }
    added_effects.sort_by(|a, b| b.explained.beside_others.total_cmp(&a.explained.beside_others));
    let mut changed_parameters = Vec::new();
    for ((parameter, worth), test) in parameters.into_iter().zip(names.parameters) {
        let mut alone = before.model.clone();
        parameter.set(&mut alone, parameter.value(&after.model));
        let alone = splits.score(&alone)?;
        let explained = explained(&alone, &worth);
        changed_parameters.push(ChangedParameter { parameter, explained, test });
    }
    // The part that is left is relative to chance: replicates of a perfect model have a discrepancy
    // too.
    let left = unexplained(&splits.held_out, &after.model)?;
    let left = Left {
        fraction: fraction_left(&before, &after, &left),
        p: left.p,
        is_significant: is_left_significant(&after, &left),
    };
    let findings = findings(&added_effects, &changed_parameters);
    Ok(Identification {
        answer: decide(&findings, &left),
        before,
        refitted,
        added_effects,
        after,
        changed_parameters,
        left,
        is_cut,
    })
}

fn findings(effects: &[AddedEffect], parameters: &[ChangedParameter]) -> Findings {
    let (named, unnamed): (Vec<_>, Vec<_>) = effects.iter().partition(|added| added.is_named());
    let demoted = parameters.iter().filter(|changed| changed.is_demoted());
    let unnamed = unnamed.iter().map(|added| added.explained);
    let unnamed = unnamed.chain(demoted.map(|changed| changed.explained));
    Findings {
        confusable: named.iter().map(|added| added.confusable.len()).collect(),
        parameters: parameters.iter().filter(|changed| !changed.is_demoted()).count(),
        unnamed: unnamed.map(|explained| explained.beside_others).reduce(|a, b| a + b),
    }
}

impl Identification {
    /// The identification of a model that explains the recording as it is.
    ///
    /// # Errors
    /// A model that cannot be shown the scene.
    pub(super) fn without_gap(
        splits: &DataSplits<'_>,
        before: ModelScore,
    ) -> Result<Self, GapError> {
        // All of the (tolerable) gap is left, since nothing was changed.
        let left = unexplained(&splits.held_out, &before.model)?;
        let is_significant = is_left_significant(&before, &left);
        Ok(Self {
            answer: Answer::NoGap,
            refitted: before.clone(),
            after: before.clone(),
            added_effects: Vec::new(),
            changed_parameters: Vec::new(),
            left: Left { fraction: 1.0, p: left.p, is_significant },
            is_cut: false,
            before,
        })
    }
}
