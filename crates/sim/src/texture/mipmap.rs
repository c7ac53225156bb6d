//! Anti-aliased textures: the mipmap level that matches the resolution of the frame.
//!
//! # Model
//! A pixel shows the mean of the light of the area it covers. A texel of a surface `s` metres wide
//! along a coordinate is `s / n` metres long if there are `n`; rendered from `d` metres by a camera
//! of focal length `f` pixels it is `f·s / (n·d)` pixels long. Where it is less than half a pixel,
//! blocks of texels are averaged so that a block stays below one pixel: a power of two, of its own
//! along each coordinate (anisotropic), because a texture goes around a finger in a tenth of its
//! length. Without it a moving surface aliases: bilinear interpolation skips texels.
//!
//! # Source
//! Williams, *Pyramidal Parametrics* (SIGGRAPH 1983), with one level for the whole surface.

use evpose_core::Plane;
use glam::{Vec2, Vec3};

use super::Texture;

/// Extent of a texture on a surface along u and v, in metres: the mean over the faces, weighted by
/// area. Zero along a coordinate that does not vary.
pub(crate) fn metres_per_texture(vertices_m: &[Vec3], uvs: &[Vec2], faces: &[[u32; 3]]) -> Vec2 {
    let (mut sum, mut areas) = (Vec2::ZERO, 0.0);
    for face in faces {
        let [a, b, c] = face.map(|v| v as usize);
        let (first_m, second_m) = (vertices_m[b] - vertices_m[a], vertices_m[c] - vertices_m[a]);
        let (first, second) = (uvs[b] - uvs[a], uvs[c] - uvs[a]);
        let (area, determinant) = (first_m.cross(second_m).length(), first.perp_dot(second));
        if determinant == 0.0 {
            continue;
        }
        // The derivatives of the position by the coordinates.
        let along_u = (first_m * second.y - second_m * first.y) / determinant;
        let along_v = (second_m * first.x - first_m * second.x) / determinant;
        sum += area * Vec2::new(along_u.length(), along_v.length());
        areas += area;
    }
    if areas > 0.0 { sum / areas } else { Vec2::ZERO }
}

impl Texture {
    /// The mipmap level for a texture that covers `metres`, rendered at `px_per_m` pixels per metre.
    pub(crate) fn mip_level(self, metres: Vec2, px_per_m: f32) -> Self {
        let (width, height) = (self.width(), self.height());
        let (columns, rows) = (
            texels_per_block(width, metres.x * px_per_m),
            texels_per_block(height, metres.y * px_per_m),
        );
        // As coarse as the frame already.
        if (columns, rows) == (1, 1) {
            return self;
        }
        let mut means = Plane::filled(width / columns, height / rows, [0; 4]);
        let texels = (columns * rows) as u32;
        for y in 0..means.height() {
            for x in 0..means.width() {
                // Half a unit, so that the division rounds to the nearest.
                let mut sums = [texels / 2; 3];
                for j in 0..rows {
                    for i in 0..columns {
                        let [r, g, b, _] = self.texel(x * columns + i, y * rows + j);
                        sums[0] += u32::from(r);
                        sums[1] += u32::from(g);
                        sums[2] += u32::from(b);
                    }
                }
                let [r, g, b] = sums.map(|sum| (sum / texels) as u8);
                *means.at_mut(x, y) = [r, g, b, 0];
            }
        }
        Self::bordered(&means)
    }
}

/// Block size along a coordinate whose `texels` are rendered on `pixels` pixels: a power of two
/// that divides `texels`.
fn texels_per_block(texels: usize, pixels: f32) -> usize {
    let mut count = 1;
    while texels.is_multiple_of(2 * count) && (2 * count) as f32 * pixels <= texels as f32 {
        count *= 2;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Black and white by columns of one texel, brighter by rows.
    fn stripes(width: usize, height: usize) -> Texture {
        let texel =
            |k: usize| [if (k % width).is_multiple_of(2) { 0 } else { 200 }, (k / width) as u8, 7];
        let rgb: Vec<u8> = (0..width * height).flat_map(texel).collect();
        Texture::from_rgb8(width, height, &rgb).unwrap()
    }

    #[test]
    fn texels_finer_than_pixels_are_averaged_along_each_coordinate() {
        // 64 texels on 16 pixels, and 32 on 20.
        let level = stripes(64, 32).mip_level(Vec2::new(0.8, 1.0), 20.0);
        assert_eq!((level.width(), level.height()), (16, 32));
        assert_eq!(level.texel(3, 5), [100, 5, 7, 0]);
        let level = stripes(64, 32).mip_level(Vec2::new(0.8, 0.5), 20.0);
        assert_eq!((level.width(), level.height()), (16, 16));
        // Halves upwards.
        assert_eq!(level.texel(3, 2), [100, 5, 7, 0]);
    }

    #[test]
    fn coarse_textures_and_those_that_cannot_be_halved_stay() {
        let texture = stripes(64, 32);
        assert_eq!(texture.clone().mip_level(Vec2::ONE, 64.0), texture);
        let odd = stripes(63, 31);
        assert_eq!(odd.clone().mip_level(Vec2::ONE, 1.0), odd);
        let nowhere = stripes(8, 8).mip_level(Vec2::ZERO, 100.0);
        assert_eq!((nowhere.width(), nowhere.height()), (1, 1));
    }

    #[test]
    fn a_cylinder_has_its_length_and_its_circumference() {
        let (mut vertices_m, mut uvs, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        let around = 64;
        for k in 0..=around {
            let v = k as f32 / around as f32;
            let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
            for u in [0.0, 1.0] {
                vertices_m.push(Vec3::new(0.3 * u, 0.02 * cos, 0.02 * sin));
                uvs.push(Vec2::new(u, v));
            }
        }
        for k in 0..around {
            let first = 2 * k;
            faces.extend([[first, first + 1, first + 2], [first + 1, first + 3, first + 2]]);
        }
        let metres = metres_per_texture(&vertices_m, &uvs, &faces);
        assert!(
            (metres - Vec2::new(0.3, std::f32::consts::TAU * 0.02)).length() < 1e-4,
            "{metres}"
        );
    }
}
