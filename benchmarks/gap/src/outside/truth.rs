//! `truth.json` of a case: its generator, and what is hidden in it.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Generator {
    V2e,
    Iebcs,
    /// DVS-Voltmeter.
    Volt,
    Esim,
}

impl Generator {
    pub(super) const ALL: [Self; 4] = [Self::V2e, Self::Iebcs, Self::Volt, Self::Esim];

    /// The name that its authors use.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::V2e => "v2e",
            Self::Iebcs => "IEBCS",
            Self::Volt => "DVS-Voltmeter",
            Self::Esim => "ESIM",
        }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Truth {
    pub(super) generator: Generator,
    pub(super) scene: String,
    /// Hidden effects, in no order.
    #[serde(deserialize_with = "without_nothing")]
    pub(super) effects: Vec<HiddenEffect>,
    #[serde(default)]
    pub(super) parameters: Map<String, Value>,
}

/// A hidden effect, under the name that the recipe gives it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct HiddenEffect {
    pub(super) name: String,
    /// Weak, middle or strong.
    pub(super) strength: String,
    /// Whether runs of the generator with and without it differ more than two seeds do.
    #[serde(rename = "visible")]
    pub(super) is_visible: bool,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    /// Name and strength from 1 to 3; visible.
    Brief(String, u32),
    Full {
        name: String,
        strength: String,
        visible: bool,
        #[serde(default)]
        parameters: Map<String, Value>,
    },
}

/// Name of no effect at all.
const NOTHING: &str = "none";
/// Thresholds that differ from the nominal ones by the same factor, which is what a power of light
/// does as well.
pub(super) const SCALED_THRESHOLDS: &str = "thresholds_by_one_factor";

impl From<Written> for HiddenEffect {
    fn from(written: Written) -> Self {
        match written {
            Written::Brief(name, strength) => {
                // Written as 1 to 3; what is beyond is taken for the nearest.
                let strength = ["weak", "middle", "strong"][strength.clamp(1, 3) as usize - 1];
                Self { name, strength: strength.to_owned(), is_visible: true }
            }
            Written::Full { name, strength, visible, parameters } => {
                // Both thresholds scaled alike are one effect: other names are right for it.
                let factor = |key| parameters.get(key).and_then(Value::as_f64);
                let is_scaled = name == "thresholds"
                    && factor("factor_on")
                        .zip(factor("factor_off"))
                        .is_some_and(|(on, off)| (on / off - 1.0).abs() < 1e-9);
                let name = if is_scaled { SCALED_THRESHOLDS.to_owned() } else { name };
                Self { name, strength, is_visible: visible }
            }
        }
    }
}

fn without_nothing<'a, D: serde::Deserializer<'a>>(from: D) -> Result<Vec<HiddenEffect>, D::Error> {
    let written = Vec::<Written>::deserialize(from)?;
    let effects = written.into_iter().map(HiddenEffect::from);
    Ok(effects.filter(|effect| effect.name != NOTHING).collect())
}

impl Truth {
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text =
            std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
        serde_json::from_str(&text).with_context(|| path.display().to_string())
    }

    pub(super) fn parameter(&self, key: &str) -> Option<f64> {
        self.parameters.get(key).and_then(Value::as_f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effects(json: &str) -> Vec<HiddenEffect> {
        let text = format!(r#"{{"generator": "volt", "scene": "bars", "effects": {json}}}"#);
        serde_json::from_str::<Truth>(&text).unwrap().effects
    }

    #[test]
    fn both_forms_are_read_and_none_is_no_effect() {
        assert!(effects(r#"[["none", 1]]"#).is_empty());
        let brief = effects(r#"[["leak", 3]]"#);
        assert_eq!((brief[0].name.as_str(), brief[0].strength.as_str()), ("leak", "strong"));
        let full = effects(r#"[{"name": "leak", "strength": "weak", "visible": false}]"#);
        assert!(!full[0].is_visible && brief[0].is_visible);
    }

    #[test]
    fn thresholds_of_one_factor_are_an_effect_of_their_own() {
        let name = |on: f64, off: f64| {
            let parameters = format!(r#"{{"factor_on": {on}, "factor_off": {off}}}"#);
            effects(&format!(
                r#"[{{"name": "thresholds", "strength": "weak", "visible": true,
                     "parameters": {parameters}}}]"#
            ))
            .remove(0)
            .name
        };
        assert_eq!(name(1.2, 1.2), SCALED_THRESHOLDS);
        assert_eq!(name(1.2, 1.0 / 1.2), "thresholds");
    }
}
