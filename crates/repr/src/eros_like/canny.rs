//! Canny's edge detector as OpenCV has it, bit by bit.
//!
//! # Model
//! Sobel gradients; pixels whose gradient is the strongest along its direction, in four sectors,
//! and above `low`; of these, the ones above `high` and all connected to them by eight neighbours.
//! The image is not blurred first.
//!
//! # Source
//! Canny: *A Computational Approach to Edge Detection*, PAMI 8(6), 1986; OpenCV's `Canny`.

use evpose_core::Plane;
use evpose_cpu::vectorize;
use serde::{Deserialize, Serialize};

use super::blur::fit;
use super::gradient::{
    Aperture, FIVE, FilterTaps, GradientNorm, GradientWork, SEVEN, Strength, THREE,
};
use super::hysteresis::EdgeMap;
use super::ring::Ring;
use super::suppress::{Rows, Thresholds, classify, pack};

/// How edges are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Canny {
    /// Gradients up to this one are no edges; in units of the aperture's sum.
    pub low: u16,
    /// Gradients above this one are edges. If it is below `low`, the two change places.
    pub high: u16,
    /// The size of the derivative.
    pub aperture: Aperture,
    /// Norm of the gradient that the thresholds apply to.
    pub norm: GradientNorm,
}

impl Default for Canny {
    /// Parameters of EROS-like images.
    fn default() -> Self {
        Self { low: 0, high: 1000, aperture: Aperture::Five, norm: GradientNorm::L1 }
    }
}

/// Memory of an edge detector, to be used again.
#[derive(Debug, Clone, Default)]
pub struct CannyWork {
    gradient: GradientWork,
    /// Strengths, with a pixel of zero on both sides.
    sums: Ring<i16>,
    squares: Ring<i32>,
    sectors: Ring<u8>,
    classes: Vec<u8>,
    map: EdgeMap,
}

impl Canny {
    /// Draws the edges of `image` into `out`, which takes its size: 255 where there is one, else 0.
    pub fn draw(&self, image: &Plane<u8>, work: &mut CannyWork, out: &mut Plane<u8>) {
        let (width, height) = (image.width(), image.height());
        fit(out, width, height);
        if width == 0 || height == 0 {
            return;
        }
        work.map.start(width, height);
        match self.aperture {
            Aperture::Three => self.thin_with(THREE, 1, image, work),
            Aperture::Five => self.thin_with(FIVE, 1, image, work),
            Aperture::Seven => self.thin_with(SEVEN, 16, image, work),
        }
        // Weak edges count where they go on from strong ones.
        work.map.grow(height);
        for y in 0..height {
            work.map.draw(y, out.row_mut(y));
        }
    }

    fn thin_with<const HALF: usize>(
        &self,
        taps: FilterTaps<HALF>,
        scale: u16,
        image: &Plane<u8>,
        work: &mut CannyWork,
    ) {
        let CannyWork { gradient, sums, squares, sectors, classes, map } = work;
        // As OpenCV does: thresholds in the wrong order are swapped.
        let (low, high) = (self.low.min(self.high), self.low.max(self.high));
        let rest = Rest { gradient, sectors, classes, map };
        match self.norm {
            GradientNorm::L1 => thin(taps, thresholds(low, high, scale), image, sums, rest),
            GradientNorm::L2 => thin(taps, thresholds(low, high, scale), image, squares, rest),
        }
    }
}

fn thresholds<S: Strength>(low: u16, high: u16, scale: u16) -> Thresholds<S> {
    Thresholds { low: S::threshold(low, scale), high: S::threshold(high, scale) }
}

/// State that does not depend on the norm.
struct Rest<'a> {
    gradient: &'a mut GradientWork,
    sectors: &'a mut Ring<u8>,
    classes: &'a mut Vec<u8>,
    map: &'a mut EdgeMap,
}

/// Finds candidates and strong pixels of all rows.
fn thin<S: Strength, const HALF: usize>(
    taps: FilterTaps<HALF>,
    thresholds: Thresholds<S>,
    image: &Plane<u8>,
    strengths: &mut Ring<S>,
    rest: Rest<'_>,
) {
    let Rest { gradient, sectors, classes, map } = rest;
    let (width, height) = (image.width(), image.height());
    // Whole words; no pixel stays where strengths are zero.
    let padded = width.next_multiple_of(64);
    gradient.start::<HALF>(padded);
    strengths.reset(3, padded + 2);
    sectors.reset(2, padded);
    classes.resize(padded, 0);
    // Row -1, all zero, is where row 2 will be.
    for y in 0..=height {
        let strength = strengths.row_mut(y);
        if y < height {
            gradient.row(taps, image, y, &mut strength[1..=padded], sectors.row_mut(y));
            strength[width + 1..].fill(S::default());
        } else {
            strength.fill(S::default());
        }
        let Some(done) = y.checked_sub(1) else { continue };
        let rows = Rows {
            // Three rows before y + 1.
            above: strengths.row(y + 1),
            here: strengths.row(done),
            below: strengths.row(y),
        };
        let (candidates, strong) = map.row_mut(done);
        let sectors = sectors.row(done);
        vectorize(
            #[inline(always)]
            || {
                classify(rows, sectors, thresholds, classes);
                pack(classes, candidates, strong);
            },
        );
    }
}
