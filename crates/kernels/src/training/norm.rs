//! Batch normalisation by the statistics of the batch.
//!
//! # Model
//! Per channel, with mean `m` and biased variance `v` over batch and pixels and
//! `n = (x - m) / sqrt(v + ε)`: `y = γ n + β`, then the activation. The gradient by the input is
//! `γ / sqrt(v + ε) (dy - mean(dy) - n mean(dy n))`. Statistics of images are taken about their own
//! means and joined in double precision, so that values are read once.
//!
//! # Source
//! Ioffe, Szegedy: *Batch Normalization*, ICML 2015. Chan, Golub, LeVeque: *Algorithms for
//! Computing the Sample Variance*, The American Statistician 37, 1983, for the joined statistics.

use evpose_cpu::vectorize;
use rayon::prelude::*;

use super::blocks::Blocks;
use crate::activation::Activation;
use crate::simd::LANES;

type Lane = [f32; LANES];

/// Values of consecutive pixels of a block that a loop takes at a time.
///
/// Compilers unroll a loop over the lanes of one pixel, and then vectorise it over pixels, with
/// gathers and scatters that take ten times as long as the arithmetic.
const STRIP: usize = 8 * LANES;

/// The value of each lane, for all pixels of a strip.
#[inline(always)]
fn strip(lanes: &Lane) -> [f32; STRIP] {
    std::array::from_fn(|i| lanes[i % LANES])
}

/// Mean and biased variance of each channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// `[channels]`
    pub mean: Vec<f32>,
    /// `[channels]`
    pub variance: Vec<f32>,
}

/// A normalisation by known statistics: a factor and an offset for each channel, an activation.
#[derive(Debug, Clone, PartialEq)]
pub struct Norm {
    /// One for each block of channels; zero in the padding of the last.
    scales: Vec<Lane>,
    offsets: Vec<Lane>,
    /// Bounds of the activation.
    min: f32,
    max: f32,
    means: Vec<Lane>,
    /// `1 / sqrt(v + ε)`.
    inverses: Vec<f64>,
}

/// The input of an operation, normalised while it is read.
#[derive(Debug, Clone, Copy)]
pub struct NormalizedInput<'a> {
    /// A batch of the shape of the operation's input.
    pub values: &'a [f32],
    /// The normalisation in front of the operation, if there is one.
    pub norm: Option<&'a Norm>,
}

/// Gradients by the parameters of a normalisation.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradients {
    /// `[channels]`
    pub gamma: Vec<f32>,
    /// `[channels]`
    pub beta: Vec<f32>,
}

impl<'a> From<&'a [f32]> for NormalizedInput<'a> {
    fn from(values: &'a [f32]) -> Self {
        Self { values, norm: None }
    }
}

/// `value` clamped to the bounds of an activation; NaN stays.
#[inline(always)]
fn clamped(value: f32, min: f32, max: f32) -> f32 {
    let value = if value < min { min } else { value };
    if value > max { max } else { value }
}

impl Norm {
    /// The normalisation by `statistics`; `gamma` and `beta` are `[channels]`.
    ///
    /// # Panics
    /// If their lengths differ from that of the statistics.
    pub fn new(
        statistics: &Statistics,
        gamma: &[f32],
        beta: &[f32],
        epsilon: f32,
        activation: Activation,
    ) -> Self {
        let Statistics { mean, variance } = statistics;
        assert_eq!([gamma.len(), beta.len()], [mean.len(); 2], "a factor and offset each channel");
        // In double precision: the offset is a difference of two values that may be nearly equal.
        let inverse = |variance: &f32| 1.0 / f64::from(variance + epsilon).sqrt();
        let inverses: Vec<f64> = variance.iter().map(inverse).collect();
        let scales: Vec<f64> = gamma
            .iter()
            .zip(&inverses)
            .map(|(gamma, inverse)| f64::from(*gamma) * inverse)
            .collect();
        let offset = |channel: usize| {
            (f64::from(beta[channel]) - f64::from(mean[channel]) * scales[channel]) as f32
        };
        let offsets: Vec<f32> = (0..beta.len()).map(offset).collect();
        let [min, max] = activation.bounds();
        Self {
            scales: lanes(&scales.iter().map(|scale| *scale as f32).collect::<Vec<_>>()),
            offsets: lanes(&offsets),
            min,
            max,
            means: lanes(mean),
            inverses,
        }
    }

