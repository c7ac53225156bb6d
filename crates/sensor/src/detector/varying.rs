//! Thresholds and refractory periods that a formula gives.
//!
//! # Model
//! Between the exposures, and between its events, the thresholds of a pixel run in a straight line from
//! the value of the formula at the beginning to that at the end. A voltage that runs in a line then
//! crosses a level that runs in a line. Detectors other than those of levels have the thresholds of
//! the end of the exposure.

use std::ops::Range;

use evpose_core::{Polarity, SensorSize, StageNoise};

use super::Change;
use super::array::{PATTERN_TICK, PixelArray};
use super::band::{Band, Span};
use super::pixel::{Cell, PixelStep};
use super::resolve::{PixelState, Step};
use super::term::Recovery;
use super::threshold_mismatch::MIN_THRESHOLD;
use crate::chain::Chain;
use crate::formula::events::{age_ms, last_of_neighbours, sign};
use crate::formula::pixels::{PixelFormula, PixelQuantity, bounded};
use crate::formula::variable::{MAX_AGE_MS, Patterns, Point, VARIABLES, Variable};
use crate::formula::{Input, Inputs};
use crate::tick::Tick;

/// State of a pixel that formulas depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct VaryingCell {
    /// Time of the last event, seconds.
    last_s: f64,
    last_polarity: f32,
    light: f32,
    /// Per millisecond.
    light_change: f32,
    /// Thresholds without the formula, ON and OFF.
    base: [f32; 2],
    line: ThresholdLine,
}

/// Thresholds that run in a line to the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ThresholdLine {
    from_s: f64,
    /// ON and OFF.
    from: [f32; 2],
    to: [f32; 2],
}

/// State of all pixels, and the patterns of the formula.
#[derive(Debug, Default)]
pub(super) struct Varying {
    cells: Vec<VaryingCell>,
    /// Last events of the neighbours at the beginning of a step; empty if the formula needs none.
    neighbours_s: Vec<f64>,
    patterns: Patterns,
}

/// The same of a band.
#[derive(Debug)]
pub(super) struct VaryingBand<'a> {
    pub(super) cells: Span<'a, VaryingCell>,
    pub(super) neighbours_s: &'a [f64],
    pub(super) patterns: &'a Patterns,
}

impl Varying {
    /// State of pixels without an event so far, or that of before with other thresholds.
    pub(super) fn of(
        self,
        formula: &PixelFormula,
        size: SensorSize,
        noise_key: u64,
        cells: &[Cell],
    ) -> Self {
        let noise = StageNoise::at_tick(noise_key, PATTERN_TICK);
        let uses = |variable| formula.program.uses(variable);
        let patterns = Patterns::new(uses, size, noise);
        let fresh = |base| VaryingCell {
            last_s: f64::NEG_INFINITY,
            last_polarity: 0.0,
            light: f32::NAN,
            light_change: 0.0,
            base,
            line: ThresholdLine::even(base),
        };
        let with_base = |(pixel, cell): (usize, &Cell)| {
            let base = [cell.threshold_on, cell.threshold_off];
            let line = ThresholdLine::even(base);
            let known = self.cells.get(pixel).map(|known| VaryingCell { base, line, ..*known });
            known.unwrap_or_else(|| fresh(base))
        };
        let cells: Vec<VaryingCell> = cells.iter().enumerate().map(with_base).collect();
        let neighbours = if uses(Variable::NeighbourAge) { cells.len() } else { 0 };
        Self { neighbours_s: vec![f64::NEG_INFINITY; neighbours], cells, patterns }
    }

    /// All values of the state, to be divided in bands.
    pub(super) fn parts(&mut self) -> (&mut [VaryingCell], &[f64], &Patterns) {
        (&mut self.cells, &self.neighbours_s, &self.patterns)
    }
}

impl PixelArray {
    /// Notes the last events of neighbours, which a step does not change any more.
    pub(super) fn begin_varying(&mut self) {
        let Varying { cells, neighbours_s, .. } = &mut self.varying;
        for (pixel, last_s) in neighbours_s.iter_mut().enumerate() {
            *last_s = last_of_neighbours(self.size, pixel, |other| cells[other].last_s);
        }
    }
}

