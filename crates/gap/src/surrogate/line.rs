//! Spectral line at which ON and OFF rates are in antiphase: a flickering lamp.

use super::train::Train;
use crate::fourier::Fourier;

/// Bin length of the rates.
const STEP_US: i64 = 250;
/// Maximum bins: 65 s.
const MAX_STEPS: usize = 1 << 18;
/// Frequency range. A scanned readout samples a lamp to lines above it, at any frequency.
const LIMITS_HZ: (f64, f64) = (25.0, 900.0);
/// Neighbouring frequencies on each side that a power is compared with.
const NEIGHBOURS: usize = 16;
/// Minimum contrast of a prominent line, relative to the largest.
const AS_STRONG: f64 = 0.1;

#[derive(Debug, Clone, Copy)]
pub(super) struct LampLine {
    /// Power in antiphase relative to neighbouring frequencies.
    pub(super) contrast: f64,
    /// Frequency of the most powerful prominent line.
    pub(super) frequency_hz: f64,
    /// Whether all other prominent lines are its harmonics. Periodic motion has many lines that are
    /// not.
    pub(super) is_alone: bool,
}

/// Finds the strongest line in antiphase; none with fewer than fifty events of a polarity.
pub(super) fn strongest(train: &Train) -> Option<LampLine> {
    let (start, end) = train.span_us();
    let steps = (((end - start) / STEP_US + 1) as usize).min(MAX_STEPS);
    let mut values = Fourier::zeros(steps);
    let length = values.length();
    let (mut on, mut off) = (0.0f64, 0.0f64);
    for mark in &train.marks {
        // Both rates in one transform: ON is the real part.
        let step = ((mark.t_us - start) / STEP_US) as usize;
        if step >= steps {
            break;
        }
        let (side, count) =
            if mark.is_on { (&mut values.re, &mut on) } else { (&mut values.im, &mut off) };
        side[step] += 1.0;
        *count += 1.0;
    }
    if on.min(off) < 50.0 {
        return None;
    }
    for (side, count) in [(&mut values.re, on), (&mut values.im, off)] {
        let mean = (count / steps as f64) as f32;
        side[..steps].iter_mut().for_each(|value| *value -= mean);
    }
    values.transform();
    let antiphase = |f: usize| {
        let ([re, im], [mirror_re, mirror_im]) = (values.at(f), values.at(length - f));
        let (a_re, a_im) = (re + mirror_re, im - mirror_im);
        let (b_re, b_im) = (im + mirror_im, mirror_re - re);
        -0.25 * f64::from(a_re * b_re + a_im * b_im) / (on * off).sqrt()
    };
    let step_hz = 1e6 / (length as f64 * STEP_US as f64);
    let place = |hz: f64| ((hz / step_hz) as usize).clamp(1, length / 2 - 1);
    let (first, last) = (place(LIMITS_HZ.0), place(LIMITS_HZ.1));
    let powers: Vec<f64> = (first..=last).map(antiphase).collect();
    let contrast = |i: usize| {
        let around = &powers[i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS + 1).min(powers.len())];
        let mut sizes: Vec<f64> = around.iter().map(|power| power.abs()).collect();
        let (_, median, _) = sizes.select_nth_unstable_by(around.len() / 2, f64::total_cmp);
        powers[i] / median.max(1.0)
    };
    let mut best = 0.0;
    for (i, power) in powers.iter().enumerate() {
        // The contrast is at most the power, so that weaker powers need no contrast.
        if *power > best {
            best = contrast(i).max(best);
        }
    }
    // Harmonics may have as much contrast, but less power.
    let is_strong = |i: &usize| powers[*i] >= AS_STRONG * best && contrast(*i) >= AS_STRONG * best;
    let strong: Vec<usize> = (0..powers.len()).filter(is_strong).collect();
    let strongest = *strong.iter().max_by(|a, b| powers[**a].total_cmp(&powers[**b]))?;
    let frequency = (first + strongest) as f64;
    // The length of the recording limits the resolution: a line and its harmonics have a width.
    let width = 3.0 * length as f64 / steps as f64;
    let is_harmonic = |i: &usize| {
        let f = (first + i) as f64;
        let turns = (f / frequency).round();
        (f - turns * frequency).abs() <= width * turns.max(1.0)
    };
    let is_alone = strong.iter().all(is_harmonic);
    Some(LampLine { contrast: best, frequency_hz: frequency * step_hz, is_alone })
}

/// Alias of a frequency at the sampling rate of the bins.
pub(super) fn alias_hz(frequency_hz: f64) -> f64 {
    let steps_hz = 1e6 / STEP_US as f64;
    (frequency_hz - (frequency_hz / steps_hz).round() * steps_hz).abs()
}
