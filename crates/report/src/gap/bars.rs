//! Horizontal bars with intervals, as SVG.

use std::fmt::Write as _;

use super::css;
use crate::gap::words::short;
use crate::html::escape;

/// Height of a bar and of the room between groups, pixels.
const BAR: f64 = 13.0;
const ROOM: f64 = 7.0;
const FOOT: f64 = 34.0;
/// Width of a letter of a label, about, pixels.
const LETTER: f64 = 6.6;

/// One bar.
pub struct Bar {
    /// On the left; empty for another bar of the same group.
    pub label: String,
    /// Length of the bar, in the unit of the axis.
    pub value: f64,
    /// An interval around the value.
    pub interval: Option<(f64, f64)>,
    /// Red, green, blue.
    pub colour: (u8, u8, u8),
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

    fn place(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        let share = match self.is_log {
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
pub fn svg(bars: &[Bar], along: &Along<'_>) -> String {
    let longest = bars.iter().map(|bar| bar.label.chars().count()).max().unwrap_or(0);
    let along = &Along { labels: along.labels.max(LETTER * longest as f64 + 10.0), ..*along };
    let groups = bars.iter().filter(|bar| !bar.label.is_empty()).count();
    let bottom = bars.len() as f64 * BAR + groups as f64 * ROOM + 16.0;
    let width = along.labels + along.length + along.notes;
    let height = bottom + if along.name.is_empty() { 4.0 } else { FOOT };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         width=\"{width:.0}\" height=\"{height:.0}\" font-size=\"12\">"
    );
    // Words are above bars and lines.
    let mut above = String::new();
    let text = |x: f64, y: f64, anchor: &str, colour: &str, words: &str| {
        format!(
            "<text class=\"halo\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{}</text>",
            escape(words)
        )
    };
    if !along.name.is_empty() {
        for tick in along.ticks() {
            let x = along.place(tick);
            let _ = write!(
                svg,
                "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"12\" y2=\"{bottom:.1}\" stroke=\"#e8e9ee\"/>"
            );
            above += &text(x, bottom + 13.0, "middle", "#5d6675", &short(tick));
        }
        let middle = along.labels + along.length / 2.0;
        above += &text(middle, bottom + 28.0, "middle", "#5d6675", along.name);
    }
    let mut y = 12.0;
    for bar in bars {
        if !bar.label.is_empty() {
            y += ROOM;
            above += &text(along.labels - 8.0, y + BAR - 3.0, "end", "#1d2430", &bar.label);
        }
        let (from, to) = (along.place(along.range.0), along.place(bar.value));
        let (colour, middle) = (css(bar.colour), y + (BAR - 2.0) / 2.0);
        let _ = write!(
            svg,
            "<rect x=\"{from:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\"/>",
            (to - from).max(1.0),
            BAR - 2.0
        );
        let mut end = to;
        if let Some((low, high)) = bar.interval {
            let (a, b) = (along.place(low), along.place(high));
            end = end.max(b);
            let _ = write!(
                svg,
                "<path d=\"M{a:.1} {middle:.1}H{b:.1}M{a:.1} {0:.1}v6M{b:.1} {0:.1}v6\" \
                 stroke=\"#1d2430\" fill=\"none\"/>",
                middle - 3.0
            );
        }
        above += &text(end + 6.0, y + BAR - 3.0, "start", "#5d6675", &bar.note);
        y += BAR;
    }
    if let Some((value, name)) = along.mark {
        let x = along.place(value);
        let _ = write!(
            svg,
            "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"12\" y2=\"{bottom:.1}\" stroke=\"#1d2430\" \
             stroke-dasharray=\"4 3\"/>"
        );
        above += &text(x, 9.0, "middle", "#1d2430", name);
    }
    svg + &above + "</svg>"
}