impl Band<'_> {
    /// Sets the thresholds of a block for this step, with the levels at which its pixels wake.
    pub(super) fn vary_block(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        pixels: &Range<usize>,
        light: &[f32],
    ) {
        let Some(formula) = chain.varying() else { return };
        let per_ms = if tick.dt_s() > 0.0 { (1e-3 / tick.dt_s()) as f32 } else { 0.0 };
        for (pixel, &now) in pixels.clone().zip(light) {
            let cell = &mut self.varying.cells[pixel];
            let change = (now - cell.light) * per_ms;
            cell.light_change = if change.is_finite() { change } else { 0.0 };
            cell.light = now;
        }
        if formula.quantity == PixelQuantity::Refractory {
            return;
        }
        let factors = [1.0, -1.0].map(|sign| self.factors(formula, tick, pixels, light, sign));
        for (offset, pixel) in pixels.clone().enumerate() {
            let varying = &mut self.varying.cells[pixel];
            let to = [0, 1].map(|k| threshold(varying.base[k], factors[k][offset]));
            let from = if tick.index == 0 { to } else { varying.line.to };
            varying.line = ThresholdLine { from_s: tick.start_s, from, to };
            let cell = &mut self.cells[pixel];
            [cell.threshold_on, cell.threshold_off] = to;
            self.set_wake_levels(pixel, tick.start_s, chain.plan.steps_while_refractory);
        }
    }

    /// Values of the formula for the thresholds of one sign at the end of a step.
    fn factors(
        &self,
        formula: &PixelFormula,
        tick: &Tick,
        pixels: &Range<usize>,
        light: &[f32],
        sign: f32,
    ) -> Vec<f32> {
        let uses = |variable| formula.program.uses(variable);
        let each = |of: &dyn Fn(usize) -> f32, variable| -> Vec<f32> {
            if uses(variable) { pixels.clone().map(of).collect() } else { Vec::new() }
        };
        let cells = &self.varying.cells;
        let change = each(&|pixel| cells[pixel].light_change, Variable::LightChange);
        let age = each(&|pixel| age_ms(tick.end_s, cells[pixel].last_s), Variable::Age);
        let last = each(&|pixel| cells[pixel].last_polarity, Variable::LastPolarity);
        let of_neighbours = each(
            &|pixel| age_ms(tick.end_s, self.varying.neighbours_s[pixel]),
            Variable::NeighbourAge,
        );
        let mut inputs: Inputs<'_> = [Input::Even(0.0); VARIABLES];
        for (variable, plane) in self.varying.patterns.used() {
            inputs[variable as usize] = Input::Each(&plane[pixels.clone()]);
        }
        inputs[Variable::Light as usize] = Input::Each(light);
        inputs[Variable::LightChange as usize] = Input::Each(&change);
        inputs[Variable::Age as usize] = Input::Each(&age);
        inputs[Variable::NeighbourAge as usize] = Input::Each(&of_neighbours);
        inputs[Variable::LastPolarity as usize] = Input::Each(&last);
        inputs[Variable::Time as usize] = Input::Even(tick.end_s as f32);
        inputs[Variable::Polarity as usize] = Input::Even(sign);
        let mut factors = vec![0.0; pixels.len()];
        formula.program.rows(&inputs, &mut factors);
        factors
    }

    /// Line of the thresholds of a pixel from its last event, or from the beginning of the step.
    #[inline(always)]
    pub(super) fn line_of(&self, pixel: usize) -> ThresholdLine {
        self.varying.cells.get(pixel).map_or(ThresholdLine::NONE, |cell| cell.line)
    }

    /// Notes an event of a pixel, and gives it the thresholds and the refractory period behind it.
    pub(super) fn vary_behind(
        &mut self,
        formula: &PixelFormula,
        step: Step<'_>,
        pixel_state: &mut PixelState,
        t_s: f64,
        polarity: Polarity,
    ) {
        let pixel = pixel_state.pixel_step.pixel as usize;
        let neighbour_s = self.varying.neighbours_s.get(pixel).copied();
        let mut point = [0.0; VARIABLES];
        self.varying.patterns.set(pixel, &mut point);
        let cell = &mut self.varying.cells[pixel];
        let mut set = |variable: Variable, value: f32| point[variable as usize] = value;
        set(Variable::Light, cell.light);
        set(Variable::LightChange, cell.light_change);
        set(Variable::LastPolarity, cell.last_polarity);
        set(Variable::Age, age_ms(t_s, cell.last_s));
        set(Variable::NeighbourAge, neighbour_s.map_or(MAX_AGE_MS, |last_s| age_ms(t_s, last_s)));
        set(Variable::Time, t_s as f32);
        set(Variable::Polarity, sign(polarity));
        cell.last_s = t_s;
        cell.last_polarity = sign(polarity);
        if formula.quantity == PixelQuantity::Refractory {
            let period_s = 1e-6 * f64::from(formula.program.value(&point));
            let period_s = if period_s.is_finite() { period_s.max(0.0) } else { 0.0 };
            let recovery = step.chain.plan.recovery;
            let own = Recovery { refractory_s: period_s, follows_s: period_s, ..recovery };
            pixel_state.recover(
                t_s,
                step.tick.end_s,
                &own.and(Recovery { short_fraction: 0.0, ..recovery }),
            );
            return;
        }
        let end_s = step.tick.end_s;
        let at = |now_s: f64, point: &mut Point| {
            point[Variable::Age as usize] = age_ms(now_s, t_s);
            point[Variable::Time as usize] = now_s as f32;
            point[Variable::LastPolarity as usize] = sign(polarity);
            [0, 1].map(|k| {
                point[Variable::Polarity as usize] = [1.0, -1.0][k];
                threshold(cell.base[k], formula.program.value(point))
            })
        };
        let (from, to) = (at(t_s, &mut point), at(end_s, &mut point));
        cell.line = ThresholdLine { from_s: t_s, from, to };
        pixel_state.line = cell.line;
        [pixel_state.pixel_step.threshold_on, pixel_state.pixel_step.threshold_off] =
            to.map(f64::from);
        let array_cell = &mut self.cells[pixel];
        [array_cell.threshold_on, array_cell.threshold_off] = to;
    }

    /// Takes over thresholds that hold until the next event, before the formula acts on them.
    pub(super) fn vary_base(&mut self, pixel: usize) {
        let Cell { threshold_on, threshold_off, .. } = self.cells[pixel];
        if let Some(cell) = self.varying.cells.get_mut(pixel) {
            cell.base = [threshold_on, threshold_off];
            cell.line = ThresholdLine::even(cell.base);
        }
    }
}

