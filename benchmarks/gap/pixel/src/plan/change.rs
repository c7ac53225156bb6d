//! Hidden things: changes of a circuit, and the slots that they occupy.

use crate::circuit::Circuit;
use crate::draw::{Purpose, Sequence};
use crate::effect::{EFFECTS, Effect, STRENGTHS};
use crate::oddity::{Oddity, install_oddity};
use crate::slot::Slot;

pub(super) struct CircuitChange {
    pub(super) slots: Vec<Slot>,
    apply: Box<dyn Fn(&mut Circuit)>,
}

impl CircuitChange {
    fn new(slots: &[Slot], apply: impl Fn(&mut Circuit) + 'static) -> Self {
        Self { slots: slots.to_vec(), apply: Box::new(apply) }
    }

    pub(super) fn apply(&self, circuit: &mut Circuit) {
        (self.apply)(circuit);
    }
}

pub(super) fn install(effect: Effect, strength: usize, draws: &mut Sequence) -> CircuitChange {
    // An effect has a stream of its own: how much it draws moves nothing behind it.
    let key = draws.bits();
    CircuitChange::new(&[effect.slot()], move |circuit| {
        effect.install(strength, circuit, &mut Sequence::new(key, Purpose::Plan, 1));
    })
}

pub(super) fn install_uncatalogued(oddity: Oddity, round: usize) -> CircuitChange {
    CircuitChange::new(&[oddity.slot()], move |circuit| install_oddity(oddity, round, circuit))
}

pub(super) fn any_effect(draws: &mut Sequence) -> Effect {
    EFFECTS[draws.below(EFFECTS.len())]
}

/// One of the two highest strengths.
pub(super) fn high_strength(draws: &mut Sequence) -> usize {
    STRENGTHS - 2 + draws.below(2)
}

/// One parameter away from nominal: thresholds (ON, OFF or both), background, or the clock's zero.
pub(super) fn parameter(draws: &mut Sequence, number: usize) -> CircuitChange {
    match number % 5 {
        side @ 0..=2 => {
            let mut factor = || {
                let amount = draws.between(0.05, 0.4);
                1.0 + draws.sign() * amount
            };
            // Both are drawn in any case: what follows does not depend on the side.
            let (on, off) = (factor(), factor());
            CircuitChange::new(&[Slot::Thresholds], move |circuit| {
                if side != 1 {
                    circuit.detector.threshold_on_mv *= on;
                }
                if side != 0 {
                    circuit.detector.threshold_off_mv *= off;
                }
            })
        }
        3 => {
            let (on_hz, off_hz) = (draws.log_between(0.15, 2.0), draws.log_between(0.05, 1.0));
            CircuitChange::new(&[Slot::BackgroundRate], move |circuit| {
                circuit.background.on_hz += on_hz;
                circuit.background.off_hz += off_hz;
            })
        }
        _ => {
            let offset_us = draws.between(1000.0, 5000.0).round();
            CircuitChange::new(&[Slot::Delay], move |circuit| circuit.clock.offset_us = offset_us)
        }
    }
}
