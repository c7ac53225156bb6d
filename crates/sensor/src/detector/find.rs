//! The comparison of voltages with the levels at which pixels wake.

use evpose_cpu::{Kernel8, LANES_8, Lanes8};

use super::band::Span;
use super::pixel::{Cell, RefractoryState};
use super::resolve::Voltages;

/// Pixels compared together: wide enough to pass over quiet ones quickly, small enough that one
/// event does not send many quiet pixels down the slow path.
const GROUP: usize = VECTORS * LANES_8;
const VECTORS: usize = 4;

/// A block of pixels, and the list that takes those whose voltage, with what leaked, lies at or
/// beyond one of their levels.
#[derive(Debug)]
pub(super) struct Find<'a> {
    /// Index of the first pixel of the block.
    pub(super) first: usize,
    pub(super) voltage: &'a [f32],
    pub(super) on: &'a [f32],
    pub(super) off: &'a [f32],
    /// Steady leak, ln per second, if there is any.
    pub(super) leak: Option<&'a [f32]>,
    /// Time since the anchor, at which nothing had leaked.
    pub(super) age_s: f32,
    /// Voltage before and state of the band, which pixels that wake need next.
    pub(super) before: Voltages<'a>,
    pub(super) cells: &'a Span<'a, Cell>,
    pub(super) refractory_states: &'a Span<'a, RefractoryState>,
    pub(super) awake: &'a mut Vec<u32>,
}

impl Kernel8 for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) {
        match self.leak {
            Some(leak) => self.sweep::<L, true>(l, leak),
            // Without a leak its place is taken by what is at hand.
            None => {
                let voltage = self.voltage;
                self.sweep::<L, false>(l, voltage);
            }
        }
    }
}

impl Find<'_> {
    #[inline(always)]
    fn sweep<L: Lanes8, const LEAKS: bool>(mut self, l: L, leak: &[f32]) {
        let age_s = l.splat(self.age_s);
        let (v, v_rest) = self.voltage.as_chunks::<GROUP>();
        let (on, on_rest) = self.on.as_chunks::<GROUP>();
        let (off, off_rest) = self.off.as_chunks::<GROUP>();
        let (leak, leak_rest) = leak.as_chunks::<GROUP>();
        for (group, (((v, on), off), leak)) in v.iter().zip(on).zip(off).zip(leak).enumerate() {
            let masks = beyond::<L, LEAKS>(l, age_s, [v, on, off, leak]);
            let [a, b, c, d] = masks;
            // One branch per 32 pixels, which is nearly always taken the same way.
            if l.to_bitmask(l.or(l.or(a, b), l.or(c, d))) != 0 {
                self.wake(l, masks, self.first + group * GROUP);
            }
        }
        if !v_rest.is_empty() {
            let rest = [v_rest, on_rest, off_rest, leak_rest].map(padded);
            let masks = beyond::<L, LEAKS>(l, age_s, rest.each_ref());
            self.wake(l, masks, self.first + v.len() * GROUP);
        }
    }

    /// Appends the pixels whose masks are set, `first` being that of the group.
    #[inline(always)]
    fn wake<L: Lanes8>(&mut self, l: L, [a, b, c, d]: [L::I; VECTORS], first: usize) {
        let low = l.to_bitmask(a) | (l.to_bitmask(b) << LANES_8);
        let high = l.to_bitmask(c) | (l.to_bitmask(d) << LANES_8);
        let mut bits = low | (high << (2 * LANES_8));
        while bits != 0 {
            let pixel = first + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            // What pixels remember lies apart; it arrives while others are compared.
            self.before.prefetch(pixel);
            self.cells.prefetch(pixel);
            self.refractory_states.prefetch(pixel);
            self.awake.push(pixel as u32);
        }
    }
}

/// Masks of the pixels at or beyond a level, of voltages, levels and leaks.
#[inline(always)]
fn beyond<L: Lanes8, const LEAKS: bool>(
    l: L,
    age_s: L::F,
    [v, on, off, leak]: [&[f32; GROUP]; 4],
) -> [L::I; VECTORS] {
    let [v, on, off, leak] = [vectors(v), vectors(on), vectors(off), vectors(leak)];
    let mut masks = [l.splat_i(0); VECTORS];
    for k in 0..VECTORS {
        let voltage = l.load(v[k]);
        let x = if LEAKS { l.add(voltage, l.mul(l.load(leak[k]), age_s)) } else { voltage };
        // "At or beyond": a voltage exactly on its level makes an event.
        masks[k] = l.or(l.le(l.load(on[k]), x), l.le(x, l.load(off[k])));
    }
    masks
}

#[inline(always)]
fn vectors(plane: &[f32; GROUP]) -> &[[f32; LANES_8]] {
    plane.as_chunks().0
}

/// A group that ends with what is not a number, and so at no level.
#[inline(always)]
fn padded(rest: &[f32]) -> [f32; GROUP] {
    let mut padded = [f32::NAN; GROUP];
    padded[..rest.len()].copy_from_slice(rest);
    padded
}

#[cfg(test)]
mod tests {
    use evpose_core::CounterRng;
    use evpose_cpu::dispatch;

    use super::*;

    #[test]
    fn pixels_at_or_beyond_a_level_are_found_whatever_the_length() {
        let mut rng = CounterRng::new(1, "find", 0);
        for length in 0..70 {
            let mut plane =
                |low, high| -> Vec<f32> { (0..length).map(|_| rng.uniform(low, high)).collect() };
            let (mut voltage, leak) = (plane(-1.2, 1.2), plane(0.0, 0.2));
            let (mut on, mut off) = (plane(0.5, 1.0), plane(-1.0, -0.5));
            for k in (0..length).step_by(5) {
                match k % 4 {
                    0 => on[k] = voltage[k],
                    1 => off[k] = voltage[k],
                    2 => (on[k], off[k]) = (f32::NEG_INFINITY, f32::INFINITY),
                    _ => voltage[k] = f32::NAN,
                }
            }
            for leak in [None, Some(leak.as_slice())] {
                let mut awake = Vec::new();
                dispatch(Find {
                    first: 1_000,
                    voltage: &voltage,
                    on: &on,
                    off: &off,
                    leak,
                    age_s: 0.7,
                    before: Voltages::default(),
                    cells: &Span { first: 0, values: &mut [] },
                    refractory_states: &Span { first: 0, values: &mut [] },
                    awake: &mut awake,
                });
                let expected = (0..length).filter(|&k| {
                    let x = leak.map_or(voltage[k], |leak| voltage[k] + leak[k] * 0.7);
                    x >= on[k] || x <= off[k]
                });
                let expected: Vec<u32> = expected.map(|k| 1_000 + k as u32).collect();
                assert_eq!(awake, expected, "{length}");
            }
        }
    }
}
