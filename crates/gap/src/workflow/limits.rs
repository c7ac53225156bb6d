//! Detection limits of effects in a recording, and effects that are not testable.

use std::collections::BTreeMap;

use super::Directions;
use crate::verdict::Limit;

/// Detection limits and untestable effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Detection limits.
    pub limits: Vec<Limit>,
    /// Effects without a detection limit, with the reason.
    pub untestable: BTreeMap<String, String>,
}

/// Detection limits from the directions of all candidates.
pub fn limits(directions: &Directions) -> Limits {
    let mut result = Limits { limits: Vec::new(), untestable: BTreeMap::new() };
    for direction in &directions.all {
        match direction.limit {
            Some(value) => result.limits.push(Limit {
                name: direction.name.to_owned(),
                parameter: direction.parameter.to_owned(),
                value,
                unit: direction.unit.to_owned(),
            }),
            None => {
                let reason = format!(
                    "{} = {} {} changes nothing detectable in this scene",
                    direction.parameter, direction.strongest, direction.unit
                );
                // A quantity without a unit leaves two spaces.
                let reason = reason.replace("  ", " ");
                result.untestable.insert(direction.name.to_owned(), reason);
            }
        }
    }
    result
}
