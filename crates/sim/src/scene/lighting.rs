//! Lambertian shading.

use evpose_cpu::Lanes8;
use glam::Vec3A;

/// A directional light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Unit vector towards the light, in the world.
    pub direction: Vec3A,
    /// Linear RGB intensity.
    pub colour: Vec3A,
}

/// Two directional lights, ambient light and a gain.
///
/// # Model
/// `gain · (max(0, n·l1) c1 + max(0, n·l2) c2 + ambient) · albedo`: Lambert's law, without
/// highlights and shadows.
///
/// # Source
/// EventHands simulator: gain 1.4, ambient (0.05, 0.05, 0.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lighting {
    /// Directional lights.
    pub lights: [DirectionalLight; 2],
    /// Linear RGB of the ambient light.
    pub ambient: Vec3A,
    /// Factor on all light.
    pub gain: f32,
}

impl Lighting {
    /// Linear RGB radiance of a surface with unit normal `normal`.
    #[inline]
    pub fn radiance(&self, normal: Vec3A, albedo: Vec3A) -> Vec3A {
        let [first, second] = &self.lights;
        let irradiance = first.colour * normal.dot(first.direction).max(0.0)
            + second.colour * normal.dot(second.direction).max(0.0)
            + self.ambient;
        irradiance * albedo * self.gain
    }

    /// [`Self::radiance`] of eight surfaces, whose normals need not be of unit length.
    #[inline(always)]
    pub(super) fn radiance_of<L: Lanes8>(
        &self,
        l: L,
        normal: [L::F; 3],
        albedo: [L::F; 3],
    ) -> [L::F; 3] {
        // Avoids a division by zero: a normal of length zero has cosine zero.
        let square = l.max(dot(l, normal, normal), l.splat(f32::MIN_POSITIVE));
        let per_length = l.div(l.splat(1.0), l.sqrt(square));
        let [first, second] = &self.lights;
        let shares = [first.share(l, normal, per_length), second.share(l, normal, per_length)];
        let (first, second) = (first.colour * self.gain, second.colour * self.gain);
        let ambient = self.ambient * self.gain;
        [
            l.mul(sum(l, shares, [first.x, second.x], ambient.x), albedo[0]),
            l.mul(sum(l, shares, [first.y, second.y], ambient.y), albedo[1]),
            l.mul(sum(l, shares, [first.z, second.z], ambient.z), albedo[2]),
        ]
    }
}

impl DirectionalLight {
    /// Cosines between the light and eight normals of given length, clamped at zero.
    #[inline(always)]
    fn share<L: Lanes8>(&self, l: L, normal: [L::F; 3], per_length: L::F) -> L::F {
        let [x, y, z] = self.direction.to_array();
        let cosine = dot(l, normal, [l.splat(x), l.splat(y), l.splat(z)]);
        l.max(l.mul(cosine, per_length), l.splat(0.0))
    }
}

#[inline(always)]
fn sum<L: Lanes8>(l: L, shares: [L::F; 2], colours: [f32; 2], ambient: f32) -> L::F {
    let of_first = l.mul(shares[0], l.splat(colours[0]));
    let of_second = l.mul(shares[1], l.splat(colours[1]));
    l.add(l.add(of_first, of_second), l.splat(ambient))
}

#[inline(always)]
fn dot<L: Lanes8>(l: L, a: [L::F; 3], b: [L::F; 3]) -> L::F {
    l.add(l.add(l.mul(a[0], b[0]), l.mul(a[1], b[1])), l.mul(a[2], b[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_obeys_lamberts_law() {
        let light = |direction, colour| DirectionalLight { direction, colour };
        let lighting = Lighting {
            lights: [
                light(Vec3A::Z, Vec3A::new(1.0, 0.7, 0.5)),
                light(Vec3A::NEG_Z, Vec3A::new(0.2, 0.2, 0.3)),
            ],
            ambient: Vec3A::new(0.05, 0.05, 0.1),
            gain: 1.4,
        };
        let albedo = Vec3A::new(0.5, 0.25, 1.0);
        for degrees in [0.0_f32, 30.0, 60.0, 89.0] {
            let angle = degrees.to_radians();
            let normal = Vec3A::new(angle.sin(), 0.0, angle.cos());
            let want = Vec3A::new(
                1.4 * (angle.cos() + 0.05) * 0.5,
                1.4 * (0.7 * angle.cos() + 0.05) * 0.25,
                1.4 * (0.5 * angle.cos() + 0.1),
            );
            assert!((lighting.radiance(normal, albedo) - want).length() < 1e-6);
        }
    }
}
