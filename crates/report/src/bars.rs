//! Horizontal bars with intervals, as SVG.

use plotters::style::text_anchor::HPos;

use crate::colour::{Colour, GRID, INK, SOFT_INK};
use crate::drawing::{Area, DrawingError, Words, document, fill, line};
use crate::format::short;

/// Height of a bar, pixels.
pub(crate) const BAR: f64 = 13.0;
/// Room above a group.
pub(crate) const ROOM: f64 = 7.0;
/// Height of the axis and its name.
pub(crate) const FOOT: f64 = 34.0;
/// Width of a letter of a label, about, pixels.
pub(crate) const LETTER: f64 = 6.6;
/// Font size, pixels.
const TEXT_PX: f64 = 12.0;
/// Space above the first bar, for the name of the marked value, pixels.
pub(crate) const TOP: f64 = 12.0;
/// Length of a dash and of the space behind it, pixels.
const DASH: (f64, f64) = (4.0, 3.0);

/// One bar.
pub struct Bar {
    /// On the left; empty for another bar of the same group.
    pub label: String,
    /// Length of the bar, in the unit of the axis.
    pub value: f64,
    /// An interval around the value.
    pub interval: Option<(f64, f64)>,
    /// Colour of the bar.
    pub colour: Colour,
    /// Behind the bar.
    pub note: String,
}

/// The axis along bars.
#[derive(Clone, Copy)]
pub struct Along<'a> {
    /// Label of the axis.
    pub name: &'a str,
    /// Lowest and highest value.
    pub range: (f64, f64),
    /// Whether the scale is logarithmic.
    pub is_log: bool,
    /// A line across all bars, and what it is.
    pub mark: Option<(f64, &'a str)>,
    /// Room for labels, at least, and for notes, pixels.
    pub labels: f64,
    /// Width of the column of notes, in pixels.
    pub notes: f64,
    /// Length of the axis, pixels.
    pub length: f64,
}

impl Along<'_> {
    /// A gap, on a logarithmic axis that begins below one.
    pub fn gap(largest: f64) -> Self {
        Self {
            name: "gap",
            range: (0.7, largest.max(3.0) * 1.15),
            is_log: true,
            mark: Some((1.0, "no gap")),
            labels: 225.0,
            notes: 120.0,
            length: 440.0,
        }
    }

    /// Shares of a whole.
    pub fn shares() -> Self {
        Self {
            name: "",
            range: (0.0, 1.0),
            is_log: false,
            mark: None,
            labels: 120.0,
            notes: 50.0,
            length: 240.0,
        }
    }

    /// Pixels from the left.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        let share = match self.is_log {
            // The logarithm of zero would lie infinitely far to the left.
            true => (value.max(1e-9) / low).ln() / (high / low).ln(),
            false => (value - low) / (high - low),
        };
        self.labels + share.clamp(0.0, 1.0) * self.length
    }

    fn ticks(&self) -> Vec<f64> {
        let (low, high) = self.range;
        let inside = |tick: &f64| (low..=high).contains(tick);
        if self.is_log {
            let ticks: Vec<f64> = (-3..9)
                .flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)))
                .filter(inside)
                .collect();
            let step = ticks.len().div_ceil(9).max(1);
            // However many ticks are skipped, 1 keeps its own: it is where a gap ends.
            let from_one = ticks.iter().position(|tick| (tick - 1.0).abs() < 1e-9).unwrap_or(0);
            return ticks.into_iter().skip(from_one % step).step_by(step).collect();
        }
        // The least of 1, 2, 5 times a power of ten that gives no more than six.
        let rough = (high - low) / 6.0;
        let power = 10f64.powf(rough.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
        let step = steps.into_iter().find(|step| *step >= rough).unwrap_or(rough);
        (0..8).map(|i| (low / step).ceil() * step + f64::from(i) * step).filter(inside).collect()
    }
}

