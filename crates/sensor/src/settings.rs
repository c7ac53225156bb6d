//! The parameters of one effect, checked against its [`StageSpec`] and complete.

use std::path::{Path, PathBuf};

use crate::{ChoiceSpec, EffectConfig, FileSpec, ParamSpec, SensorError, StageSpec, Value};

/// A value for every parameter and choice of one stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    values: Vec<(&'static ParamSpec, f64)>,
    words: Vec<(&'static ChoiceSpec, &'static str)>,
    files: Vec<(&'static FileSpec, PathBuf)>,
}

impl Settings {
    /// Checks `effect` and fills in what it leaves out: neutral values, first choices.
    ///
    /// # Errors
    /// Keys that the stage does not have, values that they cannot take, and a missing parameter
    /// that has no neutral value.
    pub fn resolve(spec: &'static StageSpec, effect: &EffectConfig) -> Result<Self, SensorError> {
        let allowed = spec.keys();
        // Unknown keys first: a misspelt key is the cause of the missing one that would be
        // reported.
        if let Some(key) = effect.params.keys().find(|key| !allowed.contains(&key.as_str())) {
            return Err(SensorError::UnknownKey { effect: spec.name, key: key.clone(), allowed });
        }
        let mut settings = Self { values: Vec::new(), words: Vec::new(), files: Vec::new() };
        for param in spec.params {
            let number = resolve_number(spec, param, effect.params.get(param.name))?;
            settings.values.push((param, number));
        }
        for choice in spec.choices {
            let word = resolve_word(spec, choice, effect.params.get(choice.name))?;
            settings.words.push((choice, word));
        }
        for file in spec.files {
            if let Some(path) = resolve_file(spec, file, effect.params.get(file.name))? {
                settings.files.push((file, path));
            }
        }
        Ok(settings)
    }

    /// The value of `param`.
    ///
    /// # Panics
    /// If the stage does not list `param` in its spec: a fault of the stage, not of its user.
    pub fn number(&self, param: &ParamSpec) -> f64 {
        let entry = self.values.iter().find(|(known, _)| known.name == param.name);
        entry.map_or_else(|| panic!("`{}` is not in the stage's spec", param.name), |&(_, v)| v)
    }

    /// The word chosen for `choice`.
    ///
    /// # Panics
    /// If the stage does not list `choice` in its spec: a fault of the stage, not of its user.
    pub fn word(&self, choice: &ChoiceSpec) -> &'static str {
        let entry = self.words.iter().find(|(known, _)| known.name == choice.name);
        entry.map_or_else(|| panic!("`{}` is not in the stage's spec", choice.name), |&(_, w)| w)
    }

    /// The path given for `file`, if one is given.
    pub fn file(&self, file: &FileSpec) -> Option<&Path> {
        let entry = self.files.iter().find(|(known, _)| known.name == file.name);
        entry.map(|(_, path)| path.as_path())
    }

    /// All parameters in the order of the spec.
    pub fn values(&self) -> &[(&'static ParamSpec, f64)] {
        &self.values
    }

    /// All choices in the order of the spec.
    pub fn words(&self) -> &[(&'static ChoiceSpec, &'static str)] {
        &self.words
    }

    /// All files that are given, in the order of the spec.
    pub fn files(&self) -> &[(&'static FileSpec, PathBuf)] {
        &self.files
    }
}

fn resolve_number(
    spec: &StageSpec,
    param: &'static ParamSpec,
    given: Option<&Value>,
) -> Result<f64, SensorError> {
    let bad = |value: String| SensorError::BadValue {
        effect: spec.name,
        key: param.name,
        value,
        expected: param.expected(),
    };
    match (given, param.neutral) {
        (Some(&Value::Number(number)), _) if param.allows(number) => Ok(number),
        (Some(Value::Number(number)), _) => Err(bad(number.to_string())),
        (Some(Value::Word(word)), _) => Err(bad(format!("{word:?}"))),
        (None, Some(neutral)) => Ok(neutral),
        (None, None) => Err(SensorError::MissingKey {
            effect: spec.name,
            key: param.name,
            expected: param.expected(),
        }),
    }
}

fn resolve_word(
    spec: &StageSpec,
    choice: &'static ChoiceSpec,
    given: Option<&Value>,
) -> Result<&'static str, SensorError> {
    let value = match given {
        // The first of the allowed words is the default.
        None => return Ok(choice.allowed[0]),
        Some(Value::Word(word)) => {
            // The spec's own word, which outlives the caller's.
            if let Some(known) = choice.allowed.iter().find(|known| *known == word) {
                return Ok(known);
            }
            format!("{word:?}")
        }
        Some(Value::Number(number)) => number.to_string(),
    };
    Err(SensorError::BadValue {
        effect: spec.name,
        key: choice.name,
        value,
        expected: format!("one of {:?}", choice.allowed),
    })
}

fn resolve_file(
    spec: &StageSpec,
    file: &'static FileSpec,
    given: Option<&Value>,
) -> Result<Option<PathBuf>, SensorError> {
    match given {
        None => Ok(None),
        Some(Value::Word(path)) => Ok(Some(PathBuf::from(path))),
        Some(Value::Number(number)) => Err(SensorError::BadValue {
            effect: spec.name,
            key: file.name,
            value: number.to_string(),
            expected: "the path of an .npy file, in quotes".to_owned(),
        }),
    }
}
