//! The one list of all effects. Configurations, tables, the laws that are tested over every stage
//! and the candidates of the gap workflow all come from it.

use crate::StageSpec;
use crate::{background, clock, detector, optics, photodiode, photoreceptor, readout};

/// Every stage there is, in the order of the signal.
pub static STAGES: &[&StageSpec] = &[
    &optics::psf_blur::SPEC,
    &photodiode::quantisation::SPEC,
    &photoreceptor::logarithmic::SPEC,
    &detector::level_crossing::SPEC,
    &detector::frame_difference::SPEC,
    &background::uniform_noise::SPEC,
    &readout::ideal::SPEC,
    &clock::timestamp_quantisation::SPEC,
];
