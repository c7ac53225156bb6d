//! The values of parameters, checked and complete.

use std::fmt;
use std::path::{Path, PathBuf};

use super::{FileSpec, NumberSpec, Parameter, TextSpec, WordSpec};

/// A value as it is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Given<'a> {
    /// A number of a configuration.
    Number(f64),
    /// A word or a path of a configuration, in quotes there.
    Word(&'a str),
    /// Text of a command line: a number, a word or a path, as the parameter takes it.
    Text(&'a str),
}

impl<'a> Given<'a> {
    fn number(self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number),
            Self::Word(_) => None,
            Self::Text(text) => text.parse().ok(),
        }
    }

    fn word(self) -> Option<&'a str> {
        match self {
            Self::Number(_) => None,
            Self::Word(word) | Self::Text(word) => Some(word),
        }
    }
}

/// As it is written.
impl fmt::Display for Given<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Word(word) => write!(f, "{word:?}"),
            Self::Text(text) => f.write_str(text),
        }
    }
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Setting {
    /// A number.
    Number(&'static NumberSpec, f64),
    /// One of the words allowed.
    Word(&'static WordSpec, &'static str),
    /// The path of a file.
    File(&'static FileSpec, PathBuf),
    /// Text.
    Text(&'static TextSpec, String),
}

/// The value alone.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(_, number) => write!(f, "{number}"),
            Self::Word(_, word) => f.write_str(word),
            Self::File(_, path) => write!(f, "{}", path.display()),
            Self::Text(_, text) => f.write_str(text),
        }
    }
}

impl Parameter {
    /// The value where none is given, if there is one.
    pub fn default(&'static self) -> Option<Setting> {
        match self {
            Self::Number(spec) => spec.default.map(|number| Setting::Number(spec, number)),
            Self::Word(spec) => spec.default.map(|word| Setting::Word(spec, word)),
            Self::File(_) | Self::Text(_) => None,
        }
    }

    fn take(&'static self, given: Given<'_>) -> Option<Setting> {
        match self {
            Self::Number(spec) => {
                let number = given.number().filter(|&number| spec.allows(number))?;
                Some(Setting::Number(spec, number))
            }
            Self::Word(spec) => {
                // The specification's own word, which outlives the caller's.
                let word = spec.allowed.iter().find(|&&word| given.word() == Some(word))?;
                Some(Setting::Word(spec, word))
            }
            Self::File(spec) => {
                let path = given.word().filter(|path| !path.is_empty())?;
                Some(Setting::File(spec, path.into()))
            }
            Self::Text(spec) => {
                // A number is a text as well: `expression = 0.3`.
                let text = match given {
                    Given::Number(number) => number.to_string(),
                    Given::Word(text) | Given::Text(text) => text.to_owned(),
                };
                (!text.trim().is_empty()).then_some(Setting::Text(spec, text))
            }
        }
    }
}

/// A value for every parameter that is given or has a default.
///
/// A parameter is asked for by itself or by its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    entries: Vec<Entry>,
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    name: &'static str,
    setting: Setting,
    is_given: bool,
}

impl Settings {
    /// Checks what is given, as keys and values, and fills in defaults. Of a key that is given
    /// twice, the last counts.
    ///
    /// # Errors
    /// Keys that no parameter has, and values that a parameter does not take.
    pub fn resolve(
        parameters: &'static [Parameter],
        given: &[(&str, Given<'_>)],
    ) -> Result<Self, ParameterError> {
        let allowed = || parameters.iter().map(Parameter::name);
        // Unknown keys first: a misspelt key is the cause of the missing one that would be
        // reported.
        if let Some((key, _)) = given.iter().find(|(key, _)| allowed().all(|name| name != *key)) {
            let (key, allowed) = ((*key).to_owned(), allowed().collect());
            return Err(ParameterError::UnknownKey { key, allowed });
        }
        let mut entries = Vec::new();
        for parameter in parameters {
            let name = parameter.name();
            let found = given.iter().rev().find(|(key, _)| *key == name);
            let setting = match found {
                Some(&(_, value)) => Some(parameter.take(value).ok_or_else(|| {
                    ParameterError::BadValue { parameter, value: value.to_string() }
                })?),
                None => parameter.default(),
            };
            let is_given = found.is_some();
            entries.extend(setting.map(|setting| Entry { name, setting, is_given }));
        }
        Ok(Self { entries })
    }

    /// The same, where every number has a value.
    ///
    /// # Errors
    /// A number that was not given and has no default.
    pub fn complete(self, parameters: &'static [Parameter]) -> Result<Self, ParameterError> {
        let is_missing = |p: &&Parameter| p.as_number().is_some() && self.get(*p).is_none();
        match parameters.iter().find(is_missing) {
            Some(parameter) => Err(ParameterError::MissingKey { parameter }),
            None => Ok(self),
        }
    }

    /// The value of a parameter, if one was given or is the default.
    pub fn get(&self, parameter: &(impl AsRef<str> + ?Sized)) -> Option<&Setting> {
        let entry = self.entries.iter().find(|entry| entry.name == parameter.as_ref());
        entry.map(|entry| &entry.setting)
    }

    /// A number.
    ///
    /// # Panics
    /// If there is no such number with a value: a fault of who asks, not of who gave the settings.
    pub fn number(&self, parameter: &(impl AsRef<str> + ?Sized)) -> f64 {
        let name = parameter.as_ref();
        match self.get(name) {
            Some(&Setting::Number(_, number)) => number,
            _ => panic!("no number is called `{name}`, or it has no value"),
        }
    }

    /// An integer.
    ///
    /// # Panics
    /// As [`Self::number`].
    pub fn whole(&self, parameter: &(impl AsRef<str> + ?Sized)) -> u32 {
        self.number(parameter) as u32
    }

    /// A word, if one was given or is the default.
    pub fn word(&self, parameter: &(impl AsRef<str> + ?Sized)) -> Option<&'static str> {
        if let Some(Setting::Word(_, word)) = self.get(parameter) { Some(word) } else { None }
    }

    /// The path of a file, if one was given.
    pub fn file(&self, parameter: &(impl AsRef<str> + ?Sized)) -> Option<&Path> {
        if let Some(Setting::File(_, path)) = self.get(parameter) { Some(path) } else { None }
    }

    /// The text, if one was given.
    pub fn text(&self, parameter: &(impl AsRef<str> + ?Sized)) -> Option<&str> {
        if let Some(Setting::Text(_, text)) = self.get(parameter) { Some(text) } else { None }
    }

    /// The names and values of all parameters that have one, in their order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &Setting)> {
        self.entries.iter().map(|entry| (entry.name, &entry.setting))
    }

