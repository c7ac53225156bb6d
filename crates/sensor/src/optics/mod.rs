//! Luminance to irradiance: lamps, and what the lens does before any pixel sees light.
//!
//! A shift of the camera against its calibration (six degrees of freedom) is not here: it moves
//! near things further than far ones, which a plane of luminance no longer knows. It belongs to
//! the camera of the scene.

pub(crate) mod adaptive_steps;
pub(crate) mod divider;
pub(crate) mod exposure_blur;
pub(crate) mod lamp_flicker;
pub(crate) mod lens_distortion;
pub(crate) mod psf_blur;
mod step_limit;
pub(crate) mod veiling_glare;
pub(crate) mod vignetting;

pub use step_limit::AdaptiveSteps;
