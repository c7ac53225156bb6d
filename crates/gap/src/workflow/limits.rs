//! What a recording would have shown, and what it says nothing about.

use std::collections::BTreeMap;

use super::Directions;
use crate::verdict::Limit;

/// What can be found, and what cannot.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// The least strengths that show.
    pub limits: Vec<Limit>,
    /// Effects of which none does, with the reason.
    pub untestable: BTreeMap<String, String>,
}

/// Limits from what every candidate does.
pub fn limits(directions: &Directions) -> Limits {
    let mut found = Limits { limits: Vec::new(), untestable: BTreeMap::new() };
    for direction in &directions.all {
        match direction.limit {
            Some(value) => found.limits.push(Limit {
                name: direction.name.to_owned(),
                parameter: direction.parameter.to_owned(),
                value,
                unit: direction.unit.to_owned(),
            }),
            None => {
                let reason = format!(
                    "{} = {} {} changes nothing that shows in this scene",
                    direction.parameter, direction.strongest, direction.unit
                );
                let reason = reason.replace("  ", " ");
                found.untestable.insert(direction.name.to_owned(), reason);
            }
        }
    }
    found
}
