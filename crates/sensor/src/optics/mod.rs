//! Luminance to irradiance: what the lens does before any pixel sees light.

pub(crate) mod psf_blur;
