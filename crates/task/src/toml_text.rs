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
    inner.insert(last.to_owned(), parsed);
    Ok(())
}
