//! The one list of all effects. Configurations, tables, the laws that are tested over every stage
//! and the candidates of the gap workflow all come from it.

use evpose_core::{Registry, registry_entry};

use crate::StageSpec;
use crate::{background, clock, detector, formula, optics, photodiode, photoreceptor, readout};

/// Every stage there is: the built-in ones in the order of the signal, then those of other crates.
pub static STAGES: Registry<StageSpec> = Registry::new(&[
    &optics::adaptive_steps::SPEC,
    &optics::lamp_flicker::SPEC,
    &optics::lens_distortion::SPEC,
    &optics::psf_blur::SPEC,
    &optics::veiling_glare::SPEC,
    &optics::vignetting::SPEC,
    &optics::exposure_blur::SPEC,
    &photodiode::tone_curve::SPEC,
    &photodiode::quantisation::SPEC,
    &photodiode::dark_current::SPEC,
    &photoreceptor::logarithmic::SPEC,
    &photoreceptor::lin_log::SPEC,
    &photoreceptor::photoreceptor_noise::SPEC,
    &photoreceptor::photoreceptor_lowpass::SPEC,
    &photoreceptor::source_follower::SPEC,
    &photoreceptor::lateral_coupling::SPEC,
    &photoreceptor::adaptive_highpass::SPEC,
    &detector::level_crossing::SPEC,
    &detector::frame_difference::SPEC,
    &detector::frame_count::SPEC,
    &detector::brownian_passage::SPEC,
    &detector::threshold_mismatch::SPEC,
    &detector::threshold_temporal_noise::SPEC,
    &detector::hysteresis::SPEC,
    &detector::leak_on::SPEC,
    &detector::parasitic_photo_leak::SPEC,
    &detector::refractory::SPEC,
    &detector::reset_overshoot::SPEC,
    &detector::dead_pixels::SPEC,
    &detector::fixed_pattern::SPEC,
    &background::shot_noise_poisson::SPEC,
    &background::hot_pixels::SPEC,
    &background::uniform_noise::SPEC,
    &readout::ideal::SPEC,
    &readout::arbiter::SPEC,
    &readout::scanned::SPEC,
    &readout::event_rate_control::SPEC,
    &formula::SPEC,
    &clock::pixel_latency::SPEC,
    &clock::timestamp_jitter::SPEC,
    &clock::clock_offset_drift::SPEC,
    &clock::frame_grid::SPEC,
    &clock::timestamp_quantisation::SPEC,
]);

registry_entry!(StageSpec, "sensor effect");
