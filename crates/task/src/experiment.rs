//! The experiment of any task: its config, read with changes from the command line, checked, compared, written.

use std::path::Path;

use evpose_clean::Denoise;
use evpose_repr::representation_by_name;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::ranges::check_ranges;
use crate::{FieldDifference, TaskError};

/// An experiment of a task, as its file describes it: seed, simulation or data, view, representation, network, loss,
/// training, evaluation, filter. Its field `task` names the task.
///
/// The trait checks what all tasks have; a task brings the sections, and the checks of what it alone has.
pub trait Experiment: Serialize + DeserializeOwned {
    /// The value of `task`.
    const TASK: &'static str;

    /// Seed of every random stream of the experiment.
    fn seed(&self) -> u64;

    /// The section on the input of the network; none is checked by default.
    fn input(&self) -> Option<NetworkInput<'_>> {
        None
    }

    /// Checks what only this task has, the training left out; by default nothing.
    ///
    /// # Errors
    /// The first field that makes no sense.
    fn validate_own(&self) -> Result<(), TaskError> {
        Ok(())
    }

    /// Checks what only the training of this task has; by default nothing.
    ///
    /// # Errors
    /// As [`Self::validate_own`].
    fn validate_training(&self) -> Result<(), TaskError> {
        Ok(())
    }

    /// Checks ranges and combinations of values.
    ///
    /// # Errors
    /// As [`Self::validate_own`].
    fn validate(&self) -> Result<(), TaskError> {
        self.validate_simulation()?;
        self.validate_training()
    }

    /// As [`Self::validate`], the training left out.
    ///
    /// # Errors
    /// As [`Self::validate_own`].
    fn validate_simulation(&self) -> Result<(), TaskError> {
        // Ranges come first, so that later checks need not guard against absurd values.
        check_ranges(self)?;
        self.input().map_or(Ok(()), |input| input.validate())?;
        self.validate_own()
    }

    /// Reads TOML, defaults filled in and nothing checked but the task. `overrides` are
    /// `dotted.key=value` as on the command line.
    ///
    /// # Errors
    /// If it is of another task or of none, or has unknown or wrongly typed fields; the error names
    /// them.
    fn unchecked(text: &str, overrides: &[String]) -> Result<Self, TaskError> {
        let mut table: toml::Table = toml::from_str(text).map_err(|e| problem(&e))?;
        for assignment in overrides {
            set(&mut table, assignment)?;
        }
        let task = table.get("task");
        if task.and_then(toml::Value::as_str) != Some(Self::TASK) {
            let found = task.map_or_else(|| "is missing".to_owned(), |task| format!("is {task}"));
            let message = format!("must be \"{}\", and {found}", Self::TASK);
            return Err(TaskError::Field { field: "task", message });
        }
        // Straight from the text where nothing is changed, so that errors can point at lines.
        let config = if overrides.is_empty() { toml::from_str(text) } else { table.try_into() };
        config.map_err(|error| problem(&error))
    }

    /// As [`Self::unchecked`], and checked.
    ///
    /// # Errors
    /// As [`Self::unchecked`], or if values make no sense.
    fn parse(text: &str, overrides: &[String]) -> Result<Self, TaskError> {
        let config = Self::unchecked(text, overrides)?;
        config.validate()?;
        Ok(config)
    }

    /// Reads the config of a directory, defaults filled in and nothing checked: sequences may be
    /// shorter than a training would need.
    ///
    /// # Errors
    /// As [`Self::unchecked`], or if the file cannot be read.
    fn read(path: &Path) -> Result<Self, TaskError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| TaskError::Io { path: path.to_path_buf(), source })?;
        Self::unchecked(&text, &[]).map_err(|error| match error {
            // The text has no path, so that its errors get that of the file here.
            TaskError::Config { message, .. } => {
                TaskError::Config { path: path.to_path_buf(), message }
            }
            other => other,
        })
    }

    /// The whole config as TOML, defaults included.
    ///
    /// # Errors
    /// If a value cannot be written as TOML.
    fn to_toml(&self) -> Result<String, TaskError> {
        toml::to_string_pretty(self).map_err(|error| problem(&error))
    }

    /// The fields in which the config of a directory differs from this one.
    ///
    /// # Errors
    /// If one of the two cannot be written as TOML.
    fn differences(&self, there: &Self) -> Result<Vec<FieldDifference>, TaskError> {
        let table = |config: &Self| toml::from_str(&config.to_toml()?).map_err(|e| problem(&e));
        Ok(FieldDifference::between(&table(self)?, &table(there)?))
    }
}

