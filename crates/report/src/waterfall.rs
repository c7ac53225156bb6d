//! Waterfall chart: a total, the parts that are taken from it one by one, and what is left, as SVG.

use plotters::style::text_anchor::HPos;

use crate::bars::{Along, BAR, FOOT, LETTER, ROOM, TOP, draw_axis, text};
use crate::colour::{Colour, INK, SOFT_INK};
use crate::drawing::{DrawingError, document, fill, line};

/// One step: a bar between two levels.
#[derive(Debug, Clone, PartialEq)]
pub struct WaterfallStep {
    /// On the left.
    pub label: String,
    /// Level at which the bar begins, in the unit of the axis; zero for a total.
    pub from: f64,
    /// Level at which it ends, which is where the next one is attached.
    pub to: f64,
    /// Colour of the bar.
    pub colour: Colour,
    /// Behind the bar.
    pub note: String,
}

/// Draws steps one below the other, each attached to the end of the one before.
///
/// # Errors
/// If the SVG backend fails.
pub fn svg(steps: &[WaterfallStep], along: &Along<'_>) -> Result<String, DrawingError> {
    // The backend measures no text: its width follows from that of a letter.
    let longest = steps.iter().map(|step| step.label.chars().count()).max().unwrap_or(0);
    let along = &Along { labels: along.labels.max(LETTER * longest as f64 + 10.0), ..*along };
    let bottom = TOP + steps.len() as f64 * (BAR + ROOM) + 4.0;
    let size = (along.labels + along.length + along.notes, bottom + FOOT);
    document((size.0.ceil() as u32, size.1.ceil() as u32), |area| {
        draw_axis(area, along, bottom)?;
        for (i, step) in steps.iter().enumerate() {
            let y = TOP + ROOM + i as f64 * (BAR + ROOM);
            let middle = y + 0.5 * (BAR - 2.0);
            text(&step.label, HPos::Right, INK).draw(area, (along.labels - 8.0, middle))?;
            let (from, to) = (along.place(step.from), along.place(step.to));
            // At least a pixel wide: a step of nothing is a line.
            let (left, right) = (from.min(to), from.max(to).max(from.min(to) + 1.0));
            fill(area, (left, y), (right, y + BAR - 2.0), step.colour)?;
            if i + 1 < steps.len() {
                line(area, (to, y + BAR - 2.0), (to, y + BAR + ROOM), SOFT_INK)?;
            }
            text(&step.note, HPos::Left, SOFT_INK).draw(area, (right + 6.0, middle))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_is_attached_to_the_one_before() -> Result<(), DrawingError> {
        let step = |label: &str, from, to, colour| WaterfallStep {
            label: label.to_owned(),
            from,
            to,
            colour,
            note: format!("from {from} to {to}"),
        };
        let steps = [
            step("as given", 0.0, 1.0, (1, 1, 1)),
            step("a & b", 1.0, 0.25, (2, 2, 2)),
            step("left", 0.0, 0.25, (3, 3, 3)),
        ];
        let along = Along { name: "fraction", labels: 100.0, length: 400.0, ..Along::shares() };
        let svg = svg(&steps, &along)?;
        for text in ["as given", "a &amp; b", "from 1 to 0.25", "fraction"] {
            assert!(svg.contains(text), "{text}");
        }
        // The whole is 400 pixels long, the part three quarters of it, and what is left the rest.
        for (colour, x, width) in
            [("#010101", 100, 400), ("#020202", 200, 300), ("#030303", 100, 100)]
        {
            let bar = svg.split('<').find(|tag| tag.starts_with("rect") && tag.contains(colour));
            let bar = bar.unwrap();
            assert!(bar.contains(&format!("x=\"{x}\"")), "{bar}");
            assert!(bar.contains(&format!("width=\"{width}\"")), "{bar}");
        }
        Ok(())
    }
}
