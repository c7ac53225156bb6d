//! The file of `--over`: fields of a config, and how each is drawn.
//!
//! Tables may be nested or dotted, as in the config itself:
//!
//! ```toml
//! training.learning_rate = { log_uniform = [1e-4, 1e-2] }
//! [network]
//! backbone = { choose = ["resnet18", "mobilenet_v2"] }
//! ```

use std::path::{Path, PathBuf};

use anyhow::{Error, Result, anyhow, ensure};
use evpose_core::CounterRng;
use toml::Value;
use toml::de::{DeTable, DeValue};

use crate::tune::distribution::Distribution;

/// A field of the config that is searched over.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parameter {
    /// Dotted name of the field.
    pub(crate) field: String,
    /// Its line in the file, from 1.
    pub(crate) line: usize,
    /// How it is drawn.
    pub(crate) distribution: Distribution,
}

impl Parameter {
    /// The value in trial `trial` of a search with the seed `seed`. Other parameters do not change
    /// it.
    pub(crate) fn draw(&self, seed: u64, trial: u64) -> Value {
        self.distribution.draw(&mut CounterRng::new(seed, &format!("tune {}", self.field), trial))
    }
}

/// The fields that a search is over.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SearchSpace {
    path: PathBuf,
    text: String,
    /// In the order of the file.
    parameters: Vec<Parameter>,
}

impl SearchSpace {
    /// Reads a file.
    pub(crate) fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| anyhow!("{}: {error}", path.display()))?;
        Self::parse(path, &text)
    }

    pub(crate) fn parse(path: &Path, text: &str) -> Result<Self> {
        let name = path.display();
        let syntax = |error: toml::de::Error| anyhow!("{name}: {error}");
        let values: toml::Table = toml::from_str(text).map_err(syntax)?;
        // Parsed twice: the tree with places holds no typed values.
        let lines = DeTable::parse(text).map_err(syntax)?;
        let mut space =
            Self { path: path.to_owned(), text: text.to_owned(), parameters: Vec::new() };
        space.collect("", &values, lines.get_ref())?;
        ensure!(
            !space.parameters.is_empty(),
            "{name}: no field to search over: write for example\n  \
             training.learning_rate = {{ log_uniform = [1e-4, 1e-2] }}"
        );
        // In the order of the file; tables sort by name.
        space.parameters.sort_by_key(|parameter| parameter.line);
        Ok(space)
    }

    /// The parameters, in the order of the file.
    pub(crate) fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The file as it stands.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    pub(crate) fn refuse(&self, parameter: &Parameter, message: &str) -> Error {
        self.error(parameter.line, &parameter.field, message)
    }

    fn error(&self, line: usize, field: &str, message: &str) -> Error {
        anyhow!("{}, line {line}: `{field}`: {message}", self.path.display())
    }

    /// Adds the parameters of a table whose dotted name is `prefix`; `lines` is the same table with
    /// places.
    fn collect(&mut self, prefix: &str, values: &toml::Table, lines: &DeTable<'_>) -> Result<()> {
        for (key, place) in lines {
            let name: &str = key.get_ref();
            let field =
                if prefix.is_empty() { name.to_owned() } else { format!("{prefix}.{name}") };
            // The parser gives bytes, and messages name lines.
            let line = self.text[..key.span().start].matches('\n').count() + 1;
            let (Some(Value::Table(table)), DeValue::Table(inner)) =
                (values.get(name), place.get_ref())
            else {
                return Err(self.error(line, &field, HOW));
            };
            if is_section(table) {
                self.collect(&field, table, inner)?;
                continue;
            }
            let distribution = match table.iter().collect::<Vec<_>>()[..] {
                [(name, Value::Array(array))] => Distribution::read(name, array),
                _ => Err(anyhow!(HOW)),
            };
            let distribution =
                distribution.map_err(|error| self.error(line, &field, &error.to_string()))?;
            self.parameters.push(Parameter { field, line, distribution });
        }
        Ok(())
    }
}

const HOW: &str = "write { log_uniform = [low, high] }, { uniform = [low, high] }, \
                   { integer = [low, high] } or { choose = [a, b, …] }";