/// The section on the input of a network: values with the dotted names that the task gives their fields.
#[derive(Debug, Clone, Copy)]
pub struct NetworkInput<'a> {
    /// The representation.
    pub representation: (&'static str, &'a str),
    /// The filter of the events; none keeps them all.
    pub denoise: (&'static str, Option<Denoise>),
    /// Channels that the network takes at most, and the message about a representation with more.
    pub channels: (usize, &'static str),
}

impl NetworkInput<'_> {
    fn validate(&self) -> Result<(), TaskError> {
        let ((field, denoise), (name, representation)) = (self.denoise, self.representation);
        let (max_channels, message) = self.channels;
        let is_valid = denoise.is_none_or(|denoise| denoise.is_valid());
        let channels = representation_by_name(representation)?.channels();
        require(&[
            (is_valid, field, "tau_ms must be above 0, neighbours 1 to 8"),
            (channels <= max_channels, name, message),
        ])
    }
}

/// Refuses the first of several fields whose value is not valid: whether it is, its dotted name, the message.
pub(crate) fn require(fields: &[(bool, &'static str, &str)]) -> Result<(), TaskError> {
    match fields.iter().find(|(is_valid, ..)| !is_valid) {
        None => Ok(()),
        Some(&(_, field, message)) => Err(TaskError::Field { field, message: message.to_owned() }),
    }
}

fn problem(error: &impl ToString) -> TaskError {
    TaskError::Config { path: "config".into(), message: error.to_string() }
}

/// Applies `dotted.key=value` to a table; the value is TOML, or else a bare string.
fn set(table: &mut toml::Table, assignment: &str) -> Result<(), TaskError> {
    let (key, value) = assignment
        .split_once('=')
        .ok_or_else(|| problem(&format!("--set {assignment}: write it as key=value")))?;
    let value = value.trim();
    // What is no TOML is a string: the shell has taken the quotes off.
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
            .ok_or_else(|| problem(&format!("--set {assignment}: `{part}` is not a section")))?;
    }
    inner.insert(last.to_owned(), parsed);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::BaselineConfig;
    use crate::body::BodyConfig;
    use crate::hand::HandConfig;

    /// A config that was written is read back, and by no other task; nor is one that names none.
    fn is_its_own<C: Experiment + Default + PartialEq + std::fmt::Debug>(others: [&str; 2]) {
        let text = C::default().to_toml().unwrap();
        assert_eq!(C::parse(&text, &[]).unwrap(), C::default());
        let message = C::parse("seed = 1", &[]).unwrap_err().to_string();
        assert!(message.contains("is missing") && message.contains(C::TASK), "{message}");
        for other in others {
            let message = C::parse(&text, &[format!("task={other}")]).unwrap_err().to_string();
            assert!(message.contains(other) && message.contains(C::TASK), "{message}");
        }
    }

    /// Wrong values of sections that all tasks have are refused under the names of their fields in this one.
    fn refuses_by_name<C: Experiment + Default + std::fmt::Debug>(section: &str) {
        let text = C::default().to_toml().unwrap();
        let (denoise, factor) = (format!("{section}.denoise"), "training.schedule.factor");
        for (field, value) in [(&*denoise, "{ tau_ms = 1.0, neighbours = 9 }"), (factor, "0.0")] {
            let message = C::parse(&text, &[format!("{field}={value}")]).unwrap_err().to_string();
            assert!(message.contains(&format!("`{field}`")), "{message}");
        }
    }

    #[test]
    fn sections_of_all_tasks_are_checked() {
        refuses_by_name::<HandConfig>("representation");
        refuses_by_name::<BodyConfig>("image");
        refuses_by_name::<BaselineConfig>("image");
    }

    #[test]
    fn a_config_is_read_by_the_task_that_it_names() {
        is_its_own::<HandConfig>(["body", "baseline"]);
        is_its_own::<BodyConfig>(["hand", "baseline"]);
        is_its_own::<BaselineConfig>(["hand", "body"]);
    }
}