    /// Mean and biased variance of every channel.
    pub fn statistics(shape: &Blocks, values: &[f32]) -> Statistics {
        assert_eq!(values.len(), shape.value_count(), "values of this shape");
        let count = (shape.height * shape.width) as f64;
        let of_image = |image: &[f32]| -> Vec<[[f64; LANES]; 2]> {
            let blocks = image.chunks_exact(shape.block().max(1));
            let of_block = |block: &[f32]| {
                vectorize(
                    #[inline(always)]
                    || mean_and_squares(block),
                )
            };
            blocks.map(of_block).collect()
        };
        let images: Vec<_> = values.par_chunks(shape.image().max(1)).map(of_image).collect();
        let (mut mean, mut variance) = (Vec::new(), Vec::new());
        for channel in 0..shape.channels {
            let (block, lane) = (channel / LANES, channel % LANES);
            let (mut joined, mut squares, mut seen) = (0.0, 0.0, 0.0);
            for image in &images {
                let [of_image, squares_of_image] = image[block].map(|lanes| lanes[lane]);
                // Images are joined by the update of Chan, Golub and LeVeque (1979): sums of
                // squares of raw values would lose the variance of large means.
                let apart = of_image - joined;
                let all = seen + count;
                squares += squares_of_image + apart * apart * seen * count / all;
                joined += apart * count / all;
                seen = all;
            }
            mean.push(joined as f32);
            variance.push((squares / f64::max(seen, 1.0)) as f32);
        }
        Statistics { mean, variance }
    }

    /// The gradients by the parameters, and by `values`, which takes the place of `gradient`, that
    /// by the result.
    pub fn backward(&self, shape: &Blocks, values: &[f32], gradient: &mut [f32]) -> Gradients {
        assert_eq!(
            [values.len(), gradient.len()],
            [shape.value_count(); 2],
            "values of this shape"
        );
        let size = shape.block().max(1);
        let blocks = shape.blocks();
        let pairs = values.par_chunks(size).zip(gradient.par_chunks(size)).enumerate();
        let sums: Vec<_> = pairs
            .map(|(k, (xs, dys))| {
                let line = self.scale_shift(k % blocks);
                let mean = self.means[k % blocks];
                vectorize(
                    #[inline(always)]
                    || gradient_sums(line, mean, xs, dys),
                )
            })
            .collect();
        // At least one, so that a batch without pixels divides by no zero.
        let count = (shape.batch * shape.height * shape.width).max(1) as f64;
        let (mut gamma, mut beta) = (Vec::new(), Vec::new());
        // The gradient by the input is `a dy + b x + c`.
        let mut planes = vec![[[0.0; LANES]; 3]; blocks];
        for channel in 0..shape.channels {
            let (block, lane) = (channel / LANES, channel % LANES);
            let total = |which: usize| -> f64 {
                sums.iter().skip(block).step_by(blocks).map(|sums| sums[which][lane]).sum()
            };
            // Sums over the batch, of the gradient and of its product with the centred value.
            let [plain, centred] = [0, 1].map(total);
            let inverse = self.inverses[channel];
            let a = f64::from(self.scales[block][lane]);
            let b = -a * inverse * inverse * centred / count;
            let c = -a * plain / count - b * f64::from(self.means[block][lane]);
            for (plane, value) in planes[block].iter_mut().zip([a, b, c]) {
                plane[lane] = value as f32;
            }
            gamma.push((centred * inverse) as f32);
            beta.push(plain as f32);
        }
        let pairs = gradient.par_chunks_mut(size).zip(values.par_chunks(size)).enumerate();
        pairs.for_each(|(k, (dys, xs))| {
            let line = self.scale_shift(k % blocks).strips();
            let planes = planes[k % blocks].each_ref().map(strip);
            vectorize(
                #[inline(always)]
                || {
                    for (dys, xs) in dys.chunks_mut(STRIP).zip(xs.chunks(STRIP)) {
                        line.backward(&planes, xs, dys);
                    }
                },
            );
        });
        Gradients { gamma, beta }
    }

