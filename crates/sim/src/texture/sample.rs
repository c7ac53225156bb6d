//! An RGB texture with bilinear filtering and repeat wrapping.

use evpose_core::Plane;
use evpose_cpu::Lanes8;
use glam::{Vec2, Vec3A, Vec4};

/// Code value of full intensity.
const WHITE: f32 = 255.0;

/// An image of eight bits a channel, as the published textures and every photograph; small enough
/// to stay in the cache. Rows go downwards from v = 0.
///
/// The values are linear or gamma-encoded; the caller knows which.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Every texel and the one below it, each red, green, blue and zero in the bytes of an integer,
    /// so that the four texels of a bilinear lookup are adjacent. The image has a border of the
    /// texels from its other side.
    codes: Plane<[i32; 2]>,
}

impl Texture {
    /// Rounds an image in [0, 1] to eight bits.
    ///
    /// # Panics
    /// If it is empty.
    pub fn from_plane(image: &Plane<Vec3A>) -> Self {
        assert!(!image.data().is_empty(), "a texture without texels");
        let mut codes = Plane::filled(image.width(), image.height(), [0; 4]);
        for (code, rgb) in codes.data_mut().iter_mut().zip(image.data()) {
            // A cast to `u8` stops at its ends.
            let [r, g, b] = (*rgb * WHITE + 0.5).to_array().map(|c| c as u8);
            *code = [r, g, b, 0];
        }
        Self::bordered(&codes)
    }

    /// Takes eight-bit texels, row by row; `None` unless there are `width * height` of them.
    pub fn from_rgb8(width: usize, height: usize, rgb: &[u8]) -> Option<Self> {
        let (texels, rest) = rgb.as_chunks::<3>();
        let codes = texels.iter().map(|&[r, g, b]| [r, g, b, 0]).collect();
        let codes = Plane::from_vec(width, height, codes).ok()?;
        (rest.is_empty() && width * height > 0).then(|| Self::bordered(&codes))
    }

    pub(super) fn bordered(image: &Plane<[u8; 4]>) -> Self {
        let (width, height) = (image.width(), image.height());
        let mut codes = Plane::filled(width + 2, height + 2, [0; 2]);
        for y in 0..height + 2 {
            let (above, below) =
                (image.row((y + height - 1) % height), image.row((y + height) % height));
            for (x, code) in codes.row_mut(y).iter_mut().enumerate() {
                // Textures repeat: the border is the opposite side, so that interpolation need not
                // ask.
                let x = (x + width - 1) % width;
                *code = [above[x], below[x]].map(i32::from_le_bytes);
            }
        }
        Self { codes }
    }

    /// Width in texels, without the border.
    pub fn width(&self) -> usize {
        self.codes.width() - 2
    }

    /// Height in texels, without the border.
    pub fn height(&self) -> usize {
        self.codes.height() - 2
    }

    /// Red, green, blue and zero of a texel.
    pub(super) fn texel(&self, x: usize, y: usize) -> [u8; 4] {
        self.codes.at(x + 1, y + 1)[0].to_le_bytes()
    }

    /// Bilinear interpolation at `uv`, in [0, 1]; the image repeats with period 1.
    pub fn sample(&self, uv: Vec2) -> Vec3A {
        let (x, fx) = neighbours(uv.x, self.width() as f32);
        let (y, fy) = neighbours(uv.y, self.height() as f32);
        let ([left, left_below], [right, right_below]) =
            (*self.codes.at(x, y), *self.codes.at(x + 1, y));
        let above = decode(left).lerp(decode(right), fx);
        let below = decode(left_below).lerp(decode(right_below), fx);
        Vec3A::from_vec4(above.lerp(below, fy) * (1.0 / WHITE))
    }

    /// [`Self::sample`] at eight coordinates, channel by channel.
    #[inline(always)]
    pub(crate) fn sample_lanes<L: Lanes8>(&self, l: L, [u, v]: [L::F; 2]) -> [L::F; 3] {
        let (x, fx) = neighbours_lanes(l, u, self.width() as f32);
        let (y, fy) = neighbours_lanes(l, v, self.height() as f32);
        let stride = self.codes.width() as i32;
        let firsts = l.store_i(l.add_i(l.mul_i(y, l.splat_i(stride)), x));
        let codes = self.codes.data().as_flattened();
        // There is always a texel to the right: NaN was clamped into the image.
        let four = |k: usize| {
            let first = 2 * firsts[k] as usize;
            codes.get(first..first + 4).and_then(<[_]>::first_chunk).unwrap_or(&[0; 4])
        };
        // A texel is stored with the one below it: one load has all four neighbours.
        let (a, b, c, d) = (four(0), four(1), four(2), four(3));
        let [left, left_below, right, right_below] =
            l.gather_columns([a, b, c, d, four(4), four(5), four(6), four(7)]);
        let texels = [left, right, left_below, right_below];
        [
            channel::<L, 0>(l, texels, [fx, fy]),
            channel::<L, 8>(l, texels, [fx, fy]),
            channel::<L, 16>(l, texels, [fx, fy]),
        ]
    }
}

