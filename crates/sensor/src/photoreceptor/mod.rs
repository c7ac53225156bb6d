//! Photocurrent to log voltage.

use std::fmt::Debug;

pub(crate) mod adaptive_highpass;
pub(crate) mod lateral_coupling;
pub(crate) mod lin_log;
pub(crate) mod logarithmic;
pub(crate) mod photoreceptor_lowpass;
pub(crate) mod photoreceptor_noise;
pub(crate) mod pole;
pub(crate) mod source_follower;

/// The law by which a pixel turns photocurrent into voltage. Without memory: what takes time is a
/// stage of its own behind it.
pub trait Photoreceptor: Send + Sync + Debug {
    /// Voltage in units of ln for photocurrents relative to white. Both slices have the same
    /// length; photocurrents are finite and not negative.
    fn respond(&self, photocurrent: &[f32], voltage: &mut [f32]);

    /// The light below which voltage hardly follows, relative to white.
    fn dark_light(&self) -> f32;
}
