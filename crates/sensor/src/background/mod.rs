//! Requests that no change of light has caused.

use std::fmt::Debug;

use evpose_core::{SensorSize, StageNoise};

use crate::Request;
use crate::stage::Tick;

pub(crate) mod uniform_noise;

/// Adds to the requests of a step, or takes some away.
pub trait BackgroundStage: Send + Sync + Debug {
    /// Whether the parameters make the stage the identity; the chain then leaves it out.
    fn is_neutral(&self) -> bool;

    /// Changes the requests of `tick`, which need no order: the chain puts them in order behind
    /// the last background stage. Times stay within the tick.
    fn step(&self, tick: &Tick, size: SensorSize, requests: &mut Vec<Request>, noise: StageNoise);
}
