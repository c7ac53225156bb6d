//! A bus without limit: every request is served when it is made.
//!
//! # Model
//! `t_served = t_request`.
//!
//! # Source
//! The limit of an arbiter without load. A real one serves some 12 million events per second on a
//! DAVIS346 (Brandli et al. 2014 describe the family).

use evpose_core::SensorSize;

use super::Readout;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{Citation, Domain, Request, StageSpec, Traits};

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "ideal_readout",
    domain: Domain::Readout,
    summary: "every request is served when it is made",
    formula: "t_served = t_request",
    params: &[],
    source: Citation {
        key: "Brandli et al. 2014",
        text: "C. Brandli, R. Berner, M. Yang, S.-C. Liu, T. Delbruck: A 240x180 130 dB 3 us Latency \
               Global Shutter Spatiotemporal Vision Sensor, IEEE JSSC 49(10), 2014",
    },
    signature: Signature {
        look_for: "every event at the time of its request: a flash is a vertical line",
        probe: Probe::FlashRaster,
        strength: Strength::Unchanging,
        beside: &[],
    },
    build: |_| Ok(Stage::Readout(Box::new(Ideal))),
};

#[derive(Debug)]
pub(crate) struct Ideal;

impl Readout for Ideal {
    fn traits(&self) -> Traits {
        Traits { is_static: true, ..Traits::default() }
    }

    fn acknowledge(&self, request: &Request, _size: SensorSize, _state: &mut [f64]) -> Option<f64> {
        Some(request.t_s)
    }
}