    fn scale_shift(&self, block: usize) -> ScaleShift {
        let (scale, offset) = (self.scales[block], self.offsets[block]);
        ScaleShift { scale, offset, min: self.min, max: self.max }
    }
}

impl NormalizedInput<'_> {
    /// `activation(input + other)`.
    pub fn add(
        self,
        shape: &Blocks,
        other: NormalizedInput<'_>,
        activation: Activation,
    ) -> Vec<f32> {
        let lengths = [self.values.len(), other.values.len()];
        assert_eq!(lengths, [shape.value_count(); 2], "values of this shape");
        let [min, max] = activation.bounds();
        let mut output = vec![0.0; shape.value_count()];
        let size = shape.block().max(1);
        let sources = self.values.par_chunks(size).zip(other.values.par_chunks(size));
        output.par_chunks_mut(size).zip(sources).enumerate().for_each(|(k, (to, (xs, others)))| {
            let [a, b] = [self, other].map(|input| input.scale_shift(k % shape.blocks()).strips());
            vectorize(
                #[inline(always)]
                || {
                    let sources = xs.chunks(STRIP).zip(others.chunks(STRIP));
                    for (to, (xs, others)) in to.chunks_mut(STRIP).zip(sources) {
                        let sums = a.values(xs).zip(b.values(others));
                        for (to, (x, other)) in to.iter_mut().zip(sums) {
                            *to = clamped(x + other, min, max);
                        }
                    }
                },
            );
        });
        output
    }

    /// The normalised values, written to memory.
    pub fn materialized(self, shape: &Blocks) -> Vec<f32> {
        assert_eq!(self.values.len(), shape.value_count(), "values of this shape");
        let mut output = vec![0.0; shape.value_count()];
        let size = shape.block().max(1);
        let pairs = output.par_chunks_mut(size).zip(self.values.par_chunks(size)).enumerate();
        pairs.for_each(|(k, (to, xs))| {
            let line = self.scale_shift(k % shape.blocks()).strips();
            vectorize(
                #[inline(always)]
                || line.write(xs, to),
            );
        });
        output
    }

    /// The normalisation of a block, if there is one.
    pub(super) fn block_norm(&self, block: usize) -> Option<ScaleShift> {
        self.norm.map(|norm| norm.scale_shift(block))
    }

    /// The normalisation of a block, the identity where there is none.
    pub(super) fn scale_shift(&self, block: usize) -> ScaleShift {
        let [min, max] = Activation::Identity.bounds();
        let same = ScaleShift { scale: [1.0; LANES], offset: [0.0; LANES], min, max };
        self.norm.map_or(same, |norm| norm.scale_shift(block))
    }
}

/// The gradient by the input of an activation, from its `output` and the gradient by that.
pub fn activation_backward(activation: Activation, output: &[f32], gradient: &[f32]) -> Vec<f32> {
    /// Values of a piece of work.
    const PIECE: usize = 1 << 14;
    let [min, max] = activation.bounds();
    let mut input = vec![0.0; gradient.len()];
    let sources = output.par_chunks(PIECE).zip(gradient.par_chunks(PIECE));
    input.par_chunks_mut(PIECE).zip(sources).for_each(|(to, (ys, dys))| {
        vectorize(
            #[inline(always)]
            || {
                for (to, (y, dy)) in to.iter_mut().zip(ys.iter().zip(dys)) {
                    // `|` evaluates both sides: a branch in between would keep the loop from
                    // becoming vectors.
                    *to = if (*y <= min) | (*y >= max) { 0.0 } else { *dy };
                }
            },
        );
    });
    input
}

