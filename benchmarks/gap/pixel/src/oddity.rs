//! Effects that no catalogue has, and the strengths at which they appear.

use crate::circuit::{Circuit, DetectorOddity, ReadoutOddity, Timer};

/// Effects outside every catalogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Oddity {
    /// Events come back 30 ms later.
    EventEcho,
    /// Time in reset after ON events only.
    OneSidedRefractory,
    /// Thresholds alike among neighbours.
    SmoothThresholds,
    /// Mismatch that grows towards the dark.
    LightDependentMismatch,
    /// Events lost in bursts.
    CorrelatedLoss,
    /// Events copied to the neighbour on the right.
    NeighbourCopy,
    /// A higher threshold for the polarity that did not fire last.
    Hysteresis,
    /// Every reset shifts the memory the same way.
    ChargeInjection,
}

/// All of them.
pub const ODDITIES: [Oddity; 8] = [
    Oddity::EventEcho,
    Oddity::OneSidedRefractory,
    Oddity::SmoothThresholds,
    Oddity::LightDependentMismatch,
    Oddity::CorrelatedLoss,
    Oddity::NeighbourCopy,
    Oddity::Hysteresis,
    Oddity::ChargeInjection,
];

/// Puts an oddity into a circuit; `round` 0, 1 and 2 are stronger and stronger.
pub fn install_oddity(oddity: Oddity, round: usize, circuit: &mut Circuit) {
    let grow = [1.0, 1.6, 2.4][round.min(2)];
    let threshold_mv = circuit.detector.threshold_on_mv;
    let share = 0.12 * grow;
    match oddity {
        Oddity::EventEcho => {
            circuit.readout.oddity = Some(ReadoutOddity::Echo { share, delay_s: 0.03 });
        }
        Oddity::NeighbourCopy => {
            circuit.readout.oddity = Some(ReadoutOddity::NeighbourCopy { share, delay_s: 4e-6 });
        }
        Oddity::CorrelatedLoss => {
            let share = (0.4 * grow).min(0.9);
            let loss = ReadoutOddity::BurstLoss { share, bad_s: 0.01, good_s: 0.03 };
            circuit.readout.oddity = Some(loss);
        }
        Oddity::OneSidedRefractory => {
            // 4 ms, 6.4 ms, 9.6 ms: 10 fC over the discharging current.
            let current_pa = 2.5 / grow;
            let timer = Timer { current_pa, capacitance_ff: 20.0, swing_v: 0.5 };
            circuit.detector.oddity = Some(DetectorOddity::OneSidedTimer(timer));
        }
        Oddity::SmoothThresholds => {
            circuit.detector.oddity =
                Some(DetectorOddity::SmoothOffsets { sigma_ln: 0.08 * grow, length_px: 12.0 });
        }
        Oddity::LightDependentMismatch => {
            circuit.detector.oddity = Some(DetectorOddity::DarkOffsets { sigma_ln: 0.12 * grow });
        }
        Oddity::Hysteresis => {
            let extra_mv = 0.2 * grow * threshold_mv;
            circuit.detector.oddity = Some(DetectorOddity::Hysteresis { extra_mv });
        }
        Oddity::ChargeInjection => {
            // A twelfth of a threshold on C2, and more.
            let charge_ac = threshold_mv / 12.0 * grow * circuit.detector.feedback_ff;
            circuit.detector.oddity = Some(DetectorOddity::ChargeInjection { charge_ac });
        }
    }
}
