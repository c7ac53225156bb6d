//! Irradiance to photocurrent, both relative to what a white surface gives.

pub(crate) mod dark_current;
pub(crate) mod quantisation;
pub(crate) mod tone_curve;
