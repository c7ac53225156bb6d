//! Pixels that a step has to visit, in sensors whose pixels depend on light alone.
//!
//! # Model
//! Without memory, noise and leaks in front of the detector, a pixel that sees the same light has
//! the same voltage, and one that had no event at this voltage has none again,
//! whatever its thresholds are. In front of a still background most pixels are passed over, and the
//! events are the same.

use std::ops::Range;

use evpose_cpu::vectorize;

/// Pixels that are passed over together.
pub(crate) const STRIP: usize = 64;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Task {
    /// Their light is not that of the last step.
    Recompute,
    /// Their voltage is that of the last step, and some may have further events.
    Scan,
}

#[derive(Debug, Clone, Copy)]
struct Strip {
    /// Whether its voltage at the step before is not that of two steps before.
    is_new: bool,
    /// Whether a pixel of it had, or may have had, an event when it was last scanned.
    is_awake: bool,
    /// Whether its light has to be taken anew whatever it is.
    is_unknown: bool,
}

/// The light of the last step.
#[derive(Debug)]
pub(crate) struct Changes {
    light: Vec<f32>,
    strips: Vec<Strip>,
}

/// The same of consecutive pixels, whose indices are those in the whole sensor.
#[derive(Debug)]
pub(crate) struct BandChanges<'a> {
    first: usize,
    light: &'a mut [f32],
    strips: &'a mut [Strip],
}

impl Changes {
    pub(crate) fn new(pixels: usize) -> Self {
        let unknown = Strip { is_new: true, is_awake: true, is_unknown: true };
        Self { light: vec![0.0; pixels], strips: vec![unknown; pixels.div_ceil(STRIP)] }
    }

    /// Bands of pixels that follow each other from the first pixel to the last, each of whole strips
    /// but the last.
    pub(crate) fn bands(&mut self, ranges: &[Range<usize>]) -> Vec<BandChanges<'_>> {
        let (mut light, mut strips) = (&mut *self.light, &mut *self.strips);
        let bands = ranges.iter().map(|pixels| BandChanges {
            first: pixels.start,
            light: take_front(&mut light, pixels.len()),
            strips: take_front(&mut strips, pixels.len().div_ceil(STRIP)),
        });
        bands.collect()
    }

    /// Takes nothing for granted in the next step.
    pub(crate) fn mark_all_unknown(&mut self) {
        self.strips.iter_mut().for_each(|strip| strip.is_unknown = true);
    }
}

impl BandChanges<'_> {
    /// Takes nothing for granted in the next step.
    pub(crate) fn mark_all_unknown(&mut self) {
        self.strips.iter_mut().for_each(|strip| strip.is_unknown = true);
    }

    /// The same for some pixels.
    pub(crate) fn mark_unknown(&mut self, pixels: &Range<usize>) {
        let (start, end) = (pixels.start - self.first, pixels.end - self.first);
        let strips = start / STRIP..end.div_ceil(STRIP);
        self.strips[strips].iter_mut().for_each(|strip| strip.is_unknown = true);
    }

    /// these pixels, in order, may have events in the next step.
    pub(crate) fn wake(&mut self, pixels: &[u32]) {
        for &pixel in pixels {
            self.strips[(pixel as usize - self.first) / STRIP].is_awake = true;
        }
    }

    /// Compares the `luminance` of these pixels with that of the last step. The voltages of what is
    /// passed over, or only scanned, are carried over from the step `before`. Lists the work in
    /// order, each piece no longer than `longest` pixels, or than a strip.
    pub(crate) fn find(
        &mut self,
        luminance: &[f32],
        before: &[f32],
        voltage: &mut [f32],
        longest: usize,
        tasks: &mut Vec<(Range<usize>, Task)>,
    ) {
        tasks.clear();
        let first = self.first;
        vectorize(
            #[inline(always)]
            || {
                for (number, strip) in self.strips.iter_mut().enumerate() {
                    let start = number * STRIP;
                    let pixels = start..(start + STRIP).min(luminance.len());
                    let shown = &luminance[pixels.clone()];
                    let known = &mut self.light[pixels.clone()];
                    let task = if strip.is_unknown || differ(shown, known) {
                        known.copy_from_slice(shown);
                        *strip = Strip { is_new: true, is_awake: false, is_unknown: false };
                        Task::Recompute
                    } else {
                        // Two voltage planes take turns: after a change, both have to hold the
                        // voltage once.
                        if strip.is_new {
                            voltage[pixels.clone()].copy_from_slice(&before[pixels.clone()]);
                            strip.is_new = false;
                        }
                        if !strip.is_awake {
                            continue;
                        }
                        strip.is_awake = false;
                        Task::Scan
                    };
                    let pixels = first + pixels.start..first + pixels.end;
                    // Runs of strips are one task, up to the block that fits into the cache.
                    match tasks.last_mut() {
                        Some((run, same))
                            if *same == task
                                && run.end == pixels.start
                                && pixels.end - run.start <= longest =>
                        {
                            run.end = pixels.end;
                        }
                        _ => tasks.push((pixels, task)),
                    }
                }
            },
        );
    }
}

