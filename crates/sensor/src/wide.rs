//! The chain is a row of short loops over a block of pixels, compiled for wide vectors.

pub(crate) use evpose_core::wide;
