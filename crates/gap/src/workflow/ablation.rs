//! Ablation of an answer: its effects added, dropped one by one, and swapped for their nearest
//! rivals.

use evpose_sensor::SensorConfig;

use super::gap_value;
use crate::GapError;
use crate::candidate::without_effect;
use crate::report::{Ablation, ModelChange};
use crate::search::{AddedEffect, DataSplits, Identification};

/// Gaps of variants of the model on held-out data: as given, corrected, and for every added effect
/// without it (drop-one) and with its nearest rival in its place (swap).
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn ablation(
    splits: &DataSplits<'_>,
    result: &Identification,
    seed: u64,
) -> Result<Vec<Ablation>, GapError> {
    let gap = |model: &SensorConfig| gap_value(&splits.held_out, model, seed);
    let row = |change, effect: &str, gap| Ablation { change, effect: effect.to_owned(), gap };
    let names: Vec<&str> = result.added_effects.iter().map(AddedEffect::name).collect();
    let mut rows = vec![row(ModelChange::None, "", gap(&result.before.model)?)];
    if result.after.model != result.before.model {
        rows.push(row(ModelChange::Added, &names.join(" + "), gap(&result.after.model)?));
    }
    for added in &result.added_effects {
        let without = without_effect(&result.after.model, &result.before.model, added.name());
        rows.push(row(ModelChange::Dropped, added.name(), gap(&without)?));
        // The first contender is the effect itself.
        if let Some(rival) = added.contenders.get(1) {
            let gap = gap(&rival.held_out.model)?;
            rows.push(row(ModelChange::Swapped, rival.candidate.name, gap));
        }
    }
    Ok(rows)
}
