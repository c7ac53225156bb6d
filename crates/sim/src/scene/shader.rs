//! Shading of all covered pixels, eight at a time.
//!
//! # Model
//! That of [`Scene::shade`], in another order of operations: equal within rounding.

use evpose_core::Plane;
use evpose_cpu::{Kernel8, LANES_8, Lanes8, dispatch};

use super::Scene;
use crate::raster::{CoveredPixels, Mesh, Raster, Varyings, unpack_xy_lanes};

/// Groups of eight pixels that are interpolated before they are lit: independent lookups overlap,
/// where alternating the two steps would wait for memory. Fits in the L1 cache.
const LOOKUP_GROUPS: usize = 16;

/// Scratch memory of the shading pass.
#[derive(Debug, Clone, Default)]
pub(super) struct Shader {
    varyings: Varyings,
    pixels: CoveredPixels,
}

impl Shader {
    /// Writes the luminance of the pixels of `raster` that `mesh` covers, times `light_level`.
    pub(super) fn shade(
        &mut self,
        scene: &Scene,
        raster: &Raster,
        mesh: &Mesh<'_>,
        light_level: f32,
        luminance: &mut Plane<f32>,
    ) {
        let Self { varyings, pixels } = self;
        pixels.list(raster);
        varyings.gather(raster, mesh);
        dispatch(Shade { scene, raster, varyings, pixels, light_level, luminance });
    }
}

struct Shade<'a> {
    scene: &'a Scene,
    raster: &'a Raster,
    varyings: &'a Varyings,
    pixels: &'a CoveredPixels,
    light_level: f32,
    luminance: &'a mut Plane<f32>,
}

impl Kernel8 for Shade<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) {
        let (width, out) = (self.luminance.width(), self.luminance.data_mut());
        let mut eights = self.pixels.eights();
        let mut left = self.pixels.count();
        let (mut seen, mut positions) =
            ([[[0.0; LANES_8]; 6]; LOOKUP_GROUPS], [[0; LANES_8]; LOOKUP_GROUPS]);
        while left > 0 {
            // Groups first, light second: independent lookups overlap in memory.
            let mut known = 0;
            for ((seen, kept), (eight, triangles)) in
                seen.iter_mut().zip(&mut positions).zip(eights.by_ref())
            {
                let [x, y, z, u, v, depth, _, _] =
                    self.varyings.at(l, self.raster, eight, triangles);
                seen[0] = l.store(x);
                seen[1] = l.store(y);
                seen[2] = l.store(z);
                seen[3] = l.store(u);
                seen[4] = l.store(v);
                seen[5] = l.store(depth);
                *kept = *eight;
                known += 1;
            }
            for (seen, positions) in seen.iter().zip(&positions).take(known) {
                let light = self.scene.luminance_of(l, seen);
                let light = l.store(l.mul(light, l.splat(self.light_level)));
                let (x, y) = unpack_xy_lanes(l, l.load_i(*positions));
                let pixels = l.store_i(l.add_i(l.mul_i(y, l.splat_i(width as i32)), x));
                // The last eight are filled up: only `left` of its lanes are pixels.
                for (&pixel, light) in pixels.iter().zip(light).take(left) {
                    out[pixel as usize] = light;
                }
                left = left.saturating_sub(LANES_8);
            }
        }
    }
}

impl Scene {
    #[inline(always)]
    fn luminance_of<L: Lanes8>(&self, l: L, seen: &[[f32; LANES_8]; 6]) -> L::F {
        let [x, y, z] = [l.load(seen[0]), l.load(seen[1]), l.load(seen[2])];
        let [u, v, inverse_depth] = [l.load(seen[3]), l.load(seen[4]), l.load(seen[5])];
        let depth = l.div(l.splat(1.0), inverse_depth);
        let albedo = self.skin.sample_lanes(l, [l.mul(u, depth), l.mul(v, depth)]);
        let radiance = self.lighting.radiance_of(l, [x, y, z], albedo);
        self.response.luminance_of(l, radiance)
    }
}
