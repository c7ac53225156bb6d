//! The truth of a case in the words of the catalogue.

use gapbench_pixel::{Label, TermKind};

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

/// Second names: an effect of the benchmark is one or two of the catalogue.
const BESIDE: &[(&str, &str)] = &[("photoreceptor_lowpass", "source_follower")];

/// What is hidden in a case.
#[derive(Debug)]
pub(super) struct Truth {
    /// Effects, in the names of the catalogue where it has them.
    pub(super) effects: Vec<&'static str>,
    /// Numbers: finding, its parameter, value.
    pub(super) numbers: Vec<(&'static str, &'static str, f64)>,
}

impl Truth {
    pub(super) fn of(label: &Label) -> Self {
        let terms = || label.truth.iter().map(|truth| &truth.term);
        let effects = terms().filter(|term| term.kind == TermKind::Effect);
        let numbers = terms().flat_map(|term| {
            term.parameters.iter().filter_map(|parameter| {
                let is_same = |(effect, name, ..): &&(&str, &str, &str, &str, f64)| {
                    (*effect, *name) == (term.name, parameter.name)
                };
                let (_, _, finding, key, factor) = NAMES.iter().find(is_same)?;
                Some((*finding, *key, factor * parameter.value))
            })
        });
        Self { effects: effects.map(|term| term.name).collect(), numbers: numbers.collect() }
    }

    /// Whether an effect that was named is one that is there.
    pub(super) fn holds(&self, name: &str) -> bool {
        self.effects.iter().any(|truth| *truth == name || BESIDE.contains(&(*truth, name)))
    }

    /// Whether an effect that is there was named.
    pub(super) fn is_named(truth: &str, names: &[&str]) -> bool {
        names.iter().any(|name| *name == truth || BESIDE.contains(&(truth, *name)))
    }
}
