//! The differences of two configs, field by field.

use std::collections::BTreeMap;
use std::fmt;

/// A field that two configs give different values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldDifference {
    /// Dotted name of the field.
    pub field: String,
    /// Its value in the directory, as TOML.
    pub there: Option<String>,
    /// Its value in the given config, as TOML.
    pub given: Option<String>,
}

impl fmt::Display for FieldDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let or_none = |value: &Option<String>| value.clone().unwrap_or_else(|| "absent".into());
        write!(f, "{} is {} there, not {}", self.field, or_none(&self.there), or_none(&self.given))
    }
}

impl FieldDifference {
    /// The fields in which the config of a directory, `there`, differs from the one that was given.
    pub(crate) fn between(given: &toml::Table, there: &toml::Table) -> Vec<Self> {
        let (mut given, mut there) = (fields(given), fields(there));
        let mut names: Vec<String> = given.keys().chain(there.keys()).cloned().collect();
        names.sort_unstable();
        names.dedup();
        let pairs = names.into_iter().map(|field| Self {
            there: there.remove(&field),
            given: given.remove(&field),
            field,
        });
        pairs.filter(|pair| pair.there != pair.given).collect()
    }
}

fn fields(table: &toml::Table) -> BTreeMap<String, String> {
    let mut out = BTreeMap::new();
    flatten("", table, &mut out);
    out
}

fn flatten(prefix: &str, table: &toml::Table, out: &mut BTreeMap<String, String>) {
    for (key, value) in table {
        let field = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            toml::Value::Table(inner) => flatten(&field, inner, out),
            value => {
                out.insert(field, value.to_string());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::Experiment as _;
    use crate::hand::HandConfig;

    #[test]
    fn every_field_that_differs_is_named_with_both_values() {
        let there = HandConfig::default();
        assert_eq!(there.differences(&there).unwrap(), []);
        let mut given = there.clone();
        given.seed = 2;
        given.simulation.seconds = 5.0;
        given.representation.name = "eoi".to_owned();
        let found = given.differences(&there).unwrap();
        let said: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(
            said,
            [
                "representation.name is \"lnes\" there, not \"eoi\"",
                "seed is 1 there, not 2",
                "simulation.seconds is 40200.0 there, not 5.0",
            ]
        );
    }
}
