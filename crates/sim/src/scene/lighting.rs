//! Light on a matt surface.

use glam::Vec3A;

/// Light from one direction, as from very far away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Unit vector towards the light, in the world.
    pub direction: Vec3A,
    /// Linear RGB intensity.
    pub colour: Vec3A,
}

/// Two lights, what comes from everywhere, and the brightness of it all.
///
/// # Model
/// `gain · (max(0, n·l1) c1 + max(0, n·l2) c2 + ambient) · albedo`: Lambert's law, without
/// highlights and shadows.
///
/// # Source
/// EventHands simulator: gain 1.4, ambient (0.05, 0.05, 0.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lighting {
    /// The lights.
    pub lights: [DirectionalLight; 2],
    /// Linear RGB light from everywhere.
    pub ambient: Vec3A,
    /// Factor on the sum.
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
