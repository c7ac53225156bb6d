//! The plan of the benchmark: every case from one seed, in an order and under names that say
//! nothing.
//!
//! A plan has one of two compositions. In [`Tier::Home`], cameras differ from the ideal pixel in
//! several conventions that nothing mentions, and zero to five effects are hidden beside them. In
//! [`Tier::Plain`], one or two effects are hidden in a pixel that is ideal otherwise.

mod builder;
mod change;
mod home;
mod plain;

use crate::case::Case;
use crate::tier::Tier;

pub use home::uncatalogued;

/// Makes the plan.
#[derive(Debug, Clone, Copy)]
pub struct Plan;

impl Plan {
    /// All cases of a seed.
    pub fn from_seed(seed: u64, tier: Tier) -> Vec<Case> {
        let mut cases = match tier {
            Tier::Home => home::cases(seed),
            Tier::Plain => plain::cases(seed),
        };
        // In the order of anonymous names kinds are mixed: a place says nothing about a case.
        cases.sort_by(|a, b| a.id.cmp(&b.id));
        cases
    }
}
