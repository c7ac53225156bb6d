//! Surfaces that are where a distance is zero: what bodies made in code are drawn from.

pub(crate) mod cone;
mod polygonise;
mod surface;

pub(crate) use polygonise::Grid;
pub(crate) use surface::surface;
