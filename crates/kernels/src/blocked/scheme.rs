//! The transforms of Winograd's fast convolution by three taps.
//!
//! # Model
//! `OUT` outputs of a row convolved with three taps `g` are `Aᵀ ((G g) ⊙ (Bᵀ d))` with the
//! `OUT + 2` inputs `d`: as many products as inputs instead of three an output. In two dimensions the
//! transforms are applied along rows and columns.
//!
//! # Source
//! Lavin, Gray: *Fast Algorithms for Convolutional Neural Networks*, CVPR 2016, Sec. 4.

use crate::simd::Lanes;

/// Inputs of the largest scheme.
pub(crate) const MOST: usize = 6;

/// `F(OUT, 3)`. Arrays are longer than needed where `IN` is less than [`MOST`]; the rest is not used.
///
/// Factors of the taps are multiplied into the inputs instead, which are transformed less often.
pub(crate) trait Scheme {
    /// Outputs.
    const OUT: usize;
    /// Inputs.
    const IN: usize = Self::OUT + 2;
    /// `G` without its factors.
    const TAPS: [[f32; 3]; MOST];
    /// The factors of the rows of `G`.
    const FACTORS: [f32; MOST];

    /// `G g` without its factors.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn taps<V: Lanes>(g: [V; 3]) -> [V; MOST];

    /// `Bᵀ d`.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn inputs<V: Lanes>(d: [V; MOST]) -> [V; MOST];

    /// `Aᵀ m`.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn outputs<V: Lanes>(m: [V; MOST]) -> [V; 4];

    /// `A y`, of the gradient by the outputs.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn spread<V: Lanes>(y: [V; 4]) -> [V; MOST];
}

/// `F(2, 3)`: four products instead of six; adds and subtracts only.
pub(crate) struct Two;

/// `F(4, 3)`: six products instead of twelve.
pub(crate) struct Four;

impl Scheme for Two {
    const OUT: usize = 2;
    const TAPS: [[f32; 3]; MOST] =
        [[1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]];
    const FACTORS: [f32; MOST] = [1.0, 0.5, 0.5, 1.0, 0.0, 0.0];

    #[inline(always)]
    unsafe fn taps<V: Lanes>([a, b, c]: [V; 3]) -> [V; MOST] {
        // SAFETY: the caller's.
        unsafe {
            let even = a.add(c);
            [a, even.add(b), even.sub(b), c, c, c]
        }
    }

    #[inline(always)]
    unsafe fn inputs<V: Lanes>(d: [V; MOST]) -> [V; MOST] {
        // SAFETY: the caller's.
        unsafe {
            let first = [d[0].sub(d[2]), d[1].add(d[2]), d[2].sub(d[1]), d[1].sub(d[3])];
            [first[0], first[1], first[2], first[3], d[4], d[5]]
        }
    }

    #[inline(always)]
    unsafe fn outputs<V: Lanes>(m: [V; MOST]) -> [V; 4] {
        // SAFETY: the caller's.
        unsafe { [m[0].add(m[1]).add(m[2]), m[1].sub(m[2]).sub(m[3]), m[2], m[3]] }
    }

    #[inline(always)]
    unsafe fn spread<V: Lanes>(y: [V; 4]) -> [V; MOST] {
        // SAFETY: the caller's.
        unsafe { [y[0], y[0].add(y[1]), y[0].sub(y[1]), V::splat(0.0).sub(y[1]), y[2], y[3]] }
    }
}

impl Scheme for Four {
    const OUT: usize = 4;
    const TAPS: [[f32; 3]; MOST] = [
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 2.0, 4.0],
        [1.0, -2.0, 4.0],
        [0.0, 0.0, 1.0],
    ];
    const FACTORS: [f32; MOST] = [1.0 / 4.0, -1.0 / 6.0, -1.0 / 6.0, 1.0 / 24.0, 1.0 / 24.0, 1.0];

    #[inline(always)]
    unsafe fn taps<V: Lanes>([a, b, c]: [V; 3]) -> [V; MOST] {
        // SAFETY: the caller's.
        unsafe {
            let [two, minus_two, four] = [2.0, -2.0, 4.0].map(|value| V::splat(value));
            let (even, wide) = (a.add(c), four.mul_add(c, a));
            let (near, far) = (two.mul_add(b, wide), minus_two.mul_add(b, wide));
            [a, even.add(b), even.sub(b), near, far, c]
        }
    }

    #[inline(always)]
    unsafe fn inputs<V: Lanes>(d: [V; MOST]) -> [V; MOST] {
        // SAFETY: the caller's.
        unsafe {
            let [two, four, minus_five] = [2.0, 4.0, -5.0].map(|value| V::splat(value));
            let minus_four = V::splat(-4.0);
            let first = four.mul_add(d[0], minus_five.mul_add(d[2], d[4]));
            let last = four.mul_add(d[1], minus_five.mul_add(d[3], d[5]));
            let (p, q) = (minus_four.mul_add(d[2], d[4]), minus_four.mul_add(d[1], d[3]));
            let (r, s) = (d[4].sub(d[2]), two.mul(d[3].sub(d[1])));
            [first, p.add(q), p.sub(q), r.add(s), r.sub(s), last]
        }
    }

    #[inline(always)]
    unsafe fn outputs<V: Lanes>(m: [V; MOST]) -> [V; 4] {
        // SAFETY: the caller's.
        unsafe {
            let [two, four, eight] = [2.0, 4.0, 8.0].map(|value| V::splat(value));
            let (a, b) = (m[1].add(m[2]), m[1].sub(m[2]));
            let (c, d) = (m[3].add(m[4]), m[3].sub(m[4]));
            [
                m[0].add(a).add(c),
                two.mul_add(d, b),
                four.mul_add(c, a),
                eight.mul_add(d, b).add(m[5]),
            ]
        }
    }

    #[inline(always)]
    unsafe fn spread<V: Lanes>(y: [V; 4]) -> [V; MOST] {
        // SAFETY: the caller's.
        unsafe {
            let [two, four] = [2.0, 4.0].map(|value| V::splat(value));
            let (even, odd) = (y[0].add(y[2]), y[1].add(y[3]));
            let quarter = four.mul_add(y[2], y[0]);
            let half = two.mul(four.mul_add(y[3], y[1]));
            [y[0], even.add(odd), even.sub(odd), quarter.add(half), quarter.sub(half), y[3]]
        }
    }
}
