//! The conversion as a whole.

use evpose_core::Plane;
use serde::{Deserialize, Serialize};

use super::blur::{BlurWork, GaussianKernel};
use super::canny::{Canny, CannyWork};
use super::speckle::{pepper, salt_and_pepper};

/// How images are made to look like EROS frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ErosLike {
    /// Blur before edges are looked for.
    pub blur: GaussianKernel,
    /// Edge detector.
    pub canny: Canny,
    /// Pixels that draw less than this, of 0 to 254, lose their edge.
    pub pepper_below: u8,
    /// Pixels that then draw less than this, of 0 to 254, are black.
    pub black_below: u8,
    /// Pixels that draw more than this, of 0 to 254, are white.
    pub white_above: u8,
    /// Blur of the result.
    pub final_blur: GaussianKernel,
}

impl Default for ErosLike {
    /// Parameters of the published data sets: the defaults of the export script.
    fn default() -> Self {
        Self {
            blur: GaussianKernel::Five,
            canny: Canny::default(),
            pepper_below: 90,
            black_below: 5,
            white_above: 250,
            final_blur: GaussianKernel::Five,
        }
    }
}

/// Memory of a conversion, to be used again.
#[derive(Debug, Clone)]
pub struct ErosLikeWork {
    blur: BlurWork,
    canny: CannyWork,
    blurred: Plane<u8>,
    edges: Plane<u8>,
}

impl Default for ErosLikeWork {
    fn default() -> Self {
        let empty = Plane::filled(0, 0, 0);
        Self {
            blur: BlurWork::default(),
            canny: CannyWork::default(),
            blurred: empty.clone(),
            edges: empty,
        }
    }
}

impl ErosLike {
    /// The defaults of the published class, six times as much salt and pepper as those of its
    /// export script.
    pub fn class_defaults() -> Self {
        Self { black_below: 30, white_above: 225, ..Self::default() }
    }

    /// Converts a grey image; its noise depends on `seed` and on nothing else.
    pub fn convert(&self, grey: &Plane<u8>, seed: u64) -> Plane<u8> {
        let mut out = Plane::filled(0, 0, 0);
        self.convert_into(grey, seed, &mut ErosLikeWork::default(), &mut out);
        out
    }

    /// The same into `out`, which takes the size of the image, with memory that is used again.
    pub fn convert_into(
        &self,
        grey: &Plane<u8>,
        seed: u64,
        work: &mut ErosLikeWork,
        out: &mut Plane<u8>,
    ) {
        self.blur.blur(grey, &mut work.blur, &mut work.blurred);
        self.canny.draw(&work.blurred, &mut work.canny, &mut work.edges);
        pepper(&mut work.edges, self.pepper_below, seed);
        salt_and_pepper(&mut work.edges, self.black_below, self.white_above, seed);
        self.final_blur.blur(&work.edges, &mut work.blur, out);
    }
}
