//! Events happen at exposures only: the grid of a simulation that steps from frame to frame.
//!
//! # Model
//! `t ← t + pull (t_exposure - t)`, with the exposure behind the event: at `pull = 1` all events of
//! a step carry the time of its end.
//!
//! # Source
//! EventHands (Rudnev et al. 2021) stamps all events of a frame in this way.

use evpose_core::StageNoise;

use super::ClockStage;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::tick::Tick;
use crate::{Citation, Domain, LINEAR_OFF_AT_ZERO, NumberSpec, Parameter, Request, StageSpec};

const PULL: Parameter = Parameter::Number(NumberSpec {
    name: "pull",
    range: (0.0, 1.0),
    doc: "how far events move to the exposure: 1 puts all of them there",
    ..LINEAR_OFF_AT_ZERO
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "frame_grid",
    domain: Domain::Clock,
    summary: "events carry the time of the exposure behind them",
    formula: "t = t + pull (t_exposure - t)",
    params: &[PULL],
    source: Citation::RUDNEV_2021,
    signature: Signature {
        look_for: "stamps are drawn towards the exposures: a saw tooth with the period of the \
                   frames",
        probe: Probe::StampError,
        strength: Strength::Rising(&["pull"]),
        beside: &[],
    },
    build: |settings| Ok(Stage::Clock(Box::new(FrameGrid { pull: settings.number(&PULL) }))),
};

#[derive(Debug)]
struct FrameGrid {
    pull: f64,
}

impl ClockStage for FrameGrid {
    fn step(&self, tick: &Tick, events: &mut Vec<Request>, _state: &mut [f64], _noise: StageNoise) {
        for event in events {
            event.t_s += self.pull * (tick.end_s - event.t_s).max(0.0);
        }
    }
}
