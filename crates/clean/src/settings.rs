//! The parameters of a cleaner: their specification, and the values given.

use std::path::{Path, PathBuf};

use crate::{CleanError, CleanerSpec};

/// A parameter of a cleaner.
#[derive(Debug, Clone, Copy)]
pub struct CleanerParamSpec {
    /// The key in requests.
    pub name: &'static str,
    /// Accepted values.
    pub kind: ParamKind,
    /// The value where none is given; none if there is no such value.
    pub default: Option<&'static str>,
    /// Meaning, with the source of a default value.
    pub doc: &'static str,
}

/// Accepted values of a parameter.
#[derive(Debug, Clone, Copy)]
pub enum ParamKind {
    /// A number between two, both allowed.
    Number(f64, f64),
    /// One of these words.
    Word(&'static [&'static str]),
    /// A file.
    Path,
}

impl ParamKind {
    /// The allowed values in words.
    pub fn expected(self) -> String {
        match self {
            Self::Number(least, most) => format!("a number in {least}..={most}"),
            Self::Word(words) => format!("one of {}", words.join(", ")),
            Self::Path => "a file".to_owned(),
        }
    }

    fn parse(self, text: &str) -> Option<Value> {
        match self {
            Self::Number(least, most) => {
                let number: f64 = text.parse().ok()?;
                (least..=most).contains(&number).then_some(Value::Number(number))
            }
            Self::Word(words) => words.iter().find(|word| **word == text).map(|w| Value::Word(w)),
            Self::Path => (!text.is_empty()).then(|| Value::Path(text.into())),
        }
    }
}

#[derive(Debug, Clone)]
enum Value {
    Number(f64),
    Word(&'static str),
    Path(PathBuf),
}

/// A value for every parameter of a cleaner that was given or has a default.
#[derive(Debug, Clone)]
pub struct CleanerSettings {
    cleaner: &'static str,
    values: Vec<Setting>,
}

#[derive(Debug, Clone)]
struct Setting {
    name: &'static str,
    value: Value,
    is_given: bool,
}

impl CleanerSettings {
    /// Checks what is given and fills in defaults. Of a key that is given twice, the last counts.
    pub(crate) fn resolve(
        spec: &'static CleanerSpec,
        given: &[(String, String)],
    ) -> Result<Self, CleanError> {
        if let Some((key, _)) = given.iter().find(|(key, _)| spec.param(key).is_none()) {
            let allowed = spec.params.iter().map(|param| param.name).collect();
            return Err(CleanError::UnknownKey { cleaner: spec.name, key: key.clone(), allowed });
        }
        let mut values = Vec::new();
        for param in spec.params {
            let found = given.iter().rev().find(|(key, _)| key == param.name);
            let found = found.map(|(_, value)| value.as_str());
            let Some(text) = found.or(param.default) else { continue };
            let value = param.kind.parse(text).ok_or_else(|| CleanError::BadValue {
                cleaner: spec.name,
                key: param.name,
                value: text.to_owned(),
                expected: param.kind.expected(),
            })?;
            values.push(Setting { name: param.name, value, is_given: found.is_some() });
        }
        Ok(Self { cleaner: spec.name, values })
    }

    fn value(&self, param: &CleanerParamSpec) -> Option<&Value> {
        self.values.iter().find(|setting| setting.name == param.name).map(|s| &s.value)
    }

    /// Whether a value was given.
    pub fn is_given(&self, param: &CleanerParamSpec) -> bool {
        self.values.iter().any(|setting| setting.is_given && setting.name == param.name)
    }

    /// A number.
    ///
    /// # Panics
    /// If the cleaner has no such number with a default: a fault of the cleaner, not of its user.
    pub fn number(&self, param: &CleanerParamSpec) -> f64 {
        match self.value(param) {
            Some(&Value::Number(number)) => number,
            _ => panic!("`{}` has no number `{}`", self.cleaner, param.name),
        }
    }

    /// A word, if one was given or is the default.
    pub fn word(&self, param: &CleanerParamSpec) -> Option<&'static str> {
        match self.value(param) {
            Some(&Value::Word(word)) => Some(word),
            _ => None,
        }
    }

    /// A file, if one was given.
    pub fn path(&self, param: &CleanerParamSpec) -> Option<&Path> {
        match self.value(param) {
            Some(Value::Path(path)) => Some(path),
            _ => None,
        }
    }

    /// Refuses what else was given beside `param`, which sets everything.
    pub(crate) fn alone(&self, param: &CleanerParamSpec) -> Result<(), CleanError> {
        let is_other = |setting: &&Setting| setting.is_given && setting.name != param.name;
        match self.values.iter().find(is_other) {
            Some(other) => Err(CleanError::Conflict {
                cleaner: self.cleaner,
                key: param.name,
                other: other.name,
            }),
            None => Ok(()),
        }
    }
}
