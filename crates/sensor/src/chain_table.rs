//! A sensor as a table: what a reader needs to know what is modelled, and how.

use std::fmt;

use crate::{Domain, Settings, StageSpec};

/// The chain of a sensor, one row per stage in the order of the signal.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainTable {
    /// The rows.
    pub rows: Vec<ChainRow>,
}

/// One stage with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainRow {
    /// Where the stage acts.
    pub domain: Domain,
    /// Its name.
    pub stage: &'static str,
    /// What it does.
    pub formula: &'static str,
    /// Parameters and choices with their values, as `name = value unit`.
    pub settings: Vec<String>,
    /// False where the parameters make the stage the identity, so that the chain leaves it out.
    pub is_active: bool,
    /// Authors and year of the model.
    pub source: &'static str,
}

impl ChainRow {
    pub(crate) fn new(spec: &StageSpec, settings: &Settings, is_active: bool) -> Self {
        let numbers = settings.numbers().iter().map(|(param, value)| {
            format!("{} = {} {}", param.name, short(*value), param.unit).trim_end().to_owned()
        });
        let words =
            settings.words().iter().map(|(choice, word)| format!("{} = {word}", choice.name));
        let files = settings.files().iter();
        let files = files.map(|(file, path)| format!("{} = {}", file.name, path.display()));
        Self {
            domain: spec.domain,
            stage: spec.name,
            formula: spec.formula,
            settings: numbers.chain(words).chain(files).collect(),
            is_active,
            source: spec.source.key,
        }
    }

    fn cells(&self) -> [String; 5] {
        let settings = self.settings.join(", ");
        let settings = match (self.is_active, settings.is_empty()) {
            (true, false) => settings,
            (true, true) => "-".to_owned(),
            (false, _) => format!("{settings} (no effect, left out)"),
        };
        let [domain, stage, formula, source] =
            [self.domain.name(), self.stage, self.formula, self.source].map(str::to_owned);
        [domain, stage, settings, formula, source]
    }
}

/// Four significant digits, which tell 1/255 from 0.004, without trailing zeros.
fn short(value: f64) -> String {
    let digits = if value == 0.0 || !value.is_finite() { 0 } else { value.abs().log10() as i32 };
    let decimals = (4 - digits).clamp(0, 12) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

impl fmt::Display for ChainTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let head = ["domain", "stage", "parameters", "formula", "source"].map(str::to_owned);
        let rows: Vec<[String; 5]> =
            std::iter::once(head).chain(self.rows.iter().map(ChainRow::cells)).collect();
        let mut widths = [0; 5];
        for row in &rows {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = cell.chars().count().max(*width);
            }
        }
        for row in &rows {
            let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
            writeln!(f, "{}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::{EffectConfig, SensorConfig, SensorModel};

    #[test]
    fn numbers_are_short_but_not_wrong() {
        for (value, text) in [
            (0.0, "0"),
            (255.0, "255"),
            (0.5, "0.5"),
            (1.0 / 255.0, "0.003922"),
            (2.2e-6, "0.0000022"),
            (f64::INFINITY, "inf"),
            (65_535.0, "65535"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn a_chain_reads_as_a_table() {
        let mut config = SensorConfig::default();
        config.effects.insert(0, EffectConfig::new("uniform_noise"));
        let table = SensorModel::from_config(&config).unwrap().describe().to_string();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), 5);
        assert!(lines[0].starts_with("domain         stage           parameters"));
        assert!(lines[1].starts_with("photoreceptor  logarithmic     dark_offset = 0.001 white"));
        assert!(lines[2].contains("threshold_on = 0.2 ln, threshold_off = 0.2 ln"));
        assert!(lines[3].contains("signal = kept (no effect, left out)"), "{}", lines[3]);
        assert!(lines[4].starts_with("readout        ideal_readout   -"));
    }
}
