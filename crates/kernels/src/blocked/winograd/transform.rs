//! Transforms of Winograd's minimal filtering algorithms F(2, 3) and F(4, 3).
//!
//! # Model
//! `OUT` outputs of a row convolved with a kernel `g` of three taps are `Aᵀ ((G g) ⊙ (Bᵀ d))` of
//! the `IN = OUT + 2` inputs `d`: `IN` multiplications instead of three per output. In two
//! dimensions the transforms are applied along columns, then rows.
//!
//! # Source
//! Lavin, Gray: *Fast Algorithms for Convolutional Neural Networks*, CVPR 2016, Sec. 4.

use crate::simd::Lanes;

/// Inputs of the largest transform, F(4, 3).
pub(crate) const MAX_INPUTS: usize = 6;

/// F(`OUT`, 3). Arrays have [`MAX_INPUTS`] elements; those from `IN` on are unused.
///
/// The scales of the rows of `G` are multiplied into the inputs instead of the weights: weights
/// that are transformed on the fly are transformed for every image and thread.
pub(crate) trait WinogradTransform {
    /// Outputs of a tile along one side.
    const OUT: usize;
    /// Inputs of a tile along one side.
    const IN: usize = Self::OUT + 2;
    /// `G`, its rows without their scales.
    const G: [[f32; 3]; MAX_INPUTS];
    /// Scales of the rows of `G`.
    const G_SCALES: [f32; MAX_INPUTS];

    /// Weight transform `G g`, without the scales.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn weights<V: Lanes>(g: [V; 3]) -> [V; MAX_INPUTS];

    /// Input transform `Bᵀ d`.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn input<V: Lanes>(d: [V; MAX_INPUTS]) -> [V; MAX_INPUTS];

    /// Output transform `Aᵀ m`.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn output<V: Lanes>(m: [V; MAX_INPUTS]) -> [V; 4];

    /// Transposed output transform `A y`, of the gradient with respect to the outputs.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    unsafe fn output_transposed<V: Lanes>(y: [V; 4]) -> [V; MAX_INPUTS];
}

/// F(2, 3): four multiplications instead of six; its transforms only add and subtract.
pub(crate) struct F2x3;

/// F(4, 3): six multiplications instead of twelve.
pub(crate) struct F4x3;

impl WinogradTransform for F2x3 {
    const OUT: usize = 2;
    const G: [[f32; 3]; MAX_INPUTS] =
        [[1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]];
    const G_SCALES: [f32; MAX_INPUTS] = [1.0, 0.5, 0.5, 1.0, 0.0, 0.0];

    #[inline(always)]
    unsafe fn weights<V: Lanes>([a, b, c]: [V; 3]) -> [V; MAX_INPUTS] {
        // SAFETY: the caller's.
        unsafe {
            let even = a.add(c);
            [a, even.add(b), even.sub(b), c, c, c]
        }
    }

    #[inline(always)]
    unsafe fn input<V: Lanes>(d: [V; MAX_INPUTS]) -> [V; MAX_INPUTS] {
        // SAFETY: the caller's.
        unsafe {
            let first = [d[0].sub(d[2]), d[1].add(d[2]), d[2].sub(d[1]), d[1].sub(d[3])];
            [first[0], first[1], first[2], first[3], d[4], d[5]]
        }
    }

    #[inline(always)]
    unsafe fn output<V: Lanes>(m: [V; MAX_INPUTS]) -> [V; 4] {
        // SAFETY: the caller's.
        unsafe { [m[0].add(m[1]).add(m[2]), m[1].sub(m[2]).sub(m[3]), m[2], m[3]] }
    }

    #[inline(always)]
    unsafe fn output_transposed<V: Lanes>(y: [V; 4]) -> [V; MAX_INPUTS] {
        // SAFETY: the caller's.
        unsafe { [y[0], y[0].add(y[1]), y[0].sub(y[1]), V::splat(0.0).sub(y[1]), y[2], y[3]] }
    }
}

impl WinogradTransform for F4x3 {
    const OUT: usize = 4;
    const G: [[f32; 3]; MAX_INPUTS] = [
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 2.0, 4.0],
        [1.0, -2.0, 4.0],
        [0.0, 0.0, 1.0],
    ];
    const G_SCALES: [f32; MAX_INPUTS] =
        [1.0 / 4.0, -1.0 / 6.0, -1.0 / 6.0, 1.0 / 24.0, 1.0 / 24.0, 1.0];

    #[inline(always)]
    unsafe fn weights<V: Lanes>([a, b, c]: [V; 3]) -> [V; MAX_INPUTS] {
        // SAFETY: the caller's.
        unsafe {
            let [two, minus_two, four] = [2.0, -2.0, 4.0].map(|value| V::splat(value));
            let (even, wide) = (a.add(c), four.mul_add(c, a));
            let (near, far) = (two.mul_add(b, wide), minus_two.mul_add(b, wide));
            [a, even.add(b), even.sub(b), near, far, c]
        }
    }

    #[inline(always)]
    unsafe fn input<V: Lanes>(d: [V; MAX_INPUTS]) -> [V; MAX_INPUTS] {
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
    unsafe fn output<V: Lanes>(m: [V; MAX_INPUTS]) -> [V; 4] {
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
    unsafe fn output_transposed<V: Lanes>(y: [V; 4]) -> [V; MAX_INPUTS] {
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