/// The normalisation of a block: `scale x + offset`, clamped to the bounds of the activation.
#[derive(Clone, Copy)]
pub(super) struct ScaleShift {
    pub(super) scale: Lane,
    pub(super) offset: Lane,
    pub(super) min: f32,
    pub(super) max: f32,
}

impl ScaleShift {
    #[inline(always)]
    pub(super) fn value(&self, lane: usize, x: f32) -> f32 {
        clamped(self.scale[lane] * x + self.offset[lane], self.min, self.max)
    }

    /// The gradient behind the activation: 0 where the value is clamped. NaN passes.
    #[inline(always)]
    fn masked(&self, lane: usize, x: f32, gradient: f32) -> f32 {
        let value = self.scale[lane] * x + self.offset[lane];
        // Without a branch.
        if (value <= self.min) | (value >= self.max) { 0.0 } else { gradient }
    }

    /// The same for loops over strips.
    #[inline(always)]
    pub(super) fn strips(&self) -> ScaleShiftStrips {
        let (scale, offset) = (strip(&self.scale), strip(&self.offset));
        ScaleShiftStrips { scale, offset, min: self.min, max: self.max }
    }
}

/// A [`ScaleShift`] for loops over strips.
#[derive(Clone, Copy)]
pub(super) struct ScaleShiftStrips {
    scale: [f32; STRIP],
    offset: [f32; STRIP],
    min: f32,
    max: f32,
}

impl ScaleShiftStrips {
    /// The normalised values of a strip, or of the beginning of one.
    #[inline(always)]
    fn values(&self, xs: &[f32]) -> impl Iterator<Item = f32> {
        let lines = self.scale.iter().zip(&self.offset);
        xs.iter()
            .zip(lines)
            .map(|(x, (scale, offset))| clamped(scale * x + offset, self.min, self.max))
    }

    /// Writes the normalised values of any number of pixels.
    #[inline(always)]
    pub(super) fn write(&self, from: &[f32], to: &mut [f32]) {
        for (to, xs) in to.chunks_mut(STRIP).zip(from.chunks(STRIP)) {
            to.iter_mut().zip(self.values(xs)).for_each(|(to, value)| *to = value);
        }
    }

    /// Writes `near` and `far`, normalised and mixed with these weights.
    #[inline(always)]
    pub(super) fn mix(&self, [near, far]: [&[f32]; 2], weights: [f32; 2], to: &mut [f32]) {
        let sources = near.chunks(STRIP).zip(far.chunks(STRIP));
        for (to, (near, far)) in to.chunks_mut(STRIP).zip(sources) {
            let pairs = self.values(near).zip(self.values(far));
            for (to, (near, far)) in to.iter_mut().zip(pairs) {
                *to = weights[0] * near + weights[1] * far;
            }
        }
    }

    /// Replaces gradients `dy` of a strip by `a dy + b x + c`, with `dy` 0 where the value is
    /// clamped.
    #[inline(always)]
    fn backward(&self, [a, b, c]: &[[f32; STRIP]; 3], xs: &[f32], dys: &mut [f32]) {
        let lines = self.scale.iter().zip(&self.offset).zip(a.iter().zip(b).zip(c));
        for ((dy, x), ((scale, offset), ((a, b), c))) in dys.iter_mut().zip(xs).zip(lines) {
            let value = scale * x + offset;
            // Without a branch.
            let masked = if (value <= self.min) | (value >= self.max) { 0.0 } else { *dy };
            *dy = a * masked + (b * x + c);
        }
    }
}

