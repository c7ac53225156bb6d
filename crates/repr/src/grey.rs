//! Planes as grey images of 8 bits.

/// Mapping of the values of a plane to 8 bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Grey {
    /// 0 is black and this value white; beyond is white as well.
    White(f32),
    /// 0 is black and the largest value white.
    Largest,
    /// 0 is grey; of the values furthest from it, negative ones are black, positive ones white.
    Signed,
}

impl Grey {
    /// Writes `planes` as grey values.
    ///
    /// [`Signed`](Self::Signed) is `255·(v / (2·max|v|) + 1/2)` without its fraction, as the
    /// published program shows polarity-integrated images (0 is 127); the others are rounded to
    /// nearest, halves to even, as OpenCV converts to 8 bits.
    ///
    /// # Panics
    /// If the two differ in length.
    pub fn write(self, planes: &[f32], out: &mut [u8]) {
        assert_eq!(planes.len(), out.len(), "planes of another size");
        let white = match self {
            Self::White(white) => white,
            Self::Largest => planes.iter().fold(0.0, |most, &value| value.max(most)),
            Self::Signed => return write_signed(planes, out),
        };
        // Nothing but black is left where nothing is above 0.
        let scale = if white > 0.0 { 255.0 / white } else { 0.0 };
        for (out, &value) in out.iter_mut().zip(planes) {
            // A conversion to integers saturates.
            *out = (value * scale).round_ties_even() as u8;
        }
    }
}

fn write_signed(planes: &[f32], out: &mut [u8]) {
    let most = planes.iter().fold(0.0f32, |most, &value| value.abs().max(most));
    let scale = if most > 0.0 { 1.0 / (2.0 * f64::from(most)) } else { 0.0 };
    for (out, &value) in out.iter_mut().zip(planes) {
        *out = ((f64::from(value) * scale + 0.5) * 255.0) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(grey: Grey, planes: &[f32]) -> Vec<u8> {
        let mut out = vec![7; planes.len()];
        grey.write(planes, &mut out);
        out
    }

    #[test]
    fn halves_are_rounded_to_even_and_what_is_beyond_is_saturated() {
        let planes = [-3.0, 0.4, 0.5, 1.5, 2.5, 254.6, 255.0, 300.0];
        assert_eq!(grey(Grey::White(255.0), &planes), [0, 0, 0, 2, 2, 255, 255, 255]);
        assert_eq!(grey(Grey::White(1.0), &[0.0, 0.25, 1.0, 2.0]), [0, 64, 255, 255]);
    }

    #[test]
    fn the_largest_is_white_and_an_empty_plane_black() {
        assert_eq!(grey(Grey::Largest, &[0.0, 1.0, 5.0]), [0, 51, 255]);
        assert_eq!(grey(Grey::Largest, &[0.0, -1.0]), [0, 0]);
    }

    #[test]
    fn zero_is_grey_where_values_have_a_sign() {
        assert_eq!(grey(Grey::Signed, &[0.0, -4.0, 4.0, 2.0]), [127, 0, 255, 191]);
        assert_eq!(grey(Grey::Signed, &[0.0, 0.0]), [127, 127]);
    }
}
