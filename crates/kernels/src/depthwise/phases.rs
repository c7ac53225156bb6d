//! Where pixels of a padded plane lie in its phases.

use super::Depthwise;
use super::sums::BLOCK;

/// The layout of the phases of one shape.
pub(super) struct Grid {
    shape: Depthwise,
    output: [usize; 2],
    /// Columns of a phase, and of a row of outputs with what lies between two.
    columns: usize,
    /// Numbers of a phase, whole blocks.
    of_phase: usize,
    /// Zeros before the outputs of a gradient: as far as taps reach.
    pub(super) before: usize,
    /// In the order of the weights.
    pub(super) taps: Vec<Tap>,
}

/// A tap of a kernel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tap {
    /// The phase it reads.
    pub(super) phase: usize,
    /// How far its run is from the beginning of the phase.
    pub(super) shift: usize,
    /// Where its run begins in all phases.
    pub(super) at: usize,
}

impl Grid {
    pub(super) fn new(shape: &Depthwise) -> Self {
        let padded = |pixels: usize| (pixels + 2 * shape.padding).div_ceil(shape.stride);
        let (rows, columns) = (padded(shape.height), padded(shape.width));
        let of_phase = (rows * columns).div_ceil(BLOCK) * BLOCK;
        let stride = shape.stride;
        let taps: Vec<Tap> = (0..shape.kernel)
            .flat_map(|ky| (0..shape.kernel).map(move |kx| (ky, kx)))
            .map(|(ky, kx)| {
                let phase = ky % stride * stride + kx % stride;
                let shift = ky / stride * columns + kx / stride;
                Tap { phase, shift, at: phase * of_phase + shift }
            })
            .collect();
        let before = taps.iter().map(|tap| tap.shift).max().unwrap_or(0);
        Self { shape: *shape, output: shape.output(), columns, of_phase, before, taps }
    }

    pub(super) fn phases(&self) -> usize {
        self.shape.stride * self.shape.stride
    }

    /// Blocks of a run of outputs.
    pub(super) fn blocks(&self) -> usize {
        let [rows, columns] = self.output;
        ((rows - 1) * self.columns + columns).div_ceil(BLOCK)
    }

    pub(super) fn resize(&self, run: &mut Vec<f32>) {
        run.resize(self.blocks() * BLOCK, 0.0);
    }

    /// Room behind the last phase: the last block of a run reads beyond it.
    pub(super) fn resize_phases(&self, phases: &mut Vec<f32>) {
        phases.resize(self.phases() * self.of_phase + self.before + BLOCK, 0.0);
    }

    pub(super) fn phase<'a>(&self, phases: &'a mut [f32], phase: usize) -> &'a mut [f32] {
        &mut phases[phase * self.of_phase..][..self.of_phase]
    }

    /// Lays a plane out, with zeros around it: those of the plane before, or fresh ones.
    pub(super) fn lay(&self, plane: &[f32], phases: &mut Vec<f32>) {
        self.resize_phases(phases);
        if self.shape.stride == 1 {
            let start = self.shape.padding * self.columns + self.shape.padding;
            let rows = phases[start..].chunks_mut(self.columns);
            for (to, row) in rows.zip(plane.chunks_exact(self.shape.width)) {
                to[..row.len()].copy_from_slice(row);
            }
            return;
        }
        for (y, row) in plane.chunks_exact(self.shape.width).enumerate() {
            self.each_part(y, |x, at| {
                let from = row[x..].iter().step_by(self.shape.stride);
                phases[at..].iter_mut().zip(from).for_each(|(to, from)| *to = *from);
            });
        }
    }

    /// The inverse of [`lay`](Self::lay).
    pub(super) fn take_input(&self, phases: &[f32], plane: &mut [f32]) {
        if self.shape.stride == 1 {
            let start = self.shape.padding * self.columns + self.shape.padding;
            let rows = phases[start..].chunks(self.columns);
            for (from, row) in rows.zip(plane.chunks_exact_mut(self.shape.width)) {
                row.copy_from_slice(&from[..row.len()]);
            }
            return;
        }
        for (y, row) in plane.chunks_exact_mut(self.shape.width).enumerate() {
            self.each_part(y, |x, at| {
                let to = row[x..].iter_mut().step_by(self.shape.stride);
                to.zip(&phases[at..]).for_each(|(to, from)| *to = *from);
            });
        }
    }

    /// Calls `part(x, at)` for what row `y` puts into each phase: every `stride`-th pixel from `x` on,
    /// from place `at` on.
    fn each_part(&self, y: usize, mut part: impl FnMut(usize, usize)) {
        let Depthwise { stride, padding, width, .. } = self.shape;
        let row = y + padding;
        for x in 0..stride.min(width) {
            let column = x + padding;
            let phase = row % stride * stride + column % stride;
            part(x, phase * self.of_phase + row / stride * self.columns + column / stride);
        }
    }

    /// Lays the gradient of a plane of outputs out, with zeros between its rows and around them, as
    /// [`lay`](Self::lay) does.
    pub(super) fn lay_gradient(&self, gradient: &[f32], run: &mut Vec<f32>) {
        run.resize(self.before + self.of_phase + BLOCK, 0.0);
        let rows = run[self.before..].chunks_mut(self.columns);
        for (to, from) in rows.zip(gradient.chunks_exact(self.output[1])) {
            to[..from.len()].copy_from_slice(from);
        }
    }

    /// The outputs of a run.
    pub(super) fn take_output(&self, run: &[f32], output: &mut [f32]) {
        let rows = run.chunks(self.columns);
        for (from, to) in rows.zip(output.chunks_exact_mut(self.output[1])) {
            to.copy_from_slice(&from[..to.len()]);
        }
    }
}