/// Whether a table is a section of fields. Others are distributions, known or not.
fn is_section(table: &toml::Table) -> bool {
    let is_named = table.keys().any(|key| Distribution::NAMES.contains(&key.as_str()));
    let is_array = table.len() == 1 && table.values().all(Value::is_array);
    !(table.is_empty() || is_named || is_array)
}

/// A value as `--set` takes it: on one line.
pub(crate) fn inline(value: &Value) -> String {
    match value {
        Value::Table(table) => {
            let fields = table.iter().map(|(key, value)| format!("{key} = {}", inline(value)));
            format!("{{ {} }}", fields.collect::<Vec<_>>().join(", "))
        }
        Value::Array(array) => {
            format!("[{}]", array.iter().map(inline).collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn parse(text: &str) -> Result<SearchSpace> {
        SearchSpace::parse(Path::new("over.toml"), text)
    }

    #[test]
    fn dotted_quoted_and_nested_fields_are_read_in_the_order_of_the_file() {
        let space = parse(
            "training.schedule.cosine = { choose = [true, false] }\n\n[training]\nlearning_rate \
             = { log_uniform = [1e-4, 1e-2] }\n[network]\nwidth = { uniform = [0.1, 0.5] }\n",
        );
        // TOML forbids to open a table that dotted keys have made.
        assert!(space.unwrap_err().to_string().contains("line 3"));
        let space = parse(
            "network.width = { uniform = [0.1, 0.5] }\n\n[training]\nlearning_rate = { \
             log_uniform = [1e-4, 1e-2] }\n[training.schedule]\nwarm_up_steps = { integer = [0, 9] \
             }\n",
        )
        .unwrap();
        let read: Vec<(&str, usize)> =
            space.parameters().iter().map(|p| (p.field.as_str(), p.line)).collect();
        let wanted = [
            ("network.width", 1),
            ("training.learning_rate", 4),
            ("training.schedule.warm_up_steps", 6),
        ];
        assert_eq!(read, wanted);
    }

    #[test]
    fn a_draw_depends_on_seed_field_and_trial_alone() {
        let rate = "training.learning_rate = { log_uniform = [1e-4, 1e-2] }\n";
        let one = parse(rate).unwrap();
        let two = parse(&format!("network.width = {{ uniform = [0.1, 0.5] }}\n{rate}")).unwrap();
        let draws = |space: &SearchSpace, seed: u64| -> Vec<Value> {
            let last = space.parameters().last().unwrap();
            (0..8).map(|trial| last.draw(seed, trial)).collect()
        };
        assert_eq!(draws(&one, 1), draws(&two, 1));
        assert_ne!(draws(&one, 1), draws(&one, 2));
        let first = draws(&one, 1);
        assert!((1..8).all(|trial| first[trial] != first[0]));
    }

    #[test]
    fn a_fault_is_named_with_field_and_line() {
        for (text, parts) in [
            ("", &["over.toml: no field"][..]),
            ("\n[training]\nsteps = 5\n", &["line 3", "`training.steps`", "choose"]),
            ("seed = { }\n", &["line 1", "`seed`"]),
            ("a = { uniform = 3 }\n", &["line 1", "`a`", "uniform = [low, high]"]),
            ("a.b = { uniform = [3, 1] }\n", &["line 1", "`a.b`", "the lower first"]),
            ("a = { uniform = [1, 2], choose = [1] }\n", &["line 1", "`a`"]),
            ("a = { normal = [1, 2] }\n", &["line 1", "no such distribution"]),
            ("a = { uniform = [1, 2]\n", &["over.toml", "line 1"]),
        ] {
            let message = parse(text).unwrap_err().to_string();
            for part in parts {
                assert!(message.contains(part), "{text}: {message}");
            }
        }
        let missing = SearchSpace::load(Path::new("nowhere.toml")).unwrap_err().to_string();
        assert!(missing.starts_with("nowhere.toml: "), "{missing}");
    }

    #[test]
    fn values_are_written_on_one_line() {
        let text = "v = [1, { a = 0.001, b = [\"x\"] }]";
        let table: toml::Table = toml::from_str(text).unwrap();
        let written = inline(&table["v"]);
        assert_eq!(written, "[1, { a = 0.001, b = [\"x\"] }]");
        assert_eq!(toml::from_str::<toml::Table>(&format!("v = {written}")).unwrap(), table);
    }
}
