//! Irradiance to photocurrent, both relative to what a white surface gives.

pub(crate) mod quantisation;