/// Values of a run whose sums are single precision, before they are added in double precision.
const RUN: usize = 64 * LANES;

/// Means and sums of squares about them of the pixels of a block.
#[inline(always)]
fn mean_and_squares(block: &[f32]) -> [[f64; LANES]; 2] {
    let count = (block.len() / LANES).max(1) as f64;
    let mut means = [0.0; LANES];
    for pixels in block.chunks(RUN) {
        let mut sums = [0.0; LANES];
        for pixel in pixels.as_chunks::<LANES>().0 {
            for lane in 0..LANES {
                sums[lane] += pixel[lane];
            }
        }
        for lane in 0..LANES {
            means[lane] += f64::from(sums[lane]) / count;
        }
    }
    // Differences are of single precision, whose mean is near: their rounding is below that of
    // values.
    let near: Lane = means.map(|mean| mean as f32);
    let mut squares = [0.0; LANES];
    for pixels in block.chunks(RUN) {
        let mut sums = [0.0; LANES];
        for pixel in pixels.as_chunks::<LANES>().0 {
            for lane in 0..LANES {
                let apart = pixel[lane] - near[lane];
                sums[lane] += apart * apart;
            }
        }
        for lane in 0..LANES {
            squares[lane] += f64::from(sums[lane]);
        }
    }
    [means, squares]
}

/// The sums over pixels of a block of `dy` and of `dy (x - mean)`.
#[inline(always)]
fn gradient_sums(line: ScaleShift, mean: Lane, xs: &[f32], dys: &[f32]) -> [[f64; LANES]; 2] {
    // Runs are summed in single precision, and totals in double: errors do not grow with the image.
    let mut totals = [[0.0; LANES]; 2];
    for (xs, dys) in xs.chunks(RUN).zip(dys.chunks(RUN)) {
        let mut sums = [[0.0; LANES]; 2];
        for (x, dy) in xs.as_chunks::<LANES>().0.iter().zip(dys.as_chunks::<LANES>().0) {
            for lane in 0..LANES {
                let dy = line.masked(lane, x[lane], dy[lane]);
                sums[0][lane] += dy;
                sums[1][lane] += dy * (x[lane] - mean[lane]);
            }
        }
        for (totals, sums) in totals.iter_mut().zip(sums) {
            for lane in 0..LANES {
                totals[lane] += f64::from(sums[lane]);
            }
        }
    }
    totals
}

/// Values in blocks of sixteen, padded with zeros.
fn lanes(values: &[f32]) -> Vec<Lane> {
    let block = |values: &[f32]| {
        let mut lanes = [0.0; LANES];
        lanes[..values.len()].copy_from_slice(values);
        lanes
    };
    values.chunks(LANES).map(block).collect()
}

/// Sums over all pixels, channel by channel.
pub(super) fn channel_sums(shape: &Blocks, values: &[f32]) -> Vec<f32> {
    let blocks = shape.blocks();
    let sums: Vec<[f64; LANES]> = values
        .par_chunks(shape.block().max(1))
        .map(|block| {
            let mut totals = [0.0; LANES];
            // Runs in f32 vectorise, and their sums in f64 keep the precision over a batch.
            for pixels in block.chunks(RUN) {
                let mut sums = [0.0; LANES];
                for pixel in pixels.as_chunks::<LANES>().0 {
                    for lane in 0..LANES {
                        sums[lane] += pixel[lane];
                    }
                }
                for lane in 0..LANES {
                    totals[lane] += f64::from(sums[lane]);
                }
            }
            totals
        })
        .collect();
    // In the order of images, whatever the number of threads.
    let total = |channel: usize| -> f64 {
        sums.iter().skip(channel / LANES).step_by(blocks).map(|sums| sums[channel % LANES]).sum()
    };
    (0..shape.channels).map(|channel| total(channel) as f32).collect()
}
