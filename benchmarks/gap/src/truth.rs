//! The truth of a case in the words of the catalogue.

use gapbench_pixel::{CaseKind, Label, TermKind};
use serde::{Deserialize, Serialize};

use super::part::PlanId;

/// Parameters of the benchmark: effect, its name there, effect and name in the catalogue, factor.
const NAMES: &[(&str, &str, &str, &str, f64)] = &[
    ("lamp_flicker", "frequency", "lamp_flicker", "frequency_hz", 1.0),
    ("lamp_flicker", "depth", "lamp_flicker", "depth", 1.0),
    ("psf_blur", "sigma", "psf_blur", "sigma_px", 1.0),
    ("veiling_glare", "share", "veiling_glare", "fraction", 1.0),
    ("photoreceptor_lowpass", "corner_at_white", "photoreceptor_lowpass", "cutoff_hz", 1.0),
    ("photoreceptor_lowpass", "second_pole", "source_follower", "cutoff_hz", 1.0),
    ("photoreceptor_noise", "sigma", "photoreceptor_noise", "sigma", 1.0),
    ("photoreceptor_noise", "bandwidth_at_white", "photoreceptor_noise", "cutoff_hz", 1.0),
    ("shot_noise_poisson", "rate_in_darkness", "shot_noise_poisson", "rate_hz", 1.0),
    ("adaptive_highpass", "tau", "adaptive_highpass", "tau_s", 1.0),
    ("dark_current", "equivalent_luminance", "dark_current", "current", 1.0),
    ("leak_on", "rate", "leak_on", "rate_hz", 1.0),
    ("threshold_mismatch", "sigma_C", "threshold_mismatch", "sigma", 1.0),
    ("threshold_temporal_noise", "sigma", "threshold_temporal_noise", "sigma", 1.0),
    ("refractory", "period", "refractory", "period_us", 1e6),
    ("hot_pixels", "share", "hot_pixels", "fraction", 1.0),
    ("hot_pixels", "median_rate", "hot_pixels", "median_hz", 1.0),
    ("arbiter", "rate_in_full_rows", "arbiter", "rate_hz", 1.0),
    ("scanned_readout", "period", "scanned_readout", "period_us", 1e6),
    ("timestamp_jitter", "sigma", "timestamp_jitter", "sigma_us", 1e6),
    ("timestamp_quantisation", "period", "timestamp_quantisation", "period_us", 1e6),
    ("pixel_latency", "delay", "pixel_latency", "delay_us", 1e6),
    ("threshold_offset", "C_on", "threshold_on", "threshold_on", 1.0),
    ("threshold_offset", "C_off", "threshold_off", "threshold_off", 1.0),
    ("uniform_noise", "rate_on", "noise_on_hz", "noise_on_hz", 1.0),
    ("uniform_noise", "rate_off", "noise_off_hz", "noise_off_hz", 1.0),
    ("clock_offset", "offset", "clock_offset", "clock_offset", 1e6),
];

/// A hidden low-pass has a source follower behind it. It is an effect of its own where its corner
/// is no higher than that of the node at white; else it is there and does nothing that could be
/// seen.
const LOWPASS: &str = "photoreceptor_lowpass";
const FOLLOWER: &str = "source_follower";
const NODE_CORNER: &str = "corner_at_white";
const FOLLOWER_CORNER: &str = "second_pole";

