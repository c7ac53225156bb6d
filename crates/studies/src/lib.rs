//! Studies: many trainings, one table, and verdicts that are computed.
//!
//! * [`ablate`]: the full method with one change at a time.
//! * [`compare`]: the systems that MoveEnet was compared with, under one protocol.
//! * [`external`]: networks of others, run from their ONNX files.
//! * [`tune`]: hyper-parameter search.
//! * [`payoff`]: what closing the gap of a sensor model is worth.

pub mod ablate;
pub mod compare;
pub mod external;
pub mod payoff;
mod study;
pub mod tune;
