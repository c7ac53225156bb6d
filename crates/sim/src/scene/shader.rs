//! The light of all covered pixels, eight at a time.
//!
//! # Model
//! That of [`Scene::shade`], in another order of operations: equal within rounding.

use evpose_core::{LANES, LaneWork, Lanes, Plane, in_lanes};

use super::Scene;
use crate::raster::{Mesh, Raster, SeenPixel, Varyings};

/// Memory to work in.
#[derive(Debug, Clone, Default)]
pub(super) struct Shader {
    varyings: Varyings,
    pixels: Vec<SeenPixel>,
}

impl Shader {
    /// Writes the luminance of the pixels of `raster` that see `mesh`, times `light_level`.
    pub(super) fn shade(
        &mut self,
        scene: &Scene,
        raster: &Raster,
        mesh: &Mesh<'_>,
        light_level: f32,
        luminance: &mut Plane<f32>,
    ) {
        let Self { varyings, pixels } = self;
        let count = raster.seen_pixels(pixels);
        varyings.gather(raster, mesh);
        let pixels = &pixels[..count];
        in_lanes(Shade { scene, raster, varyings, pixels, light_level, luminance });
    }
}

struct Shade<'a> {
    scene: &'a Scene,
    raster: &'a Raster,
    varyings: &'a Varyings,
    pixels: &'a [SeenPixel],
    light_level: f32,
    luminance: &'a mut Plane<f32>,
}

impl LaneWork for Shade<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let (width, out) = (self.luminance.width(), self.luminance.data_mut());
        for batch in self.pixels.chunks(LANES) {
            // Where there are no eight left, the last one has company of itself.
            let mut seen = [l.splat(0.0); LANES];
            let last = batch.len() - 1;
            for (k, seen) in seen.iter_mut().enumerate() {
                *seen = self.varyings.at(l, self.raster, batch[k.min(last)]);
            }
            let light = self.scene.luminance_of(l, l.transpose(seen));
            let light = l.store(l.mul(light, l.splat(self.light_level)));
            for (pixel, light) in batch.iter().zip(light) {
                out[usize::from(pixel.y) * width + usize::from(pixel.x)] = light;
            }
        }
    }
}

impl Scene {
    #[inline(always)]
    fn luminance_of<L: Lanes>(&self, l: L, seen: [L::F; LANES]) -> L::F {
        let [x, y, z, u, v, inverse_depth, _, _] = seen;
        let depth = l.div(l.splat(1.0), inverse_depth);
        let albedo = self.skin.sample_lanes(l, [l.mul(u, depth), l.mul(v, depth)]);
        let radiance = self.lighting.radiance_of(l, [x, y, z], albedo);
        self.response.luminance_of(l, radiance)
    }
}
