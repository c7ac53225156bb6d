//! Compositions of plans.

use serde::{Deserialize, Serialize};

/// Composition of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Tier {
    /// Zero to five effects in cameras with conventions.
    #[default]
    Home,
    /// One or two effects in a pixel that is ideal otherwise.
    Plain,
}