/// Ground truth of a case: what of its label is scored. Opened labels are stored as lines of these.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Truth {
    pub(super) id: String,
    #[serde(flatten)]
    pub(super) plan: PlanId,
    pub(super) kind: CaseKind,
    /// Strength from 0 to 3, of singles.
    pub(super) strength: Option<usize>,
    pub(super) scene: String,
    pub(super) is_visible: bool,
    /// Whether it is not in the catalogue that it is looked up in.
    pub(super) is_outside: bool,
    /// All that is hidden, in the names of the benchmark.
    pub(super) hidden: Vec<String>,
    /// Effects, in the names of the catalogue where it has them.
    pub(super) effects: Vec<String>,
    /// Those of them that are visible.
    pub(super) visible: Vec<String>,
    /// Parameters of the model whose values are not the nominal ones.
    pub(super) parameters: Vec<String>,
    /// Names that are right for each convention of the camera.
    pub(super) conventions: Vec<Vec<String>>,
    /// True values: finding, its parameter, value.
    pub(super) values: Vec<(String, String, f64)>,
    /// A remark on the case: none where names are plain.
    pub(super) note: Option<String>,
    /// Whether the source follower behind a hidden low-pass is an effect of its own.
    has_follower: bool,
}

impl Truth {
    pub(super) fn from_label(label: &Label, plan: PlanId) -> Self {
        let terms = || label.truth.iter().map(|truth| &truth.term);
        let effects = || label.truth.iter().filter(|truth| truth.term.kind == TermKind::Effect);
        let visible = effects().filter(|truth| truth.evidence.visible);
        let values = terms().flat_map(|term| {
            term.parameters.iter().filter_map(|parameter| {
                let is_same = |(effect, name, ..): &&(&str, &str, &str, &str, f64)| {
                    (*effect, *name) == (term.name, parameter.name)
                };
                let (_, _, finding, key, factor) = NAMES.iter().find(is_same)?;
                Some(((*finding).to_owned(), (*key).to_owned(), factor * parameter.value))
            })
        });
        let values: Vec<_> = values.collect();
        // A value that the description states is nothing to be found.
        let differs = |(finding, _, value): &&(String, String, f64)| {
            nominal(label, finding).is_some_and(|nominal| (value - nominal).abs() > 1e-9)
        };
        // A low-pass has one corner or two; without a node, the follower is all there is.
        let corners = terms().filter(|term| term.name == LOWPASS).find_map(|term| {
            let value = |name| term.parameters.iter().find(|p| p.name == name).map(|p| p.value);
            Some((value(FOLLOWER_CORNER)?, value(NODE_CORNER).unwrap_or(f64::INFINITY)))
        });
        // The lower corner is what can be seen: behind a slower node, a follower hardly shows.
        let has_follower = corners.is_some_and(|(follower_hz, node_hz)| follower_hz <= node_hz);
        let note = corners.filter(|_| has_follower).map(|(follower_hz, node_hz)| {
            format!(
                "two effects: a source follower of {follower_hz:.0} Hz behind a node of \
                 {node_hz:.0} Hz at white; either name is right"
            )
        });
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let name = |truth: &gapbench_pixel::Truth| truth.term.name.to_owned();
        Self {
            id: label.id.clone(),
            plan,
            kind: label.kind,
            strength: label.strength,
            scene: label.train.scene.name().to_owned(),
            is_visible: label.visible,
            is_outside: label.outside_catalogue,
            hidden: label.truth.iter().map(name).collect(),
            effects: effects().map(name).collect(),
            visible: visible.map(name).collect(),
            parameters: values.iter().filter(differs).map(|(name, ..)| name.clone()).collect(),
            conventions: label.conventions.iter().map(|c| owned(c.names)).collect(),
            values,
            note,
            has_follower,
        }
    }

    /// Whether an effect that was named is one that is there, hidden or by convention.
    pub(super) fn holds(&self, name: &str) -> bool {
        self.hides(name) || self.is_convention(name)
    }

    pub(super) fn is_convention(&self, name: &str) -> bool {
        self.conventions.iter().flatten().any(|right| right == name)
    }

    /// Whether an effect that was named is one of the hidden ones.
    pub(super) fn hides(&self, name: &str) -> bool {
        self.has(name) || (self.has_follower && name == FOLLOWER)
    }

    fn has(&self, name: &str) -> bool {
        self.effects.iter().any(|effect| effect == name)
    }

