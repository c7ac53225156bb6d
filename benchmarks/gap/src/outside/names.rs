//! Names of the catalogue that are right for what is hidden, and for what a generator always does.
//!
//! A convention of a generator is a true difference from an ideal pixel. Its name is right where it
//! is given, and no miss where it is not.

use super::row::NamedFinding;
use super::truth::{Generator, SCALED_THRESHOLDS, Truth};

#[derive(Debug)]
pub(super) struct Hidden {
    /// Names in `truth.json`.
    pub(super) names: &'static [&'static str],
    /// Right names of the catalogue, effects or parameters; none outside it.
    pub(super) right: &'static [&'static str],
}

const fn hidden(names: &'static [&'static str], right: &'static [&'static str]) -> Hidden {
    Hidden { names, right }
}

/// Background of any kind that a model can have.
const BACKGROUND: &[&str] = &["shot_noise_poisson", "uniform_noise", "noise_on_hz", "noise_off_hz"];

pub(super) const HIDDEN: &[Hidden] = &[
    // Light, before the generator.
    hidden(&["psf_blur"], &["psf_blur"]),
    hidden(&["flicker"], &["lamp_flicker"]),
    // The two are the same where the mean of the image stays.
    hidden(&["glare", "dark"], &["veiling_glare", "dark_current"]),
    // A power of light divides both thresholds.
    hidden(&["tone", SCALED_THRESHOLDS], &["tone_curve", "threshold_on", "threshold_off"]),
    hidden(&["distortion"], &["lens_distortion"]),
    hidden(&["quant"], &["quantisation"]),
    // Parameters and options of the generators.
    hidden(&["thresholds"], &["threshold_on", "threshold_off"]),
    hidden(&["mismatch", "threshold_mismatch"], &["threshold_mismatch"]),
    hidden(&["threshold_noise"], &["threshold_temporal_noise"]),
    hidden(&["lowpass"], &["photoreceptor_lowpass"]),
    // v2e's SCIDVS pixel: a high-pass with a gain of two, which halves thresholds, as a power of two
    // of light does.
    hidden(&["highpass"], &["adaptive_highpass", "threshold_on", "threshold_off", "tone_curve"]),
    hidden(&["surround"], &["lateral_coupling"]),
    hidden(&["leak"], &["leak_on"]),
    hidden(&["photo_leak"], &["parasitic_photo_leak"]),
    // DVS-Voltmeter's leak in the dark (k4) and in light (k5), under one name.
    hidden(&["parasitic_leak"], &["parasitic_photo_leak", "leak_on"]),
    hidden(&["refractory"], &["refractory"]),
    hidden(&["shot_noise"], BACKGROUND),
    // IEBCS: a regular clock of noise events in every pixel.
    hidden(&["background"], &["leak_on", "uniform_noise", "noise_on_hz", "noise_off_hz"]),
    // IEBCS: rates of the pixels of a real sensor: a leak, hot pixels, and background in the dark.
    hidden(
        &["measured_noise"],
        &[
            "leak_on",
            "hot_pixels",
            "shot_noise_poisson",
            "uniform_noise",
            "noise_on_hz",
            "noise_off_hz",
        ],
    ),
    // DVS-Voltmeter: Brownian motion of the voltage.
    hidden(
        &["noise_constant", "noise_light"],
        &[
            "brownian_passage",
            "photoreceptor_noise",
            "shot_noise_poisson",
            "uniform_noise",
            "noise_on_hz",
            "noise_off_hz",
        ],
    ),
    hidden(
        &["latency_jitter"],
        &["timestamp_jitter", "pixel_latency", "clock_offset", "clock_offset_drift"],
    ),
    // IEBCS: rows are served in turn by a clock.
    hidden(&["scan"], &["scanned_readout", "arbiter"]),
    // Events, behind the generator.
    hidden(&["hot", "hot_pixels"], &["hot_pixels"]),
    hidden(&["dead"], &["dead_pixels"]),
    hidden(&["control"], &["event_rate_control"]),
    hidden(&["jitter"], &["timestamp_jitter"]),
    hidden(&["delay"], &["pixel_latency", "clock_offset", "clock_offset_drift"]),
    hidden(&["drift"], &["clock_offset_drift"]),
    hidden(&["stamps"], &["timestamp_quantisation", "frame_grid"]),
    // Outside the catalogue.
    hidden(&["echo", "crosstalk", "flip", "gaps", "columns", "rolling", "ghost"], &[]),
];

pub(super) fn entry(name: &str) -> Option<&'static Hidden> {
    HIDDEN.iter().find(|hidden| hidden.names.contains(&name))
}

