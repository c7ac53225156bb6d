//! The first half of a step: which pixels may have an event.

use std::ops::Range;

use evpose_core::StageNoise;

use super::PixelArray;
use super::array::PATTERN_TICK;
use super::band::{Band, Scanned};
use super::find::Find;
use super::resolve::Voltages;
use crate::Compares;
use crate::chain::Chain;
use crate::tick::Tick;
use evpose_cpu::{dispatch, vectorize};

/// Light of white in the code values of detectors that see light.
const WHITE_CODE: f32 = 255.0;

impl PixelArray {
    /// Starts the scan of a step, which goes through all blocks of a band in order.
    pub(crate) fn begin_scan(&mut self, chain: &Chain, tick: &Tick) {
        if tick.index == 0 {
            self.anchor_s = tick.start_s;
        } else if chain.plan.is_single {
            self.anchor_s = tick.end_s;
        }
        self.scanned.iter_mut().for_each(Scanned::clear);
        self.begin_varying();
    }
}

impl Band<'_> {
    /// Looks at a block of pixels: its light, and its voltage, to which leaks are added. `before` is
    /// the voltage of the band at the step before, which pixels that wake need next.
    pub(crate) fn scan(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        pixels: &Range<usize>,
        light: &[f32],
        before: Voltages<'_>,
        voltage: &mut [f32],
    ) {
        let sees_light = chain.detector.traits.compares == Compares::Light;
        if sees_light {
            for (v, i) in voltage.iter_mut().zip(light) {
                *v = WHITE_CODE * i;
            }
        }
        // Memories start at the first voltage, or at that of darkness, with a burst of events.
        if tick.index == 0 {
            self.settle(chain, tick, pixels.start, voltage);
        }
        // Leaks come before the comparison, and behind the first memory, which has no leak yet.
        if !self.leaked.is_empty() {
            self.add_uneven_leak(chain, tick, pixels, light, voltage);
        }
        if chain.plan.is_single {
            self.drain(chain, tick, pixels);
        }
        // Behind all that moves memories: the levels of this step follow from them.
        self.vary_block(chain, tick, pixels, light);
        // A detector of light decides itself which pixels have events: all are asked.
        if sees_light {
            self.scanned.awake.extend(pixels.start as u32..pixels.end as u32);
        } else {
            self.find_awake(tick, pixels, before, voltage);
        }
        self.accept(chain, tick, pixels, light);
    }

    /// Memories at the first exposure, from the voltages of some pixels.
    fn settle(&mut self, chain: &Chain, tick: &Tick, first: usize, voltage: &[f32]) {
        let cold = chain.detector.traits.starts_cold.then(|| chain.dark_v());
        let sees_light = chain.detector.traits.compares == Compares::Light;
        for (offset, &v) in voltage.iter().enumerate() {
            let pixel = first + offset;
            let phase: f32 = if sees_light { 0.0 } else { self.first_phase(chain, pixel) };
            // Detectors that compare light keep a residual, which starts in the middle.
            let start = if sees_light { 0.0 } else { cold.unwrap_or(v) };
            self.cells[pixel].memory = start - phase * self.traits[pixel].threshold_on;
            self.set_wake_levels(pixel, tick.start_s, chain.plan.steps_while_refractory);
        }
    }

    fn first_phase(&self, chain: &Chain, pixel: usize) -> f32 {
        let terms = chain.terms.iter().zip(self.terms);
        let phases = terms.map(|(link, memory)| {
            let noise = StageNoise::at_tick(memory.noise_key, PATTERN_TICK);
            link.stage.first_phase(pixel, noise)
        });
        phases.sum::<f32>().fract()
    }

    fn add_uneven_leak(
        &mut self,
        chain: &Chain,
        tick: &Tick,
        pixels: &Range<usize>,
        light: &[f32],
        voltage: &mut [f32],
    ) {
        let leaked_in_step = self.leaked_in_step.of_mut(pixels);
        let dt_s = tick.dt_s() as f32;
        match self.photo_leak_per_s.get(pixels.clone()) {
            Some(rates) => vectorize(
                #[inline(always)]
                || {
                    for ((leaked_in_step, rate), i) in
                        leaked_in_step.iter_mut().zip(rates).zip(light)
                    {
                        *leaked_in_step = rate * i * dt_s;
                    }
                },
            ),
            None => leaked_in_step.fill(0.0),
        }
        // On top of the photo leak, in the order of the terms.
        let steady = self.leak_per_s.of(pixels).unwrap_or_default();
        for (link, memory) in chain.terms.iter().zip(self.terms) {
            if link.traits.adds_leak {
                let noise = StageNoise::at_tick(memory.noise_key, tick.index);
                link.stage.add_leak(tick, pixels, steady, leaked_in_step, noise);
            }
        }
        // Rounded as published, leaks are subtracted from memories instead.
        if chain.plan.is_single {
            return;
        }
        let leaked = self.leaked.of_mut(pixels);
        vectorize(
            #[inline(always)]
            || {
                for ((v, leaked), leaked_in_step) in
                    voltage.iter_mut().zip(leaked).zip(leaked_in_step)
                {
                    *leaked += *leaked_in_step;
                    *v += *leaked;
                }
            },
        );
    }

    /// Takes what leaks in this step off the memories, rounded as published.
    fn drain(&mut self, chain: &Chain, tick: &Tick, pixels: &Range<usize>) {
        if self.leak_per_s.is_empty() && self.leaked_in_step.is_empty() {
            return;
        }
        let dt_s = tick.dt_s() as f32;
        for pixel in pixels.clone() {
            let traits = &self.traits[pixel];
            let steady = match self.leak_per_s.get(pixel) {
                // What holds until the next event only is known as this product.
                Some(leak) if chain.plan.renews => dt_s * leak,
                // Multiplied in the published order.
                Some(_) => dt_s * traits.leak_hz * traits.threshold_on,
                None => 0.0,
            };
            self.cells[pixel].memory -= steady + self.leaked_in_step.get(pixel).unwrap_or(&0.0);
            self.set_wake_levels(pixel, tick.start_s, chain.plan.steps_while_refractory);
        }
    }

    fn find_awake(
        &mut self,
        tick: &Tick,
        pixels: &Range<usize>,
        before: Voltages<'_>,
        voltage: &[f32],
    ) {
        dispatch(Find {
            first: pixels.start,
            voltage,
            on: self.wake_on.of(pixels).unwrap_or_default(),
            off: self.wake_off.of(pixels).unwrap_or_default(),
            leak: self.leak_per_s.of(pixels),
            age_s: (tick.end_s - self.anchor_s) as f32,
            before,
            cells: &self.cells,
            refractory_states: &self.refractory_states,
            awake: &mut self.scanned.awake,
        });
    }

    /// Keeps the noise events of a block that take place, at the light there is.
    fn accept(&mut self, chain: &Chain, tick: &Tick, pixels: &Range<usize>, light: &[f32]) {
        while let Some(noise_event) = self.noise_events.get(self.scanned.next_noise_event)
            && (noise_event.pixel as usize) < pixels.end
        {
            self.scanned.next_noise_event += 1;
            // Noise is drawn per exposure; a divided step has those of its part.
            let is_now = noise_event.t_s > tick.start_s && noise_event.t_s <= tick.end_s;
            let pixel = noise_event.pixel as usize;
            if is_now {
                let term = &chain.terms[usize::from(noise_event.term)].stage;
                if noise_event.chance <= term.acceptance(light[pixel - pixels.start]) {
                    self.cells.prefetch(pixel);
                    self.refractory_states.prefetch(pixel);
                    self.scanned.accepted.push(*noise_event);
                }
            }
        }
    }
}
