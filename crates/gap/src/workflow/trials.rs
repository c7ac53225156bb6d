//! The gap with an effect taken out again, and with its nearest rival in its place.

use evpose_sensor::SensorConfig;

use super::gap_value;
use crate::GapError;
use crate::exchange::without;
use crate::naming::{Bench, Named};
use crate::report::{Ablation, Change};

/// Variants of the model, judged on what was held out: as given, corrected, and for every effect
/// that was added without it and with the nearest other candidate in its place.
///
/// # Errors
/// A model that cannot be built or shown the scene.
pub fn ablation(bench: &Bench<'_>, named: &Named, seed: u64) -> Result<Vec<Ablation>, GapError> {
    let gap = |model: &SensorConfig| gap_value(&bench.held, model, seed);
    let row = |change, effect: &str, gap| Ablation { change, effect: effect.to_owned(), gap };
    let names: Vec<&str> = named.steps.iter().map(|step| step.contenders[0].found.name).collect();
    let mut rows = vec![row(Change::None, "", gap(&named.before.model)?)];
    if named.after.model != named.before.model {
        rows.push(row(Change::Added, &names.join(" + "), gap(&named.after.model)?));
    }
    for step in &named.steps {
        let name = step.contenders[0].found.name;
        rows.push(row(Change::TakenOut, name, gap(&without(&named.after.model, name))?));
        if let Some(rival) = step.contenders.get(1) {
            rows.push(row(Change::Exchanged, rival.found.name, gap(&rival.held.model)?));
        }
    }
    Ok(rows)
}