/// A name that is right in every recording of a generator.
#[derive(Debug)]
pub(super) struct Convention {
    pub(super) generator: Generator,
    pub(super) name: &'static str,
    pub(super) applies: Applies,
    /// The reason, for the documentation of a table.
    pub(super) reason: &'static str,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Applies {
    Always,
    /// A stated spread of thresholds below the nominal one, which is not there.
    BelowNominal,
    /// Thresholds that are drawn anew: the generator's spread is above zero.
    Redrawn,
    /// Light that is added before the logarithm, as little as the generator adds.
    SmallOffset,
}

impl Applies {
    pub(super) fn words(self) -> &'static str {
        match self {
            Always => "always",
            BelowNominal => "below the stated spread",
            Redrawn => "where the generator has a spread",
            SmallOffset => "below .002",
        }
    }
}

const fn convention(
    generator: Generator,
    name: &'static str,
    applies: Applies,
    reason: &'static str,
) -> Convention {
    Convention { generator, name, applies, reason }
}

use Applies::{Always, BelowNominal, Redrawn, SmallOffset};
use Generator::{Esim, Iebcs, V2e, Volt};

pub(super) const CONVENTIONS: &[Convention] = &[
    convention(V2e, "frame_grid", Always, "events are stamped on the grid of the frames"),
    convention(V2e, "timestamp_quantisation", Always, "or on simple fractions of it"),
    convention(V2e, "frame_difference", Always, "whole thresholds between frame and reference"),
    convention(V2e, "frame_count", Always, "spread evenly over the step"),
    convention(Iebcs, "frame_grid", Always, "events are a latency behind the frames"),
    convention(Iebcs, "timestamp_quantisation", Always, "which is their period"),
    convention(Iebcs, "reset_overshoot", Always, "an event resets to the voltage of its time"),
    convention(Iebcs, "threshold_temporal_noise", Always, "thresholds are redrawn at each event"),
    convention(Iebcs, "threshold_mismatch", BelowNominal, "and hence do not differ for good"),
    convention(Volt, "brownian_passage", Always, "the process that it simulates"),
    convention(Volt, "threshold_mismatch", BelowNominal, "all pixels share one threshold"),
    convention(Esim, "threshold_mismatch", BelowNominal, "all pixels share one threshold"),
    convention(Esim, "dark_current", SmallOffset, "a thousandth of white is added (log_eps)"),
    convention(Esim, "threshold_temporal_noise", Redrawn, "thresholds are redrawn at each frame"),
];

/// Parameter of `threshold_mismatch` that is its strength.
const SPREAD: &str = "sigma";
/// The same of `dark_current`, and how much of it is the convention.
const OFFSET: &str = "current";
const MAX_OFFSET: f64 = 0.002;

impl Convention {
    /// Whether it makes a finding right. `nominal_spread` is that of `scene.json`.
    pub(super) fn holds(&self, truth: &Truth, finding: &NamedFinding, nominal_spread: f64) -> bool {
        let value = |key: &str| finding.parameters.get(key).and_then(|one| one.value);
        self.generator == truth.generator
            && self.name == finding.name
            && match self.applies {
                Always => true,
                BelowNominal => value(SPREAD).is_some_and(|spread| spread < nominal_spread),
                SmallOffset => value(OFFSET).is_some_and(|offset| offset < MAX_OFFSET),
                Redrawn => truth.parameter("sigma_Cp").is_some_and(|spread| spread > 0.0),
            }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use evpose_gap::parameters::ModelParameter;
    use evpose_sensor::STAGES;

    use super::*;

    #[test]
    fn every_right_name_is_one_of_the_catalogue_or_a_parameter() {
        let mut known: HashSet<&str> = STAGES.iter().map(|spec| spec.name).collect();
        known.extend(ModelParameter::ALL.map(ModelParameter::name));
        let of_hidden = HIDDEN.iter().flat_map(|hidden| hidden.right.iter().copied());
        for name in of_hidden.chain(CONVENTIONS.iter().map(|convention| convention.name)) {
            assert!(known.contains(name), "{name}");
        }
    }

    #[test]
    fn every_hidden_effect_has_one_entry() {
        let mut names = HashSet::new();
        for name in HIDDEN.iter().flat_map(|hidden| hidden.names) {
            assert!(names.insert(name), "{name}");
        }
        assert!(entry("rolling").is_some_and(|hidden| hidden.right.is_empty()));
        assert!(entry("no such effect").is_none());
    }

    #[test]
    fn conventions_have_reasons() {
        assert!(CONVENTIONS.iter().all(|convention| !convention.reason.is_empty()));
    }
}
