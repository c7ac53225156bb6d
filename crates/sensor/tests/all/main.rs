//! Tests of the sensor by its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, reason = "tests")]

mod background_noise;
mod catalogue;
mod detector_terms;
mod digest;
mod formula;
mod laws;
mod presets;
mod readout_and_clock;
mod sensor;
mod signal_path;
mod support;
mod v2e;
mod waiting_readout;