/// Bilinear interpolation of one channel at eight coordinates.
#[inline(always)]
fn channel<L: Lanes8, const SHIFT: i32>(l: L, texels: [L::I; 4], [fx, fy]: [L::F; 2]) -> L::F {
    let [left_above, above, left_below, below] = [
        code::<L, SHIFT>(l, texels[0]),
        code::<L, SHIFT>(l, texels[1]),
        code::<L, SHIFT>(l, texels[2]),
        code::<L, SHIFT>(l, texels[3]),
    ];
    let top = l.add(left_above, l.mul(l.sub(above, left_above), fx));
    let bottom = l.add(left_below, l.mul(l.sub(below, left_below), fx));
    l.mul(l.add(top, l.mul(l.sub(bottom, top), fy)), l.splat(1.0 / WHITE))
}

#[inline(always)]
fn code<L: Lanes8, const SHIFT: i32>(l: L, texels: L::I) -> L::F {
    l.to_f(l.and(l.shift_right::<SHIFT>(texels), l.splat_i(255)))
}

/// Four channels at once: as fast as one.
#[inline]
fn decode(texel: i32) -> Vec4 {
    let [r, g, b, a] = texel.to_le_bytes();
    Vec4::new(f32::from(r), f32::from(g), f32::from(b), f32::from(a))
}

/// The first of the two texels around a coordinate, counted with the border, and the weight of the
/// second. Texel centres lie at half-integers.
fn neighbours(coordinate: f32, texels: f32) -> (usize, f32) {
    // Shifted by one texel, so that the position is not negative. The order of `max` and `min` maps
    // NaN to 0.
    let position = (coordinate - coordinate.floor()) * texels + 0.5;
    let position = position.max(0.0).min(texels + 0.5);
    let first = position.floor();
    (first as usize, position - first)
}

/// [`neighbours`] of eight coordinates.
#[inline(always)]
fn neighbours_lanes<L: Lanes8>(l: L, coordinate: L::F, texels: f32) -> (L::I, L::F) {
    let inside = l.sub(coordinate, l.floor(coordinate));
    let position = l.add(l.mul(inside, l.splat(texels)), l.splat(0.5));
    let position = l.min(l.max(position, l.splat(0.0)), l.splat(texels + 0.5));
    let first = l.floor(position);
    (l.to_i(first), l.sub(position, first))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker() -> Texture {
        Texture::from_rgb8(2, 1, &[0, 0, 0, 255, 51, 102]).unwrap()
    }

    #[test]
    fn texel_centres_return_the_texel() {
        let texture = checker();
        assert_eq!(texture.sample(Vec2::new(0.25, 0.5)), Vec3A::ZERO);
        let second = texture.sample(Vec2::new(0.75, 0.5));
        assert!((second - Vec3A::new(1.0, 0.2, 0.4)).length() < 1e-6);
    }

    #[test]
    fn between_centres_the_colour_is_linear_and_repeats() {
        let texture = checker();
        for (u, want) in [(0.375, 0.25), (0.5, 0.5), (0.0, 0.5), (1.0, 0.5), (-0.125, 0.75)] {
            let got = texture.sample(Vec2::new(u, 0.3)).x;
            assert!((got - want).abs() < 1e-6, "{u}: {got}");
            let far = texture.sample(Vec2::new(u + 7.0, -3.7)).x;
            assert!((far - want).abs() < 1e-5, "{u}: {far}");
        }
    }

    #[test]
    fn the_wrong_number_of_texels_is_refused() {
        assert_eq!(Texture::from_rgb8(2, 2, &[0; 9]), None);
        assert_eq!(Texture::from_rgb8(1, 1, &[0; 4]), None);
        assert_eq!(Texture::from_rgb8(0, 0, &[]), None);
    }
}
