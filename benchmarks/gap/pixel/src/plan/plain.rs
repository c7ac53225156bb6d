//! One or two effects in a pixel that is ideal otherwise.
//!
//! 216 singles (18 effects, 4 strengths, 3 scenes), 200 nulls, 60 cases with other parameters only,
//! 60 pairs of strong effects from different stages, 22 effects that are removed from the catalogue
//! and 18 that no catalogue has.

use super::builder::Builder;
use super::change::{CircuitChange, any_effect, high_strength, install, install_uncatalogued};
use crate::case::{Case, CaseKind};
use crate::draw::Sequence;
use crate::effect::EFFECTS;
use crate::oddity::ODDITIES;
use crate::tier::Tier;

const SCENES_OF_SINGLES: usize = 3;
const NULLS: usize = 200;
const PARAMETERS: usize = 60;
const PAIRS: usize = 60;
const LEFT_OUT: usize = 22;
const NEVER_CATALOGUED: usize = 18;

pub(super) fn cases(seed: u64) -> Vec<Case> {
    let mut builder = Builder::new(seed, Tier::Plain);
    builder.push_singles(SCENES_OF_SINGLES);
    builder.push_nulls_and_parameters(NULLS, PARAMETERS);
    for i in 0..PAIRS {
        builder.push(CaseKind::Pair, i, None, None, pair);
    }
    for i in 0..LEFT_OUT {
        let effect = EFFECTS[i % EFFECTS.len()];
        // Once through all effects at the third strength, then on at the fourth.
        let strength = 2 + i / EFFECTS.len();
        builder.push(CaseKind::LeftOut, i, None, Some(effect.name()), |draws| {
            vec![install(effect, strength, draws)]
        });
    }
    for i in 0..NEVER_CATALOGUED {
        builder.push(CaseKind::NeverCatalogued, i, None, None, |_| {
            vec![install_uncatalogued(ODDITIES[i % ODDITIES.len()], i / ODDITIES.len())]
        });
    }
    builder.cases
}

/// Two effects of different stages, each at one of its two highest strengths.
fn pair(draws: &mut Sequence) -> Vec<CircuitChange> {
    let first = any_effect(draws);
    let second = loop {
        let effect = any_effect(draws);
        if effect.stage() != first.stage() {
            break effect;
        }
    };
    [first, second]
        .map(|effect| {
            let strength = high_strength(draws);
            install(effect, strength, draws)
        })
        .into()
}
