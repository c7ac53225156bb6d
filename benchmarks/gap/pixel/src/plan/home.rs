//! Zero to five effects in cameras that have conventions ([`crate::convention`]) besides.
//!
//! | kind | cases | hidden |
//! |---|---|---|
//! | single | 144 | 18 effects at 4 strengths on 2 scenes |
//! | null | 100 | nothing |
//! | parameter | 60 | thresholds, background rates or the clock's zero |
//! | pair | 60 | two effects of different stages |
//! | several | 60 | three, four and five effects, 20 cases each, at most two of a stage |
//! | left out | 18 | each effect once, removed from the catalogue at run time |
//! | never catalogued | 14 | seven effects that no catalogue has, twice |
//!
//! Effects of pairs and of several are at one of their two highest strengths. No two things of a
//! camera, hidden or by convention, occupy one [`Slot`], and at least three kinds of conventions
//! keep theirs.

use super::builder::Builder;
use super::change::{CircuitChange, any_effect, high_strength, install, install_uncatalogued};
use crate::case::{Case, CaseKind};
use crate::convention::{CONVENTIONS_PER_CAMERA, free_kinds};
use crate::draw::Sequence;
use crate::effect::{EFFECTS, Effect};
use crate::oddity::{ODDITIES, Oddity};
use crate::slot::Slot;
use crate::tier::Tier;

const SCENES_OF_SINGLES: usize = 2;
const NULLS: usize = 100;
const PARAMETERS: usize = 60;
const PAIRS: usize = 60;
const SEVERAL: usize = 60;
/// Effects of a case with several.
const COUNTS_OF_SEVERAL: [usize; 3] = [3, 4, 5];
/// Rounds through the effects outside every catalogue, each stronger than the one before.
const ROUNDS_OF_UNCATALOGUED: usize = 2;
/// Effects of one stage in a case.
const MAX_OF_STAGE: usize = 2;

/// Effects outside the catalogue: all of [`crate::oddity`] but hysteresis, which it has.
pub fn uncatalogued() -> Vec<Oddity> {
    ODDITIES.into_iter().filter(|oddity| *oddity != Oddity::Hysteresis).collect()
}

pub(super) fn cases(seed: u64) -> Vec<Case> {
    let mut builder = Builder::new(seed, Tier::Home);
    builder.push_singles(SCENES_OF_SINGLES);
    builder.push_nulls_and_parameters(NULLS, PARAMETERS);
    for i in 0..PAIRS {
        builder.push(CaseKind::Pair, i, None, None, |draws| effects(2, 1, draws));
    }
    for i in 0..SEVERAL {
        let count = COUNTS_OF_SEVERAL[i % COUNTS_OF_SEVERAL.len()];
        builder.push(CaseKind::Several, i, None, None, |draws| effects(count, MAX_OF_STAGE, draws));
    }
    for (i, effect) in EFFECTS.into_iter().enumerate() {
        builder.push(CaseKind::LeftOut, i, None, Some(effect.name()), |draws| {
            let strength = high_strength(draws);
            vec![install(effect, strength, draws)]
        });
    }
    let uncatalogued = uncatalogued();
    for i in 0..ROUNDS_OF_UNCATALOGUED * uncatalogued.len() {
        let (oddity, round) = (uncatalogued[i % uncatalogued.len()], i / uncatalogued.len());
        builder.push(CaseKind::NeverCatalogued, i, None, None, |_| {
            vec![install_uncatalogued(oddity, round)]
        });
    }
    builder.cases
}

/// Effects that make sense together, at most `of_stage` of one stage, each at one of its two
/// highest strengths.
fn effects(count: usize, of_stage: usize, draws: &mut Sequence) -> Vec<CircuitChange> {
    let mut chosen: Vec<Effect> = Vec::new();
    while chosen.len() < count {
        let effect = any_effect(draws);
        if fits(effect, &chosen, of_stage) {
            chosen.push(effect);
        }
    }
    let strong = |effect: Effect| {
        let strength = high_strength(draws);
        install(effect, strength, draws)
    };
    chosen.into_iter().map(strong).collect()
}

/// Whether an effect has a slot of its own, its stage is not full, and enough kinds of conventions
/// are left.
fn fits(effect: Effect, chosen: &[Effect], of_stage: usize) -> bool {
    let mut slots: Vec<Slot> = chosen.iter().map(|effect| effect.slot()).collect();
    let is_free = !slots.contains(&effect.slot());
    slots.push(effect.slot());
    let in_stage = chosen.iter().filter(|other| other.stage() == effect.stage()).count();
    is_free && in_stage < of_stage && free_kinds(&slots).len() >= CONVENTIONS_PER_CAMERA[0]
}
