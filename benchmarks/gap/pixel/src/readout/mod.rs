//! From the pixels to the time-stamper: who is read when, and what goes wrong on the way.

mod arbiter;
mod oddity;
mod scan;

use crate::circuit::{Access, Readout};
use crate::event::Spike;
use crate::pixel::Seeds;

/// Sends time-ordered `spikes` through the readout; the result carries the times of reading and is
/// no longer ordered.
pub fn read_out(readout: &Readout, seeds: Seeds, spikes: Vec<Spike>) -> Vec<Spike> {
    // Copies come before the bus, where they wait for their turn like every event.
    let spikes = match readout.oddity {
        Some(oddity) => oddity::disturb(oddity, seeds.run, spikes),
        None => spikes,
    };
    match readout.access {
        Access::Direct => spikes,
        Access::Arbiter { row_ns, event_ns } => {
            arbiter::serve(&spikes, row_ns * 1e-9, event_ns * 1e-9)
        }
        Access::Scan { column_ns } => scan::visit(&spikes, column_ns * 1e-9),
    }
}