/// A threshold as the formula changes it.
fn threshold(base: f32, factor: f32) -> f32 {
    (base * bounded(factor)).max(MIN_THRESHOLD)
}

impl ThresholdLine {
    /// Of a chain in which no formula acts on pixels.
    pub(super) const NONE: Self = Self::even([0.0; 2]);

    /// Thresholds that do not change, ON and OFF.
    const fn even(thresholds: [f32; 2]) -> Self {
        Self { from_s: 0.0, from: thresholds, to: thresholds }
    }

    /// Thresholds at a time, of a step that ends at `end_s`.
    fn at(&self, t_s: f64, end_s: f64) -> [f64; 2] {
        let way = (t_s - self.from_s) / (end_s - self.from_s);
        let way = if way.is_finite() { way.clamp(0.0, 1.0) } else { 1.0 };
        [0, 1].map(|k| f64::from(self.from[k]) * (1.0 - way) + f64::from(self.to[k]) * way)
    }
}

/// The next level that a pixel reaches, not before `from_s`, with the thresholds of that time.
pub(super) fn next_varying(
    pixel: &PixelStep,
    line: &ThresholdLine,
    from_s: f64,
) -> Option<(Change, [f64; 2])> {
    let end_s = pixel.end_s;
    let (now, to) = (pixel.at(from_s), pixel.to);
    let (first, last) = (line.at(from_s, end_s), line.at(end_s, end_s));
    // How far beyond a level, at the beginning and at the end: on a line in between.
    let beyond = |x: f64, [on, off]: [f64; 2]| [x - pixel.memory - on, pixel.memory - off - x];
    let (before, after) = (beyond(now, first), beyond(to, last));
    let way = |k: usize| match (before[k], after[k]) {
        // A level already behind is answered at once.
        (b, _) if b >= 0.0 => Some(0.0),
        (b, a) if a >= 0.0 => Some(b / (b - a)),
        _ => None,
    };
    let (k, way) = match (way(0), way(1)) {
        (Some(on), Some(off)) if off < on => (1, off),
        (Some(on), _) => (0, on),
        (None, off) => (1, off?),
    };
    let t_s = (from_s + (end_s - from_s) * way).min(end_s);
    let thresholds = line.at(t_s, end_s);
    let (polarity, memory) = if k == 0 {
        (Polarity::On, pixel.memory + thresholds[0])
    } else {
        (Polarity::Off, pixel.memory - thresholds[1])
    };
    Some((Change { t_s, polarity, count: 1, memory }, thresholds))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: [f32; 2], to: [f32; 2]) -> ThresholdLine {
        ThresholdLine { from_s: 0.0, from, to }
    }

    #[test]
    fn a_level_that_runs_is_met_where_both_lines_cross() {
        // The voltage rises by 1 in a second, the threshold falls from 0.8 to 0.2.
        let step = PixelStep::of_test(0.0, [0.0, 1.0], [0.2, 0.2]);
        let (change, thresholds) = next_varying(&step, &line([0.8; 2], [0.2; 2]), 0.0).unwrap();
        assert!((change.t_s - 0.5).abs() < 1e-7 && change.polarity == Polarity::On);
        assert!((change.memory - 0.5).abs() < 1e-7 && (thresholds[1] - 0.5).abs() < 1e-7);
        // At rest above a threshold that falls: OFF does not come, ON does.
        let rest = PixelStep::of_test(0.0, [0.5, 0.5], [0.2, 0.2]);
        let (change, _) = next_varying(&rest, &line([0.8, 0.1], [0.2, 0.1]), 0.25).unwrap();
        assert!((change.t_s - 0.5).abs() < 1e-7, "{change:?}");
        assert!(next_varying(&rest, &line([0.8, 0.1], [0.6, 0.1]), 0.0).is_none());
    }

    #[test]
    fn constant_thresholds_are_those_of_the_ideal_detector() {
        for (memory, from, to) in
            [(0.0, 0.1, 0.9), (0.0, 0.1, -0.9), (0.1, 0.5, 0.5), (0.0, 0.1, 0.2)]
        {
            let step = PixelStep::of_test(memory, [from, to], [0.25, 0.5]);
            let ideal = super::super::level_crossing::next_level(&step, 0.0);
            let varying = next_varying(&step, &line([0.25, 0.5], [0.25, 0.5]), 0.0);
            let varying = varying.map(|(change, _)| change);
            let time = |change: &Option<Change>| change.map(|change| (change.t_s * 1e9).round());
            assert_eq!(time(&varying), time(&ideal), "{memory} {from} {to}");
        }
    }
}
