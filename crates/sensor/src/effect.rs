//! One effect of a configuration: its name and the values of its parameters.

use std::collections::BTreeMap;

use evpose_core::Given;
use serde::{Deserialize, Serialize};

/// One effect and its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectConfig {
    /// The name of a registered stage.
    pub name: String,
    /// Its parameters; what the stage does not know is refused when the chain is built.
    #[serde(flatten)]
    pub params: BTreeMap<String, Value>,
}

/// The value of one parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number or a word in quotes")]
pub enum Value {
    /// A physical quantity, in the unit of its parameter.
    Number(f64),
    /// A word or the path of a file.
    Word(String),
}

impl Value {
    pub(crate) fn given(&self) -> Given<'_> {
        match self {
            Self::Number(number) => Given::Number(*number),
            Self::Word(word) => Given::Word(word),
        }
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for Value {
    fn from(word: &str) -> Self {
        Self::Word(word.to_owned())
    }
}

impl EffectConfig {
    /// An effect with all parameters left out.
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), params: BTreeMap::new() }
    }

    /// The same with one parameter set.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<Value>) -> Self {
        self.params.insert(key.to_owned(), value.into());
        self
    }

    /// A parameter that is given and is a number.
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.params.get(key) {
            Some(Value::Number(number)) => Some(*number),
            _ => None,
        }
    }
}
