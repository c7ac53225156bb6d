//! A sensor as a table: what a reader needs to know what is modelled, and how.

use std::fmt;

use crate::{NumberSpec, Setting, Settings, StageSpec};

/// The chain of a sensor, one row per stage in the order of the signal.
#[derive(Debug, Clone)]
pub struct ChainTable {
    /// Stages, from the lens to the readout.
    pub rows: Vec<ChainRow>,
}

/// One stage with its parameters.
#[derive(Debug, Clone)]
pub struct ChainRow {
    /// The stage, as registered.
    pub spec: &'static StageSpec,
    /// Its parameters and choices.
    pub settings: Settings,
    /// False where the parameters make the stage the identity, so that the chain leaves it out.
    pub is_active: bool,
}

pub(crate) fn quantity(number: &NumberSpec, value: f64) -> String {
    format!("{} {}", short(value), number.unit).trim_end().to_owned()
}

pub(crate) fn interval((low, high): (f64, f64)) -> String {
    format!("{} to {}", short(low), short(high))
}

/// Formats with four significant digits, enough to distinguish 1/255 from 0.004, without trailing
/// zeros.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    // Only behind a point are zeros without meaning: those of 1200 count.
    let trim = |text: &str| {
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text.to_owned()
        }
    };
    let scientific = format!("{value:.3e}");
    if !(1e-4..1e6).contains(&value.abs())
        && let Some((digits, exponent)) = scientific.split_once('e')
    {
        return format!("{}e{exponent}", trim(digits));
    }
    // The cast truncates towards zero: below one, a digit more than four significant ones is kept.
    let decimals = (4 - value.abs().log10() as i32).clamp(0, 8) as usize;
    trim(&format!("{value:.decimals$}"))
}

impl fmt::Display for ChainRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { spec, settings, is_active } = self;
        writeln!(f, "  {:<24}{}", spec.name, spec.summary)?;
        if !is_active {
            writeln!(f, "      (left out: no effect at these values)")?;
        }
        writeln!(f, "      {}", spec.formula)?;
        for (name, setting) in settings.iter() {
            match setting {
                Setting::Number(number, value) => {
                    let quantity = quantity(number, *value);
                    let typical = match number.typical {
                        // "Typical" beside a value that switches the effect off would mislead.
                        _ if Some(*value) == number.default => "(no effect)".to_owned(),
                        Some(limits) => format!("typical {}", interval(limits)),
                        None => "no property of a camera".to_owned(),
                    };
                    let range = interval(number.range);
                    writeln!(f, "      {name:<18}{quantity:<20}{typical:<28}range {range}")?;
                }
                Setting::Word(choice, word) => {
                    let mut others = choice.allowed.to_vec();
                    others.retain(|other| other != word);
                    writeln!(f, "      {name:<18}{word:<20}or {}", others.join(", "))?;
                }
                Setting::File(..) | Setting::Text(..) => writeln!(f, "      {name:<18}{setting}")?,
            }
        }
        writeln!(f, "      source: {}", spec.source.key)
    }
}

/// Stages under the names of their domains, at most a hundred columns wide.
impl fmt::Display for ChainTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for rows in self.rows.chunk_by(|a, b| a.spec.domain == b.spec.domain) {
            writeln!(f, "{}", rows[0].spec.domain.name().to_uppercase())?;
            for row in rows {
                write!(f, "{row}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EffectConfig, PRESETS, STAGES, SensorConfig, SensorModel};

    #[test]
    fn values_are_short_but_not_wrong() {
        for (value, text) in [
            (0.0, "0"),
            (255.0, "255"),
            (0.5, "0.5"),
            (1.0 / 255.0, "0.003922"),
            (2.2e-6, "2.2e-6"),
            (-0.3, "-0.3"),
            (f64::INFINITY, "inf"),
            (65_535.0, "65535"),
            (1.066e9, "1.066e9"),
            (12e6, "1.2e7"),
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
        assert_eq!(lines[0], "PHOTORECEPTOR");
        assert!(lines[1].starts_with("  logarithmic             voltage is the logarithm"));
        assert_eq!(lines[2], "      V = ln(I + dark_offset)");
        assert!(
            lines[3].starts_with("      dark_offset       0.001 white         typical 0.0001 to")
        );
        assert!(table.contains("(left out: no effect at these values)"));
    }

    #[test]
    fn tables_are_at_most_a_hundred_columns_wide() {
        for preset in &PRESETS {
            let config = SensorConfig::preset(preset.name).unwrap();
            let table = SensorModel::from_config(&config).unwrap().describe().to_string();
            for line in table.lines() {
                assert!(line.chars().count() <= 100, "{}: {line}", preset.name);
            }
        }
        for spec in &STAGES {
            for line in spec.to_string().lines() {
                assert!(line.chars().count() <= 100, "{line}");
            }
        }
    }
}
