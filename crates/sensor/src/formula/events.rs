//! Formulas of events that are read out: which are lost, come again, are added, or come late.

use evpose_core::{Polarity, SensorSize, StageNoise};

use super::variable::{MAX_AGE_MS, Patterns, Point, VARIABLES, Variable};
use super::{Input, Inputs, Program};
use crate::tick::Tick;
use crate::{Origin, Request, request};

/// Change of the events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EventStage {
    Loss,
    Echo,
    Rate,
    Delay,
}

/// Gives a probability, a rate in hertz, or a delay in microseconds.
#[derive(Debug)]
pub struct EventFormula {
    program: Program,
    stage: EventStage,
    after_s: f64,
    place: &'static str,
}

/// The last events of all pixels, and the light of the exposure before.
#[derive(Debug)]
pub(crate) struct EventMemory {
    size: SensorSize,
    patterns: Patterns,
    /// Time of the last event of each pixel, seconds; minus infinity before the first.
    last_s: Vec<f64>,
    last_polarity: Vec<f32>,
    light: Vec<f32>,
    change: Vec<f32>,
}

/// Neighbours of a pixel, as columns and rows from it.
const NEIGHBOURS: [(i32, i32); 8] =
    [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];

/// The next pixels, in the order of the words of `place` behind the first.
const NEXT: [(i32, i32); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// The pixel some columns and rows away, if there is one.
pub(crate) fn at(size: SensorSize, pixel: usize, (columns, rows): (i32, i32)) -> Option<usize> {
    let (width, height) = (i32::from(size.width), i32::from(size.height));
    let (x, y) = (pixel as i32 % width + columns, pixel as i32 / width + rows);
    let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
    is_inside.then(|| (y * width + x) as usize)
}

/// Time of the last event of the neighbours of a pixel.
pub(crate) fn last_of_neighbours(
    size: SensorSize,
    pixel: usize,
    last_s: impl Fn(usize) -> f64,
) -> f64 {
    let neighbours = NEIGHBOURS.iter().filter_map(|step| at(size, pixel, *step));
    neighbours.map(last_s).fold(f64::NEG_INFINITY, f64::max)
}

/// Age of an event of `last_s`, ms.
pub(crate) fn age_ms(now_s: f64, last_s: f64) -> f32 {
    (1e3 * (now_s - last_s)).clamp(0.0, f64::from(MAX_AGE_MS)) as f32
}

pub(crate) fn sign(polarity: Polarity) -> f32 {
    if polarity.is_on() { 1.0 } else { -1.0 }
}

impl EventFormula {
    pub(crate) fn new(
        program: Program,
        stage: EventStage,
        after_s: f64,
        place: &'static str,
    ) -> Self {
        Self { program, stage, after_s, place }
    }

    /// `noise` is that of patterns.
    pub(crate) fn memory(&self, size: SensorSize, noise: StageNoise) -> EventMemory {
        EventMemory {
            size,
            patterns: Patterns::new(|variable| self.program.uses(variable), size, noise),
            last_s: vec![f64::NEG_INFINITY; size.pixels()],
            last_polarity: vec![0.0; size.pixels()],
            light: Vec::new(),
            change: vec![0.0; size.pixels()],
        }
    }

    /// Changes the events of an exposure, at the end of which pixels see `light`.
    pub(crate) fn step(
        &self,
        tick: &Tick,
        light: &[f32],
        events: &mut Vec<Request>,
        memory: &mut EventMemory,
        noise: StageNoise,
    ) {
        memory.observe(tick, light);
        request::sort(events);
        let mut further = Vec::new();
        events.retain_mut(|event| {
            let pixel = event.pixel as usize;
            let value = f64::from(self.program.value(&memory.point(event, &self.program)));
            memory.last_s[pixel] = event.t_s;
            memory.last_polarity[pixel] = sign(event.polarity);
            // By pixel and time: a draw is the same whatever other events there are.
            let draw = (event.t_s.to_bits() ^ (event.t_s.to_bits() >> 32)) as u32;
            let is_drawn = || f64::from(noise.uniform(pixel, draw)) <= value;
            match self.stage {
                EventStage::Loss => return !is_drawn(),
                EventStage::Echo if is_drawn() => {
                    let place = self.place_of_echo(memory.size, pixel, noise, draw);
                    let t_s = event.t_s + self.after_s;
                    further.extend(place.map(|pixel| Request {
                        t_s,
                        pixel: pixel as u32,
                        ..*event
                    }));
                }
                EventStage::Delay if value.is_finite() => event.t_s += 1e-6 * value.max(0.0),
                EventStage::Echo | EventStage::Delay | EventStage::Rate => {}
            }
            true
        });
        if self.stage == EventStage::Rate {
            self.add(tick, memory, noise, &mut further);
        }
        events.append(&mut further);
    }

    fn place_of_echo(
        &self,
        size: SensorSize,
        pixel: usize,
        noise: StageNoise,
        draw: u32,
    ) -> Option<usize> {
        let next = match self.place {
            "right" => NEXT[0],
            "left" => NEXT[1],
            "below" => NEXT[2],
            "above" => NEXT[3],
            // Other bits than those that decide whether there is an echo.
            "any" => NEXT[(noise.bits(pixel, draw) & 3) as usize],
            _ => (0, 0),
        };
        at(size, pixel, next)
    }

    /// Further events of this exposure: one of a pixel and polarity at most, with the probability that
    /// a Poisson process of the rate has any.
    fn add(
        &self,
        tick: &Tick,
        memory: &EventMemory,
        noise: StageNoise,
        further: &mut Vec<Request>,
    ) {
        let (dt_s, pixels) = (tick.dt_s(), memory.size.pixels());
        if dt_s <= 0.0 {
            return;
        }
        let (mut age, mut of_neighbours) = (Vec::new(), Vec::new());
        if self.program.uses(Variable::Age) {
            age.extend(memory.last_s.iter().map(|last_s| age_ms(tick.end_s, *last_s)));
        }
        if self.program.uses(Variable::NeighbourAge) {
            let last = |pixel| last_of_neighbours(memory.size, pixel, |other| memory.last_s[other]);
            of_neighbours.extend((0..pixels).map(|pixel| age_ms(tick.end_s, last(pixel))));
        }
        let mut inputs: Inputs<'_> = [Input::Even(0.0); VARIABLES];
        inputs[Variable::Light as usize] = Input::Each(&memory.light);
        inputs[Variable::LightChange as usize] = Input::Each(&memory.change);
        inputs[Variable::Age as usize] = Input::Each(&age);
        inputs[Variable::NeighbourAge as usize] = Input::Each(&of_neighbours);
        inputs[Variable::LastPolarity as usize] = Input::Each(&memory.last_polarity);
        inputs[Variable::Time as usize] = Input::Even(tick.end_s as f32);
        for (variable, plane) in memory.patterns.used() {
            inputs[variable as usize] = Input::Each(plane);
        }
        let mut rates = vec![0.0; pixels];
        for polarity in [Polarity::On, Polarity::Off] {
            inputs[Variable::Polarity as usize] = Input::Even(sign(polarity));
            self.program.rows(&inputs, &mut rates);
            let first = if polarity.is_on() { 0 } else { 2 };
            for (pixel, rate_hz) in rates.iter().enumerate().filter(|(_, rate)| **rate > 0.0) {
                let probability = -(-f64::from(*rate_hz) * dt_s).exp_m1();
                if f64::from(noise.uniform(pixel, first)) <= probability {
                    let t_s =
                        tick.end_s - dt_s * (1.0 - f64::from(noise.uniform(pixel, first + 1)));
                    let (pixel, origin) = (pixel as u32, Origin::Shot);
                    further.push(Request { t_s, pixel, polarity, origin });
                }
            }
        }
    }
}

impl EventMemory {
    fn observe(&mut self, tick: &Tick, light: &[f32]) {
        // What cannot be light is darkness, as in front.
        let repaired = light.iter().map(|y| if y.is_finite() { y.max(0.0) } else { 0.0 });
        if self.light.is_empty() || tick.dt_s() <= 0.0 {
            self.light = repaired.collect();
            return;
        }
        let per_ms = (1e-3 / tick.dt_s()) as f32;
        for ((now, change), y) in self.light.iter_mut().zip(&mut self.change).zip(repaired) {
            (*change, *now) = ((y - *now) * per_ms, y);
        }
    }

    fn point(&self, event: &Request, program: &Program) -> Point {
        let pixel = event.pixel as usize;
        let mut point = [0.0; VARIABLES];
        let mut set = |variable: Variable, value: f32| point[variable as usize] = value;
        set(Variable::Light, self.light[pixel]);
        set(Variable::LightChange, self.change[pixel]);
        set(Variable::Age, age_ms(event.t_s, self.last_s[pixel]));
        set(Variable::Polarity, sign(event.polarity));
        set(Variable::LastPolarity, self.last_polarity[pixel]);
        set(Variable::Time, event.t_s as f32);
        if program.uses(Variable::NeighbourAge) {
            let last_s = last_of_neighbours(self.size, pixel, |other| self.last_s[other]);
            set(Variable::NeighbourAge, age_ms(event.t_s, last_s));
        }
        self.patterns.set(pixel, &mut point);
        point
    }
}
