//! Photocurrent to log voltage.

use std::fmt::Debug;

pub(crate) mod logarithmic;

/// The law by which a pixel turns photocurrent into voltage. Without memory: what takes time is a
/// stage of its own behind it.
pub trait Photoreceptor: Send + Sync + Debug {
    /// Voltage in units of ln for photocurrents relative to white. Both slices have the same
    /// length; photocurrents are finite and not negative.
    fn respond(&self, photocurrent: &[f32], voltage: &mut [f32]);
}
