//! The loops over pixels, each compiled for every width of vectors.

use std::ops::Range;

use pulp::NullaryFnOnce;

use super::sums::Sums;

/// What becomes of a number of a channel: `scale x + offset`, kept between bounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) scale: f32,
    pub(super) offset: f32,
    pub(super) least: f32,
    pub(super) most: f32,
}

impl Line {
    #[inline(always)]
    fn value(self, x: f32) -> f32 {
        let value = self.scale * x + self.offset;
        // Not `max` and `min`, which would turn NaN into a number.
        let value = if value < self.least { self.least } else { value };
        if value > self.most { self.most } else { value }
    }

    /// A gradient, or 0 where the value is kept at a bound. NaN goes through.
    #[inline(always)]
    fn masked(self, x: f32, gradient: f32) -> f32 {
        let value = self.scale * x + self.offset;
        // Without a branch.
        if (value <= self.least) | (value >= self.most) { 0.0 } else { gradient }
    }
}

/// One image normalised, channel by channel.
pub(super) struct Normalise<'a> {
    pub(super) pixels: usize,
    pub(super) lines: &'a [Line],
    pub(super) from: &'a [f32],
    pub(super) to: &'a mut [f32],
}

impl NullaryFnOnce for Normalise<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { pixels, lines, from, to } = self;
        let planes = to.chunks_exact_mut(pixels).zip(from.chunks_exact(pixels));
        for ((to, from), &line) in planes.zip(lines) {
            for (y, &x) in to.iter_mut().zip(from) {
                *y = line.value(x);
            }
        }
    }
}

/// Mean and biased variance of a channel.
pub(super) struct MeanAndVariance<'a> {
    /// Numbers of an image, and where the channel is among them.
    pub(super) image: usize,
    pub(super) range: Range<usize>,
    /// Numbers of the channel in all images.
    pub(super) count: f64,
    pub(super) input: &'a [f32],
}

impl NullaryFnOnce for MeanAndVariance<'_> {
    type Output = (f32, f32);

    #[inline(always)]
    fn call(self) -> (f32, f32) {
        let Self { image, range, count, input } = self;
        let mut sums = Sums::default();
        for image in input.chunks_exact(image) {
            let xs = &image[range.clone()];
            sums.add(xs, xs, |x, _| (x, 0.0));
        }
        let mean = (sums.totals().0 / count) as f32;
        let mut squares = Sums::default();
        for image in input.chunks_exact(image) {
            let xs = &image[range.clone()];
            squares.add(xs, xs, move |x, _| ((x - mean) * (x - mean), 0.0));
        }
        (mean, (squares.totals().0 / count) as f32)
    }
}

/// The sums over a channel of `dy` and of `dy (x - mean)`.
pub(super) struct GradientSums<'a> {
    /// As in [`MeanAndVariance`].
    pub(super) image: usize,
    pub(super) range: Range<usize>,
    pub(super) line: Line,
    pub(super) mean: f32,
    pub(super) input: &'a [f32],
    pub(super) gradient: &'a [f32],
}

impl NullaryFnOnce for GradientSums<'_> {
    type Output = (f64, f64);

    #[inline(always)]
    fn call(self) -> (f64, f64) {
        let Self { image, range, line, mean, input, gradient } = self;
        let mut sums = Sums::default();
        for (xs, dys) in input.chunks_exact(image).zip(gradient.chunks_exact(image)) {
            sums.add(&xs[range.clone()], &dys[range.clone()], move |x, dy| {
                let dy = line.masked(x, dy);
                (dy, dy * (x - mean))
            });
        }
        sums.totals()
    }
}

/// The gradient by one image, `a dy + b x + c`, channel by channel.
pub(super) struct GradientByInput<'a> {
    pub(super) pixels: usize,
    pub(super) lines: &'a [Line],
    /// `a`, `b` and `c` of each channel.
    pub(super) planes: &'a [[f32; 3]],
    pub(super) xs: &'a [f32],
    pub(super) dys: &'a [f32],
    pub(super) to: &'a mut [f32],
}

impl NullaryFnOnce for GradientByInput<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { pixels, lines, planes, xs, dys, to } = self;
        let sources = xs.chunks_exact(pixels).zip(dys.chunks_exact(pixels));
        let channels = to.chunks_exact_mut(pixels).zip(sources).zip(lines.iter().zip(planes));
        for ((to, (xs, dys)), (&line, &[a, b, c])) in channels {
            for (dx, (&x, &dy)) in to.iter_mut().zip(xs.iter().zip(dys)) {
                *dx = a * line.masked(x, dy) + (b * x + c);
            }
        }
    }
}
