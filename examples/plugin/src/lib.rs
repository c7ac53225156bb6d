//! A plugin: one effect, one representation, one cleaner and one backbone that are not of evpose.
//!
//! A file each, as within evpose; instead of a line in a registry, [`register`] adds them while the
//! program runs. `src/main.rs` is the whole command line with them.

mod backbone;
mod cleaner;
mod effect;
mod representation;

use evpose_clean::CLEANERS;
use evpose_core::RegistryError;
use evpose_nn::BACKBONES;
use evpose_repr::REPRESENTATIONS;
use evpose_sensor::STAGES;

/// Registers all of the plugin: once, at the beginning of `main`.
///
/// # Errors
/// If a name is taken.
pub fn register() -> Result<(), RegistryError> {
    STAGES.register(&[&effect::SOFT_SATURATION])?;
    REPRESENTATIONS.register(&[&representation::SIGNED_LNES])?;
    CLEANERS.register(&[&cleaner::BORDER])?;
    BACKBONES.register(&[&backbone::TINY])
}