/// Draws bars one below the other.
///
/// # Errors
/// If the SVG backend fails.
pub fn svg(bars: &[Bar], along: &Along<'_>) -> Result<String, DrawingError> {
    let longest = bars.iter().map(|bar| bar.label.chars().count()).max().unwrap_or(0);
    let along = &Along { labels: along.labels.max(LETTER * longest as f64 + 10.0), ..*along };
    let groups = bars.iter().filter(|bar| !bar.label.is_empty()).count();
    let bottom = bars.len() as f64 * BAR + groups as f64 * ROOM + TOP + 4.0;
    let width = along.labels + along.length + along.notes;
    let height = bottom + if along.name.is_empty() { 4.0 } else { FOOT };
    document((width.ceil() as u32, height.ceil() as u32), |area| {
        // The axis takes room only where it has a name.
        if !along.name.is_empty() {
            draw_axis(area, along, bottom)?;
        }
        // The mark lies under bars and text.
        if let Some((value, name)) = along.mark {
            draw_mark(area, along.place(value), bottom)?;
            text(name, HPos::Center, INK).draw(area, (along.place(value), 0.5 * TOP - 1.0))?;
        }
        let mut y = TOP;
        for bar in bars {
            if !bar.label.is_empty() {
                y += ROOM;
            }
            draw_bar(area, along, bar, y)?;
            y += BAR;
        }
        Ok(())
    })
}

/// Draws the grid lines of the axis down to `bottom`, their values, and the name of the axis.
pub(crate) fn draw_axis(
    area: &Area<'_>,
    along: &Along<'_>,
    bottom: f64,
) -> Result<(), DrawingError> {
    for tick in along.ticks() {
        let x = along.place(tick);
        line(area, (x, TOP), (x, bottom), GRID)?;
        text(&short(tick), HPos::Center, SOFT_INK).draw(area, (x, bottom + 9.0))?;
    }
    let middle = along.labels + along.length / 2.0;
    text(along.name, HPos::Center, SOFT_INK).draw(area, (middle, bottom + 24.0))
}

/// A dashed line across all bars.
fn draw_mark(area: &Area<'_>, x: f64, bottom: f64) -> Result<(), DrawingError> {
    let mut y = TOP;
    while y < bottom {
        line(area, (x, y), (x, (y + DASH.0).min(bottom)), INK)?;
        y += DASH.0 + DASH.1;
    }
    Ok(())
}

fn draw_bar(area: &Area<'_>, along: &Along<'_>, bar: &Bar, y: f64) -> Result<(), DrawingError> {
    let middle = y + (BAR - 2.0) / 2.0;
    text(&bar.label, HPos::Right, INK).draw(area, (along.labels - 8.0, middle))?;
    let (from, to) = (along.place(along.range.0), along.place(bar.value));
    // A value of zero still shows a line.
    fill(area, (from, y), (to.max(from + 1.0), y + BAR - 2.0), bar.colour)?;
    // The note stands behind the interval, which may reach further than the bar.
    let mut end = to;
    if let Some((low, high)) = bar.interval {
        let (a, b) = (along.place(low), along.place(high));
        end = end.max(b);
        line(area, (a, middle), (b, middle), INK)?;
        for x in [a, b] {
            line(area, (x, middle - 3.0), (x, middle + 3.0), INK)?;
        }
    }
    text(&bar.note, HPos::Left, SOFT_INK).draw(area, (end + 6.0, middle))
}

/// Text of a chart of bars.
pub(crate) fn text(text: &str, anchor: HPos, colour: Colour) -> Words<'_> {
    Words::new(text, TEXT_PX, colour, anchor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_notes_and_the_mark_are_in_the_document() -> Result<(), DrawingError> {
        let bar = Bar {
            label: "a & b".to_owned(),
            value: 2.0,
            interval: Some((1.0, 3.0)),
            colour: (1, 2, 3),
            note: "2 of 3".to_owned(),
        };
        let svg = svg(&[bar], &Along::gap(3.0))?;
        for text in ["a &amp; b", "2 of 3", "no gap", "#010203"] {
            assert!(svg.contains(text), "{text}");
        }
        Ok(())
    }

    #[test]
    fn ticks_of_a_linear_axis_are_round() {
        let along = Along { name: "share", ..Along::shares() };
        assert_eq!(along.ticks(), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
    }
}
