//! The plan of the benchmark: every case from one seed, in an order and under names that say
//! nothing.
//!
//! 216 singles (18 effects, 4 strengths, 3 scenes), 200 nulls, 60 cases with other parameters only,
//! 60 pairs of strong effects from different stages, 22 effects that are removed from the catalogue
//! and 18 that no catalogue has.

use crate::case::{Case, CaseKind, RecordingSetup, nominal_circuit};
use crate::catalogue::Nominal;
use crate::circuit::{Circuit, NOMINAL_THRESHOLD_LN};
use crate::draw::{Purpose, Sequence, mix};
use crate::effect::{EFFECTS, Effect, STRENGTHS};
use crate::oddity::{ODDITIES, install_oddity};
use crate::scene::SCENE_KINDS;

/// Scenes of each single effect.
const SCENES_OF_SINGLES: usize = 3;
const NULLS: usize = 200;
const PARAMETERS: usize = 60;
const PAIRS: usize = 60;
const LEFT_OUT: usize = 22;
const NEVER_CATALOGUED: usize = 18;

/// Nominal background rates (ON, OFF) in Hz for each pixel; a case has one of them.
const NOMINAL_NOISE_HZ: [(f64, f64); 3] = [(0.0, 0.0), (0.02, 0.005), (0.06, 0.02)];

/// Makes the plan.
#[derive(Debug, Clone, Copy)]
pub struct Plan;

impl Plan {
    /// All cases of a seed.
    pub fn from_seed(seed: u64) -> Vec<Case> {
        let mut builder = Builder { seed, cases: Vec::new() };
        builder.singles();
        for i in 0..NULLS {
            builder.push(CaseKind::Null, i, None, None, |_| Vec::new());
        }
        for i in 0..PARAMETERS {
            builder.push(CaseKind::Parameter, i, None, None, |case| vec![parameter(case, i)]);
        }
        for i in 0..PAIRS {
            builder.push(CaseKind::Pair, i, None, None, pair);
        }
        for i in 0..LEFT_OUT {
            let effect = EFFECTS[i % EFFECTS.len()];
            // Once through all effects at the third strength, then on at the fourth.
            let strength = 2 + i / EFFECTS.len();
            builder.push(CaseKind::LeftOut, i, None, Some(effect.name()), |case| {
                vec![install(effect, strength)(case)]
            });
        }
        for i in 0..NEVER_CATALOGUED {
            builder.push(CaseKind::NeverCatalogued, i, None, None, |_| {
                let oddity = ODDITIES[i % ODDITIES.len()];
                vec![Box::new(move |circuit| install_oddity(oddity, i / ODDITIES.len(), circuit))]
            });
        }
        let mut cases = builder.cases;
        cases.sort_by(|a, b| a.id.cmp(&b.id));
        cases
    }
}

/// Modification of a circuit.
type Change = Box<dyn Fn(&mut Circuit)>;

struct Builder {
    seed: u64,
    cases: Vec<Case>,
}

impl Builder {
    fn singles(&mut self) {
        for (e, effect) in EFFECTS.into_iter().enumerate() {
            for scene in 0..SCENES_OF_SINGLES {
                // One camera and scene for the four strengths.
                let number = e * SCENES_OF_SINGLES + scene;
                for strength in 0..STRENGTHS {
                    let change = |draws: &mut Sequence| vec![install(effect, strength)(draws)];
                    self.push(CaseKind::Single, number, Some(strength), None, change);
                }
            }
        }
    }

    fn push(
        &mut self,
        kind: CaseKind,
        number: usize,
        strength: Option<usize>,
        leave_out: Option<&'static str>,
        changes: impl FnOnce(&mut Sequence) -> Vec<Change>,
    ) {
        let key = mix(self.seed ^ mix((kind as u64) << 32 | number as u64));
        let mut draws = Sequence::new(key, Purpose::Plan, 0);
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
        let plain = nominal_circuit(&nominal);
        let with = |changes: &[Change]| {
            let mut circuit = plain.clone();
            changes.iter().for_each(|change| change(&mut circuit));
            circuit
        };
        let name = mix(key ^ mix(strength.map_or(0, |s| s as u64 + 1)));
        self.cases.push(Case {
            id: format!("{:012x}", name >> 16),
            kind,
            strength,
            train,
            validation,
            camera_seed,
            nominal,
            circuit: with(&changes),
            alone: changes.iter().map(|change| with(std::slice::from_ref(change))).collect(),
            leave_out,
        });
    }
}

fn install(effect: Effect, strength: usize) -> impl Fn(&mut Sequence) -> Change {
    move |draws| {
        let key = draws.bits();
        Box::new(move |circuit| {
            effect.install(strength, circuit, &mut Sequence::new(key, Purpose::Plan, 1));
        })
    }
}

/// Two effects of different stages, each at one of its two highest strengths.
fn pair(draws: &mut Sequence) -> Vec<Change> {
    let first = EFFECTS[draws.below(EFFECTS.len())];
    let second = loop {
        let effect = EFFECTS[draws.below(EFFECTS.len())];
        if effect.stage() != first.stage() {
            break effect;
        }
    };
    [first, second]
        .map(|effect| {
            let strength = STRENGTHS - 2 + draws.below(2);
            install(effect, strength)(draws)
        })
        .into()
}

/// One parameter away from nominal: thresholds (ON, OFF or both), background, or the clock's zero.
fn parameter(draws: &mut Sequence, number: usize) -> Change {
    match number % 5 {
        side @ 0..=2 => {
            let mut factor = || {
                let amount = draws.between(0.05, 0.4);
                1.0 + draws.sign() * amount
            };
            let (on, off) = (factor(), factor());
            Box::new(move |circuit| {
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
            Box::new(move |circuit| {
                circuit.background.on_hz += on_hz;
                circuit.background.off_hz += off_hz;
            })
        }
        _ => {
            let offset_us = draws.between(1000.0, 5000.0).round();
            Box::new(move |circuit| circuit.clock.offset_us = offset_us)
        }
    }
}
