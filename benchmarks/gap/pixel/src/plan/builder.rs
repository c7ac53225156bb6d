//! Cases from draws: scenes, seeds, nominal values, and circuits with and without each change.

use super::change::{CircuitChange, install, parameter};
use crate::case::{Case, CaseKind, RecordingSetup, nominal_circuit};
use crate::catalogue::Nominal;
use crate::circuit::{Circuit, NOMINAL_THRESHOLD_LN, NoiseAddress};
use crate::convention::{Convention, draw_conventions};
use crate::draw::{Purpose, Sequence, mix};
use crate::effect::{EFFECTS, STRENGTHS};
use crate::scene::SCENE_KINDS;
use crate::slot::Slot;
use crate::tier::Tier;

/// Nominal background rates (ON, OFF) in Hz for each pixel; a case has one of them.
const NOMINAL_NOISE_HZ: [(f64, f64); 3] = [(0.0, 0.0), (0.02, 0.005), (0.06, 0.02)];

/// Keeps the draws of plans with conventions apart from those of plans without.
const HOME_KEY: u64 = 0x686f_6d65;

pub(super) struct Builder {
    seed: u64,
    tier: Tier,
    pub(super) cases: Vec<Case>,
}

impl Builder {
    pub(super) fn new(seed: u64, tier: Tier) -> Self {
        Self { seed, tier, cases: Vec::new() }
    }

    /// Adds every effect alone at every strength, on this many scenes.
    pub(super) fn push_singles(&mut self, scenes: usize) {
        for (e, effect) in EFFECTS.into_iter().enumerate() {
            for scene in 0..scenes {
                // One camera and scene for the four strengths.
                let number = e * scenes + scene;
                for strength in 0..STRENGTHS {
                    self.push(CaseKind::Single, number, Some(strength), None, |draws| {
                        vec![install(effect, strength, draws)]
                    });
                }
            }
        }
    }

    pub(super) fn push_nulls_and_parameters(&mut self, nulls: usize, parameters: usize) {
        for i in 0..nulls {
            self.push(CaseKind::Null, i, None, None, |_| Vec::new());
        }
        for i in 0..parameters {
            self.push(CaseKind::Parameter, i, None, None, |draws| vec![parameter(draws, i)]);
        }
    }

    /// Adds a case. Cases of one kind and number have camera, scenes and conventions in common,
    /// whatever their strength.
    pub(super) fn push(
        &mut self,
        kind: CaseKind,
        number: usize,
        strength: Option<usize>,
        leave_out: Option<&'static str>,
        changes: impl FnOnce(&mut Sequence) -> Vec<CircuitChange>,
    ) {
        // Tiers of one seed have no case in common.
        let seed = match self.tier {
            Tier::Plain => self.seed,
            Tier::Home => mix(self.seed ^ HOME_KEY),
        };
        let key = mix(seed ^ mix((kind as u64) << 32 | number as u64));
        // Camera and scenes depend on kind and number alone, not on the strength.
        let mut draws = Sequence::new(key, Purpose::Plan, 0);
        // Kinds of scenes in turn, so that every kind of case has each.
        let first = number % SCENE_KINDS.len();
        let second = (first + 1 + draws.below(SCENE_KINDS.len() - 1)) % SCENE_KINDS.len();
        let mut take = |scene: usize| RecordingSetup {
            scene: SCENE_KINDS[scene],
            scene_seed: draws.bits(),
            run_seed: draws.bits(),
        };
        let (train, validation) = (take(first), take(second));
        let camera_seed = draws.bits();
        let (noise_on_hz, noise_off_hz) = NOMINAL_NOISE_HZ[draws.below(NOMINAL_NOISE_HZ.len())];
        let nominal = Nominal {
            c_on: NOMINAL_THRESHOLD_LN,
            c_off: NOMINAL_THRESHOLD_LN,
            sigma_c: 0.0,
            noise_on_hz,
            noise_off_hz,
        };
        let changes = changes(&mut draws);
        let mut slots: Vec<Slot> = changes.iter().flat_map(|change| change.slots.clone()).collect();
        let conventions = match self.tier {
            Tier::Plain => Vec::new(),
            // A stream of its own, so that it does not matter how much the changes drew.
            Tier::Home => draw_conventions(&slots, &mut Sequence::new(key, Purpose::Convention, 0)),
        };
        slots.extend(conventions.iter().flat_map(Convention::slots));
        let plain = nominal_circuit(&nominal, self.noise_address());
        let mut base = plain.clone();
        conventions.iter().for_each(|convention| convention.install(&mut base));
        let with = |base: &Circuit, is_in: &dyn Fn(usize) -> bool| {
            let mut circuit = base.clone();
            for (i, change) in changes.iter().enumerate() {
                if is_in(i) {
                    change.apply(&mut circuit);
                }
            }
            circuit
        };
        let each = 0..changes.len();
        // A name must not say what is hidden.
        let name = mix(key ^ mix(strength.map_or(0, |s| s as u64 + 1)));
        self.cases.push(Case {
            id: format!("{:012x}", name >> 16),
            tier: self.tier,
            kind,
            strength,
            train,
            validation,
            camera_seed,
            nominal,
            circuit: with(&base, &|_| true),
            alone: each.clone().map(|i| with(&plain, &|k| k == i)).collect(),
            without: each.map(|i| with(&base, &|k| k != i)).collect(),
            slots,
            conventions,
            leave_out,
        });
    }

    fn noise_address(&self) -> NoiseAddress {
        match self.tier {
            Tier::Plain => NoiseAddress::Count,
            Tier::Home => NoiseAddress::Time,
        }
    }
}
