//! Irradiance to photocurrent, both relative to reference white.

pub(crate) mod dark_current;
pub(crate) mod quantisation;
pub(crate) mod tone_curve;