    /// The same where a source follower passes for any low-pass.
    pub(super) fn holds_leniently(&self, name: &str) -> bool {
        self.holds(name) || (self.has(LOWPASS) && name == FOLLOWER)
    }

    pub(super) fn is_named(&self, truth: &str, names: &[&str]) -> bool {
        names.contains(&truth)
            || (self.has_follower && truth == LOWPASS && names.contains(&FOLLOWER))
    }

    /// The same where a source follower passes for any low-pass.
    pub(super) fn is_named_leniently(&self, truth: &str, names: &[&str]) -> bool {
        self.is_named(truth, names) || (truth == LOWPASS && names.contains(&FOLLOWER))
    }
}

/// Nominal value of a parameter of the model, in the unit of the catalogue; none of an effect's.
fn nominal(label: &Label, finding: &str) -> Option<f64> {
    match finding {
        "threshold_on" => Some(label.nominal.c_on),
        "threshold_off" => Some(label.nominal.c_off),
        "noise_on_hz" => Some(label.nominal.noise_on_hz),
        "noise_off_hz" => Some(label.nominal.noise_off_hz),
        "clock_offset" => Some(0.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    fn lowpass(strength: usize) -> Truth {
        let all = example::opened();
        let is_it = |opened: &&crate::opened::Opened| {
            opened.truth.strength == Some(strength) && opened.truth.effects == [LOWPASS]
        };
        all.iter().find(is_it).expect("a low-pass").truth.clone()
    }

    #[test]
    fn a_stored_truth_is_the_truth() {
        for opened in example::opened().iter().chain(&example::opened_home()) {
            let line = serde_json::to_string(&opened.truth).unwrap();
            assert_eq!(serde_json::from_str::<Truth>(&line).unwrap(), opened.truth);
        }
    }

    #[test]
    fn a_source_follower_far_above_the_node_is_a_wrong_name() {
        let truth = lowpass(3);
        assert!(!truth.holds(FOLLOWER) && !truth.is_named(LOWPASS, &[FOLLOWER]));
        assert!(truth.holds_leniently(FOLLOWER));
        assert!(truth.is_named_leniently(LOWPASS, &[FOLLOWER]));
        assert!(truth.note.is_none() && truth.holds(LOWPASS));
    }

    #[test]
    fn a_source_follower_below_the_node_is_an_effect_of_its_own_and_said_so() {
        let truth = lowpass(0);
        assert!(truth.holds(FOLLOWER) && truth.is_named(LOWPASS, &[FOLLOWER]));
        assert!(truth.note.is_some_and(|note| note.contains("two effects")));
    }

    #[test]
    fn names_of_conventions_are_right_and_hide_nothing() {
        let all = example::opened_home();
        for opened in &all {
            let Truth { conventions, effects, .. } = &opened.truth;
            assert!(conventions.iter().flatten().all(|name| opened.truth.holds(name)));
            assert!(effects.iter().all(|name| opened.truth.hides(name)));
        }
        assert!(all.iter().all(|opened| opened.truth.conventions.len() >= 3));
    }

    #[test]
    fn a_parameter_is_hidden_where_its_value_is_not_nominal() {
        let all = example::opened_home();
        let of = |name: &str| {
            let has = |o: &&crate::opened::Opened| o.truth.parameters.iter().any(|p| p == name);
            all.iter().filter(has).count()
        };
        // Of 60 cases, a fifth each: ON, OFF, both, background, clock.
        assert_eq!((of("threshold_on"), of("threshold_off")), (24, 24));
        assert_eq!((of("noise_on_hz"), of("noise_off_hz"), of("clock_offset")), (12, 12, 12));
    }

    #[test]
    fn names_that_are_not_there_are_wrong_however_leniently_one_looks() {
        for strength in 0..4 {
            assert!(!lowpass(strength).holds_leniently("refractory"));
        }
    }
}
