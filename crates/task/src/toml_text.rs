//! Configs as text: read with changes from the command line, and written.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::TaskError;

/// Reads a file with `parse`, whose errors then name it.
pub fn load<T>(
    path: &Path,
    parse: impl FnOnce(&str) -> Result<T, TaskError>,
) -> Result<T, TaskError> {
    let text = std::fs::read_to_string(path)
        .map_err(|source| TaskError::Io { path: path.to_path_buf(), source })?;
    parse(&text).map_err(|error| match error {
        TaskError::Config { message, .. } => {
            TaskError::Config { path: path.to_path_buf(), message }
        }
        other => other,
    })
}

/// Reads TOML. `overrides` are `dotted.key=value` as on the command line.
pub fn parse<T: DeserializeOwned>(text: &str, overrides: &[String]) -> Result<T, TaskError> {
    let problem = |message: String| TaskError::Config { path: "config".into(), message };
    if overrides.is_empty() {
        // Straight from the text, so that errors can point at lines.
        return toml::from_str(text).map_err(|error| problem(error.to_string()));
    }
    let mut table: toml::Table =
        toml::from_str(text).map_err(|error| problem(error.to_string()))?;
    for assignment in overrides {
        set(&mut table, assignment).map_err(problem)?;
    }
    table.try_into().map_err(|error: toml::de::Error| problem(error.to_string()))
}

/// A whole config as TOML, defaults included.
pub fn written(config: &impl Serialize) -> Result<String, TaskError> {
    toml::to_string_pretty(config)
        .map_err(|error| TaskError::Config { path: "config".into(), message: error.to_string() })
}

/// Old and new spellings of fields; the old ones are accepted for one release.
///
/// `serde(alias)` reads either spelling, but not a table that has both: values that are set in a
/// table with the new spelling go through here.
const RENAMED: [(&str, &str); 4] = [
    ("batch_surfaces", "batch_inputs"),
    ("fewest_joints", "min_joints"),
    ("most_lost", "max_lost"),
    ("most_unlabelled", "max_unlabelled"),
];

/// The present spelling of a field.
pub fn current_spelling(field: &str) -> &str {
    RENAMED.iter().find(|(old, _)| *old == field).map_or(field, |(_, new)| new)
}

/// Applies `dotted.key=value` to a table; the value is TOML, or else a bare string.
fn set(table: &mut toml::Table, assignment: &str) -> Result<(), String> {
    let (key, value) = assignment
        .split_once('=')
        .ok_or_else(|| format!("--set {assignment}: write it as key=value"))?;
    let value = value.trim();
    let parsed: toml::Value = toml::from_str::<toml::Table>(&format!("value = {value}"))
        .ok()
        .and_then(|mut t| t.remove("value"))
        .unwrap_or_else(|| toml::Value::String(value.to_owned()));
    let (path, last) = key.trim().rsplit_once('.').unwrap_or(("", key.trim()));
    let mut inner = table;
    for part in path.split('.').filter(|part| !part.is_empty()) {
        inner = inner
            .entry(part)
            .or_insert_with(|| toml::Value::Table(toml::Table::new()))
            .as_table_mut()
            .ok_or_else(|| format!("--set {assignment}: `{part}` is not a section"))?;
    }
    let key = current_spelling(last);
    // The file may have the old spelling.
    RENAMED.iter().filter(|(_, new)| *new == key).for_each(|(old, _)| drop(inner.remove(*old)));
    inner.insert(key.to_owned(), parsed);
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::hand::HandConfig;

    #[test]
    fn old_spellings_of_fields_are_accepted() {
        let old = "[slow_motion]\nbatch_surfaces = 3\n";
        let read = |text: &str, overrides: &[String]| {
            parse::<HandConfig>(text, overrides).unwrap().slow_motion.batch_inputs
        };
        assert_eq!(read(old, &[]), 3);
        let overrides = ["slow_motion.batch_surfaces=5".to_owned()];
        let new = written(&HandConfig::default()).unwrap();
        assert_eq!(["", old, &new].map(|text| read(text, &overrides)), [5; 3]);
    }
}
