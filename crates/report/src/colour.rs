//! Colours of charts and images.

/// Red, green, blue.
pub type Colour = (u8, u8, u8);

/// Colour of ON events.
pub const ON: Colour = (30, 100, 200);
/// Colour of OFF events.
pub const OFF: Colour = (200, 50, 60);
pub(crate) const INK: Colour = (29, 36, 48);
/// Colour of text of less weight.
pub(crate) const SOFT_INK: Colour = (93, 102, 117);
pub(crate) const GRID: Colour = (232, 232, 236);

/// Colours of curves, distinguishable by colour-blind readers.
///
/// # Source
/// Okabe and Ito: *Color universal design*, 2008.
pub const PALETTE: [Colour; 6] =
    [(0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (120, 120, 120), (86, 180, 233)];

/// The colour of a curve by its index; colours repeat behind the last.
#[must_use]
pub fn palette(index: usize) -> Colour {
    PALETTE[index % PALETTE.len()]
}

/// A colour as CSS.
#[must_use]
pub fn css((r, g, b): Colour) -> String {
    format!("rgb({r},{g},{b})")
}

/// The colour at `share` of the way from one colour to another.
#[must_use]
pub fn mix(from: Colour, to: Colour, share: f64) -> Colour {
    let channel = |a: u8, b: u8| {
        (f64::from(a) + (f64::from(b) - f64::from(a)) * share.clamp(0.0, 1.0)).round() as u8
    };
    (channel(from.0, to.0), channel(from.1, to.1), channel(from.2, to.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_ends_at_both_colours() {
        assert_eq!(mix(ON, OFF, 0.0), ON);
        assert_eq!(mix(ON, OFF, 1.0), OFF);
        assert_eq!(mix((0, 0, 0), (255, 101, 3), 0.5), (128, 51, 2));
    }
}
