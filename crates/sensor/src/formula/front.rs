//! Formulas of the photocurrent and of the log voltage.

use evpose_core::{SensorSize, StageNoise};

use super::variable::{VARIABLES, Variable};
use super::{Input, Inputs, Program};
use crate::Domain;
use crate::stage::{Block, PlaneStage};
use crate::tick::Tick;

/// Gives the photocurrent, or what is added to the voltage.
#[derive(Debug)]
pub struct FrontFormula {
    program: Program,
    domain: Domain,
}

/// Light of the exposure before, and a plane for each pattern.
const PLANES: usize = 1 + Variable::PATTERNS.len();

impl FrontFormula {
    pub(crate) fn new(program: Program, domain: Domain) -> Self {
        Self { program, domain }
    }

    pub(crate) fn domain(&self) -> Domain {
        self.domain
    }
}

impl PlaneStage for FrontFormula {
    fn state_planes(&self) -> usize {
        PLANES
    }

    fn init(&self, size: SensorSize, plane: &mut Block<'_>, noise: StageNoise) {
        let light = if plane.photocurrent.is_empty() { &*plane.signal } else { plane.photocurrent };
        let [before, patterns @ ..] = plane.state.planes::<PLANES>();
        before.copy_from_slice(light);
        for (variable, values) in Variable::PATTERNS.into_iter().zip(patterns) {
            if self.program.uses(variable) {
                variable.fill(size, noise, values);
            }
        }
    }

    fn step(&self, tick: &Tick, _size: SensorSize, plane: &mut Block<'_>, _noise: StageNoise) {
        let is_voltage = !plane.photocurrent.is_empty();
        let light: Vec<f32> =
            if is_voltage { plane.photocurrent.to_vec() } else { plane.signal.to_vec() };
        let [before, patterns @ ..] = plane.state.planes::<PLANES>();
        let per_ms = if tick.dt_s() > 0.0 { (1e-3 / tick.dt_s()) as f32 } else { 0.0 };
        let change: Vec<f32> =
            light.iter().zip(&*before).map(|(now, then)| (now - then) * per_ms).collect();
        // Mirrored at the centre, the last pixel is the first.
        let ghost: Vec<f32> = light.iter().rev().copied().collect();
        let mut inputs: Inputs<'_> = [Input::Even(0.0); VARIABLES];
        for (variable, values) in Variable::PATTERNS.into_iter().zip(&patterns) {
            inputs[variable as usize] = Input::Each(values);
        }
        inputs[Variable::Light as usize] = Input::Each(&light);
        inputs[Variable::LightChange as usize] = Input::Each(&change);
        inputs[Variable::Ghost as usize] = Input::Each(&ghost);
        inputs[Variable::Time as usize] = Input::Even(tick.end_s as f32);
        if is_voltage {
            let mut added = vec![0.0; light.len()];
            self.program.rows(&inputs, &mut added);
            // Beyond the samples a formula may not be finite after all: it then adds nothing.
            let finite = added.into_iter().map(|v| if v.is_finite() { v } else { 0.0 });
            plane.signal.iter_mut().zip(finite).for_each(|(v, added)| *v += added);
        } else {
            self.program.rows(&inputs, plane.signal);
            plane.signal.iter_mut().for_each(|light| *light = light.clamp(0.0, f32::MAX));
            // Not a number is darkness, as in the light of a scene.
            plane.signal.iter_mut().filter(|i| i.is_nan()).for_each(|light| *light = 0.0);
        }
        before.copy_from_slice(&light);
    }
}
