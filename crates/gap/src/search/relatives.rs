//! Relatives of an effect: those that are known by the same signature.
//!
//! A test by a signature does not distinguish them, and the one that came first may be the wrong one: light that
//! is spread over the image and a current in the dark both take contrast where it is dark. So each is a rival
//! of the others, whether it did well when the effect was selected or not.

use evpose_sensor::STAGES;

use super::identification::FittedCandidate;
use super::selection::Selection;
use super::stepwise::Forward;
use crate::GapError;
use crate::candidate::without_effect;
use crate::search_spec::Searched;

/// Whether two effects are known by one signature.
pub(super) fn are_relatives(first: &str, second: &str) -> bool {
    let signatures = |name: &str| {
        STAGES
            .entries()
            .iter()
            .find(|spec| spec.name == name)
            .map_or(&[][..], |spec| spec.search().shows)
    };
    let other = signatures(second);
    signatures(first).iter().any(|one| other.iter().any(|two| std::ptr::eq(*one, *two)))
}

impl Forward<'_> {
    /// Makes the relatives of each effect of a selection the first of its rivals.
    ///
    /// # Errors
    /// A model that cannot be built or shown the scene.
    pub(super) fn add_relatives(&self, selection: &mut Selection) -> Result<(), GapError> {
        for i in 0..selection.effects.len() {
            let relatives = self.relatives(selection, i)?;
            let rivals = &mut selection.effects[i].rivals;
            rivals.retain(|rival| relatives.iter().all(|one| one.name != rival.name));
            rivals.splice(0..0, relatives);
        }
        Ok(())
    }

    /// The relatives of effect number `i` in its place, fitted, each once.
    fn relatives(&self, selection: &Selection, i: usize) -> Result<Vec<FittedCandidate>, GapError> {
        let name = selection.effects[i].candidate.name;
        let is_relative = |other: &str| other != name && are_relatives(name, other);
        if selection.effects[i].is_proven || !STAGES.iter().any(|spec| is_relative(spec.name)) {
            return Ok(Vec::new());
        }
        let mut rest = selection.clone();
        rest.effects.remove(i);
        rest.model = without_effect(&selection.model, &selection.given, name);
        let proposed = self.promising(&rest, &rest.model, &is_relative)?;
        let mut fitted = self.fitted(&rest, &rest.model, &proposed)?;
        let mut names = Vec::new();
        fitted.retain(|one| {
            let is_new = !names.contains(&one.name);
            names.push(one.name);
            is_new
        });
        Ok(fitted)
    }
}