    /// The names of the parameters that were given, in the order of the parameters.
    pub fn given(&self) -> impl Iterator<Item = &'static str> {
        self.entries.iter().filter(|entry| entry.is_given).map(|entry| entry.name)
    }

    /// Whether a value was given.
    pub fn is_given(&self, parameter: &(impl AsRef<str> + ?Sized)) -> bool {
        self.given().any(|name| name == parameter.as_ref())
    }
}

/// A key or a value that parameters do not take.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// No parameter has this name.
    #[error("has no parameter `{key}`; it has {}", names(allowed))]
    UnknownKey {
        /// The key given.
        key: String,
        /// The names of the parameters.
        allowed: Vec<&'static str>,
    },
    /// A parameter does not take the value.
    #[error("`{}` = {value}, expected {}", parameter.name(), parameter.expected())]
    BadValue {
        /// Parameter that refuses the value.
        parameter: &'static Parameter,
        /// The value, as it was written.
        value: String,
    },
    /// A parameter without a default is missing.
    #[error("needs `{}`: {}", parameter.name(), parameter.expected())]
    MissingKey {
        /// Parameter that is missing.
        parameter: &'static Parameter,
    },
}

fn names(allowed: &[&str]) -> String {
    if allowed.is_empty() { "none".to_owned() } else { allowed.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NumberKind;

    const PARAMETERS: &[Parameter] = &[
        Parameter::Number(NumberSpec {
            name: "kernel",
            unit: "px",
            kind: NumberKind::Odd,
            range: (1.0, 31.0),
            default: Some(7.0),
            ..NumberSpec::LINEAR
        }),
        Parameter::Number(NumberSpec { name: "decay", range: (0.0, 1.0), ..NumberSpec::LINEAR }),
        Parameter::Word(WordSpec {
            name: "rule",
            allowed: &["or", "and"],
            default: Some("or"),
            doc: "",
        }),
        Parameter::File(FileSpec { name: "map", unit: "ln", doc: "" }),
        Parameter::Text(TextSpec { name: "law", example: "1 + x", doc: "" }),
    ];

    fn shown(given: &[(&str, Given<'_>)]) -> Result<String, String> {
        let settings = Settings::resolve(PARAMETERS, given).map_err(|error| error.to_string())?;
        let shown: Vec<String> =
            settings.iter().map(|(name, setting)| format!("{name}={setting}")).collect();
        Ok(shown.join(" "))
    }

    #[test]
    fn what_is_not_given_has_its_default_or_is_absent_and_the_last_value_counts() {
        assert_eq!(shown(&[]).unwrap(), "kernel=7 rule=or");
        let given = [("decay", Given::Text("0.5")), ("decay", Given::Number(0.25))];
        assert_eq!(shown(&given).unwrap(), "kernel=7 decay=0.25 rule=or");
        let given = [("map", Given::Word("a b.npy")), ("rule", Given::Text("and"))];
        assert_eq!(shown(&given).unwrap(), "kernel=7 rule=and map=a b.npy");
        let laws = [("law", Given::Number(0.5)), ("rule", Given::Word("and"))];
        assert_eq!(shown(&laws).unwrap(), "kernel=7 rule=and law=0.5");
        let settings = Settings::resolve(PARAMETERS, &given).unwrap();
        assert_eq!(settings.given().collect::<Vec<_>>(), ["rule", "map"]);
        assert_eq!((settings.whole("kernel"), settings.word(&PARAMETERS[2])), (7, Some("and")));
    }

    #[test]
    fn what_a_parameter_does_not_take_is_refused_with_what_it_takes() {
        for text in ["8", "33", "-1", "7.5", "nan", "inf", ""] {
            let want = format!("`kernel` = {text}, expected an odd number in 1..=31 px");
            assert_eq!(shown(&[("kernel", Given::Text(text))]), Err(want));
        }
        for (key, given, want) in [
            ("kernel", Given::Word("9"), "`kernel` = \"9\", expected an odd number in 1..=31 px"),
            ("rule", Given::Number(1.0), "`rule` = 1, expected one of or, and"),
            ("map", Given::Text(""), "`map` = , expected the path of a file"),
            ("law", Given::Word(" "), "`law` = \" \", expected text such as \"1 + x\""),
            (
                "tau",
                Given::Text("3"),
                "has no parameter `tau`; it has kernel, decay, rule, map, law",
            ),
        ] {
            assert_eq!(shown(&[(key, given)]), Err(want.to_owned()));
        }
        let nothing = Settings::resolve(&[], &[("tau", Given::Text("3"))]).unwrap_err();
        assert_eq!(nothing.to_string(), "has no parameter `tau`; it has none");
    }
}