/// The first `len` of `rest`, which goes on behind them.
pub(crate) fn take_front<'a, T>(rest: &mut &'a mut [T], len: usize) -> &'a mut [T] {
    let (front, behind) = std::mem::take(rest).split_at_mut(len);
    *rest = behind;
    front
}

#[inline(always)]
fn differ(a: &[f32], b: &[f32]) -> bool {
    let mut bits = 0;
    for (a, b) in a.iter().zip(b) {
        bits |= a.to_bits() ^ b.to_bits();
    }
    bits != 0
}

#[cfg(test)]
mod tests {
    use evpose_core::{CounterRng, Event, Micros, Plane, SensorSize};

    use crate::{EffectConfig, PRESETS, SensorConfig, SensorModel};

    const SIZE: SensorSize = SensorSize { width: 50, height: 30 };

    /// Events and repaired pixels of a frame in which a patch moves, flickers, stands still and is
    /// broken at times.
    fn run(config: &SensorConfig, skips: bool, threads: usize) -> (Vec<Event>, u64) {
        let model = SensorModel::from_config(config).unwrap();
        let other = model.clone().with_block_pixels(100).with_threads(threads);
        let mut run = other.start(SIZE, 3);
        run.front_mut().may_skip_unchanged = skips;
        let mut rng = CounterRng::new(7, "changes", 0);
        let mut events = Vec::new();
        let mut plane = Plane::for_sensor(SIZE, 0.3);
        for step in 0..120 {
            // Every third step shows what the last one showed.
            if step % 3 != 2 {
                let (x, y) = (rng.below(40), rng.below(20));
                for row in y..y + 10 {
                    let light = rng.uniform(0.01, 1.0);
                    plane.row_mut(row)[x..x + 10].fill(light);
                }
            }
            match step {
                40 => *plane.at_mut(3, 3) = f32::NAN,
                50 => *plane.at_mut(3, 3) = -1.0,
                60 => *plane.at_mut(3, 3) = 0.5,
                70 => run.retune(&model).unwrap(),
                _ => {}
            }
            events.extend(run.expose(&plane, Micros(1_000 * step)).unwrap().iter());
        }
        (events, run.repaired_pixels())
    }

    fn skips_unchanged(config: &SensorConfig) -> bool {
        SensorModel::from_config(config).unwrap().chain().plan.skips_unchanged
    }

    #[test]
    fn passing_over_what_does_not_change_changes_nothing() {
        let mut configs: Vec<(&str, SensorConfig)> = PRESETS
            .iter()
            .map(|preset| (preset.name, SensorConfig::preset(preset.name).unwrap()))
            .filter(|(_, config)| skips_unchanged(config))
            .collect();
        let names: Vec<&str> = configs.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["ideal", "eventhands", "esim"], "the presets that may pass over pixels");
        // Stages in front of the logarithm that keep nothing either.
        let mut coded = SensorConfig::preset("ideal").unwrap();
        let stages = [
            EffectConfig::new("tone_curve").with("gamma", 0.45),
            EffectConfig::new("quantisation").with("levels", 255.0),
        ];
        coded.effects.splice(0..0, stages);
        assert!(skips_unchanged(&coded));
        configs.push(("coded", coded));
        // Pixels that differ, and some that are dead or hot.
        let mut uneven = SensorConfig::preset("ideal").unwrap();
        uneven.effects.push(EffectConfig::new("threshold_mismatch").with("sigma", 0.02));
        uneven.effects.push(EffectConfig::new("dead_pixels").with("fraction", 0.1));
        assert!(skips_unchanged(&uneven));
        configs.push(("uneven", uneven));
        for (name, config) in configs {
            let (events, repaired) = run(&config, true, 1);
            assert!(events.len() > 1_000, "{name}: {}", events.len());
            let expected = (events, repaired);
            for (skips, threads) in [(false, 1), (true, 3), (false, 3)] {
                assert!(run(&config, skips, threads) == expected, "{name}, {threads} threads");
            }
        }
    }

    #[test]
    fn what_remembers_or_is_noisy_in_front_is_never_passed_over() {
        for preset in ["v2e-noisy", "davis346", "dvs-voltmeter"] {
            assert!(!skips_unchanged(&SensorConfig::preset(preset).unwrap()), "{preset}");
        }
        let jitter = EffectConfig::new("threshold_temporal_noise").with("sigma", 0.02);
        let leak = EffectConfig::new("leak_on").with("rate_hz", 0.1);
        let refractory = EffectConfig::new("refractory").with("period_us", 500.0);
        for effect in [jitter, leak, refractory] {
            let mut config = SensorConfig::preset("ideal").unwrap();
            config.effects.push(effect);
            assert!(!skips_unchanged(&config), "{config:?}");
        }
    }
}
