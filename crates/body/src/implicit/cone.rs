//! Round cones and their smooth union: the clay the arm is made of. Metres.
//!
//! # Model
//! A round cone is the set of points nearer to a segment than a radius that changes linearly along
//! it; its distance here is the radial one, `|p − nearest point of the axis| − radius there`. The
//! smooth minimum of two distances is the quadratic one, which adds at most a quarter of the
//! blending length where they are equal and nothing where they differ by more.
//!
//! Only sums, products, quotients and square roots, so that every machine makes the same arm.
//!
//! # Source
//! Quilez, *Smooth minimum* and *Distance functions*, iquilezles.org.

use glam::Vec3;

/// A round cone, possibly flattened.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cone {
    start_m: Vec3,
    axis_m: Vec3,
    inverse_length_sq: f32,
    radius_m: f32,
    radius_change_m: f32,
    /// Unit vector along which the cross section is flattened.
    flat_axis: Vec3,
    /// One less than the inverse of the ratio of thickness to width.
    flattening: f32,
}

impl Cone {
    /// From `start_m` with radius `radii_m[0]` to `end_m` with radius `radii_m[1]`.
    pub(crate) fn new(start_m: Vec3, end_m: Vec3, radii_m: [f32; 2]) -> Self {
        let axis_m = end_m - start_m;
        let length_sq = axis_m.length_squared();
        Self {
            start_m,
            axis_m,
            inverse_length_sq: if length_sq > 0.0 { 1.0 / length_sq } else { 0.0 },
            radius_m: radii_m[0],
            radius_change_m: radii_m[1] - radii_m[0],
            flat_axis: Vec3::Y,
            flattening: 0.0,
        }
    }

    /// A ball.
    pub(crate) fn ball(centre_m: Vec3, radius_m: f32) -> Self {
        Self::new(centre_m, centre_m, [radius_m; 2])
    }

    /// The same with its thickness along the unit vector `axis` times `ratio`.
    pub(crate) fn flattened(self, axis: Vec3, ratio: f32) -> Self {
        Self { flat_axis: axis, flattening: 1.0 / ratio - 1.0, ..self }
    }

    /// Signed distance, negative inside.
    pub(crate) fn distance(&self, point_m: Vec3) -> f32 {
        let from_start = point_m - self.start_m;
        let along = (from_start.dot(self.axis_m) * self.inverse_length_sq).clamp(0.0, 1.0);
        let mut offset = from_start - self.axis_m * along;
        offset += self.flat_axis * (self.flattening * offset.dot(self.flat_axis));
        offset.length() - (self.radius_m + self.radius_change_m * along)
    }
}

/// Cones end to end, each starting where the one before ends with the same radius.
pub(crate) type Strand = Vec<Cone>;

/// A strand through `points_m` with `radii_m` there.
pub(crate) fn strand<const N: usize>(points_m: [Vec3; N], radii_m: [f32; N]) -> Strand {
    (1..N).map(|k| Cone::new(points_m[k - 1], points_m[k], [radii_m[k - 1], radii_m[k]])).collect()
}

/// Strands that blend into each other over a length.
///
/// Within a strand the plain minimum is continuous; blending would swell it at every joint.
#[derive(Debug, Clone)]
pub(crate) struct Blend {
    pub(crate) strands: Vec<Strand>,
    pub(crate) blend_m: f32,
}

impl Blend {
    /// Signed distance to the smooth union, negative inside.
    pub(crate) fn distance(&self, point_m: Vec3) -> f32 {
        self.strands.iter().fold(f32::INFINITY, |union, strand| {
            let nearest =
                strand.iter().map(|cone| cone.distance(point_m)).fold(f32::INFINITY, f32::min);
            smooth_min(union, nearest, self.blend_m)
        })
    }
}

/// The smaller of two distances, rounded off where they differ by less than `blend_m`.
pub(crate) fn smooth_min(a: f32, b: f32, blend_m: f32) -> f32 {
    let overlap = (blend_m - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * blend_m)
}

/// 0 below `low`, 1 above `high`, and the cubic with level ends between.
pub(crate) fn smooth_step(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_to_a_capsule_is_exact() {
        let capsule = Cone::new(Vec3::ZERO, Vec3::X, [0.1; 2]);
        assert!((capsule.distance(Vec3::new(0.5, 0.3, 0.0)) - 0.2).abs() < 1e-6);
        assert!((capsule.distance(Vec3::new(-0.3, 0.4, 0.0)) - 0.4).abs() < 1e-6);
        assert!((capsule.distance(Vec3::new(0.2, 0.0, 0.0)) + 0.1).abs() < 1e-6);
    }

    #[test]
    fn a_flattened_cone_is_thinner_along_its_axis_only() {
        let flat = Cone::ball(Vec3::ZERO, 0.1).flattened(Vec3::Y, 0.5);
        assert!(flat.distance(Vec3::Y * 0.05).abs() < 1e-6);
        assert!(flat.distance(Vec3::Z * 0.1).abs() < 1e-6);
    }

    #[test]
    fn the_smooth_minimum_is_the_minimum_away_from_the_seam() {
        assert!((smooth_min(0.1, 0.5, 0.2) - 0.1).abs() < 1e-7);
        assert!((smooth_min(0.1, 0.1, 0.2) - 0.05).abs() < 1e-7);
    }
}
