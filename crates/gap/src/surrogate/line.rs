//! A line in the spectrum at which ON and OFF rates are in antiphase: a lamp that flickers.

use super::fourier::{Complex, Fourier};
use super::train::Train;

/// Step of the rates.
const STEP_US: i64 = 250;
/// Steps at most: 65 s.
const MOST_STEPS: usize = 1 << 18;
/// Frequencies looked at.
const LIMITS_HZ: (f64, f64) = (25.0, 1_900.0);
/// Neighbours on each side that a power is compared with.
const NEIGHBOURS: usize = 16;
/// Part of the largest contrast that a line needs to be the lamp's.
const AS_STRONG: f64 = 0.1;

/// The strongest line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// The largest power in antiphase over that of its neighbours.
    pub(super) contrast: f64,
    /// Of the most power in antiphase among those that stand out.
    pub(super) frequency_hz: f64,
    /// Whether all others that stand out are its harmonics: what moves periodically has many, too
    /// close to each other.
    pub(super) is_alone: bool,
}

/// The strongest line in antiphase. None with fewer than fifty events of a polarity.
pub(super) fn strongest(train: &Train) -> Option<Line> {
    let (start, end) = train.span_us();
    let steps = (((end - start) / STEP_US + 1) as usize).min(MOST_STEPS);
    let length = steps.next_power_of_two();
    let mut values = vec![Complex::default(); length];
    let (mut on, mut off) = (0.0f64, 0.0f64);
    for mark in &train.marks {
        // Both rates in one transform: ON is the real part.
        let Some(value) = values[..steps].get_mut(((mark.t_us - start) / STEP_US) as usize) else {
            break;
        };
        if mark.is_on {
            value.re += 1.0;
            on += 1.0;
        } else {
            value.im += 1.0;
            off += 1.0;
        }
    }
    if on.min(off) < 50.0 {
        return None;
    }
    let (mean_on, mean_off) = ((on / steps as f64) as f32, (off / steps as f64) as f32);
    for value in &mut values[..steps] {
        value.re -= mean_on;
        value.im -= mean_off;
    }
    Fourier::new(length).transform(&mut values);
    let antiphase = |f: usize| {
        let (z, mirror) = (values[f], values[length - f]);
        let (a_re, a_im) = (z.re + mirror.re, z.im - mirror.im);
        let (b_re, b_im) = (z.im + mirror.im, mirror.re - z.re);
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
        // A contrast is at most the power.
        if *power > best {
            best = contrast(i).max(best);
        }
    }
    // Harmonics may stand out as much, but hold less power.
    let is_strong = |i: &usize| powers[*i] >= AS_STRONG * best && contrast(*i) >= AS_STRONG * best;
    let strong: Vec<usize> = (0..powers.len()).filter(is_strong).collect();
    let strongest = *strong.iter().max_by(|a, b| powers[**a].total_cmp(&powers[**b]))?;
    let frequency = (first + strongest) as f64;
    // A line is a few steps wide, by the length of the recording, and its harmonics are as well.
    let width = 3.0 * length as f64 / steps as f64;
    let is_harmonic = |i: &usize| {
        let f = (first + i) as f64;
        let turns = (f / frequency).round();
        (f - turns * frequency).abs() <= width * turns.max(1.0)
    };
    let is_alone = strong.iter().all(is_harmonic);
    Some(Line { contrast: best, frequency_hz: frequency * step_hz, is_alone })
}

/// Where a frequency shows in rates over whole steps.
pub(super) fn shown_hz(frequency_hz: f64) -> f64 {
    let steps_hz = 1e6 / STEP_US as f64;
    (frequency_hz - (frequency_hz / steps_hz).round() * steps_hz).abs()
}
