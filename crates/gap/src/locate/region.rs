//! Regions of light, motion, image and time in which a model has too few or too many events.

use serde::{Deserialize, Serialize};

use super::axis::{self, Axis, TILES, TIMES};
use super::table::{Sample, tile};
use crate::View;

/// Standard deviations to either end of a 90 % interval.
const Z90: f64 = 1.645;

/// A box of classes with more or fewer measured than simulated events.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Description as a sentence.
    pub sentence: String,
    /// Number of measured events.
    pub measured: f64,
    /// Mean number of events over runs of the model.
    pub expected: f64,
    /// Measured over expected; expected is at least half an event over all runs.
    pub ratio: f64,
    /// Lower end of the ratio's 90 % interval.
    pub lo90: f64,
    /// Upper end.
    pub hi90: f64,
    /// Log-likelihood ratio against a correct model.
    pub score: f64,
    /// p-value of the score over all regions searched.
    pub p: f64,
}

/// Sums of events over the classes of a box.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Sums {
    pub(super) events: f64,
    pub(super) runs: f64,
}

impl Sums {
    /// Log-likelihood ratio of two Poisson rates against a common one: Kulldorff's statistic with
    /// an expected count that is itself sampled from `runs` runs.
    pub(super) fn score(self, runs: f64) -> f64 {
        let all = self.events + self.runs;
        let term = |count: f64, share: f64| {
            if count > 0.0 { count * (count / (all * share)).ln() } else { 0.0 }
        };
        term(self.events, 1.0 / (runs + 1.0)) + term(self.runs, runs / (runs + 1.0))
    }
}

impl Region {
    /// Describes the box `levels` of a sample.
    pub(super) fn new(
        levels: u64,
        (keys, sample): (&[u64], &Sample),
        view: &View<'_>,
        (score, p): (f64, f64),
    ) -> Self {
        let mut sums = Sums::default();
        let mut groups = [Sums::default(); TILES.0 * TILES.1 * TIMES];
        for (i, key) in keys.iter().enumerate().filter(|(_, key)| *key & !levels == 0) {
            let group = &mut groups[tile(*key) * TIMES + Axis::Time.level(*key)];
            for sums in [&mut sums, group] {
                sums.events += sample.events[i];
                sums.runs += sample.sums[i];
            }
        }
        let floored = sums.runs.max(0.5);
        let expected = floored / sample.runs;
        let ratio = sums.events.max(0.5) / expected;
        // Events of one edge come in groups: the scatter between tiles and times includes that, and
        // the variance of independent events is a lower bound.
        let filled = groups.iter().filter(|g| g.events + g.runs > 0.0).count() as f64;
        let off = |g: &Sums| g.events - ratio * g.runs / sample.runs;
        let scatter: f64 = groups.iter().map(|g| off(g).powi(2)).sum();
        let between = if filled > 1.0 { scatter * filled / (filled - 1.0) } else { 0.0 };
        let relative = between / sums.events.max(0.5).powi(2);
        let sd = relative.max(1.0 / sums.events.max(0.5) + 1.0 / floored).sqrt();
        let (lo90, hi90) = (ratio * (-Z90 * sd).exp(), ratio * (Z90 * sd).exp());
        let (measured, expected) = (sums.events, sums.runs / sample.runs);
        let mut region =
            Self { sentence: String::new(), measured, expected, ratio, lo90, hi90, score, p };
        region.sentence = region.describe(levels, view);
        region
    }

    fn describe(&self, levels: u64, view: &View<'_>) -> String {
        let of = |axis: Axis| (levels & axis.bits()) >> axis.shift();
        let sign = of(Axis::Sign);
        let polarity = axis::polarity(sign);
        // A ratio to nothing is no number that a reader can use.
        let head = if self.expected < 0.5 {
            format!("Unmodelled {polarity}events")
        } else if self.ratio > 1.0 {
            format!("Excess x{} of {polarity}events", self.interval())
        } else {
            format!("Deficit x{} of {polarity}events", self.interval())
        };
        let parts = [
            axis::motion(of(Axis::Motion), sign),
            axis::brightness(of(Axis::Brightness)),
            axis::contrast(of(Axis::Contrast)),
            axis::interval(of(Axis::Interval)),
            place(of(Axis::Column), of(Axis::Row), view),
            time(of(Axis::Time), view),
        ];
        let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        format!(
            "{head} {}: {:.0} measured, {} expected",
            parts.join(", "),
            self.measured,
            short(self.expected)
        )
    }

    fn interval(&self) -> String {
        format!("{} [{}, {}]", short(self.ratio), short(self.lo90), short(self.hi90))
    }
}

/// Formats with two significant digits, and whole values from ten on.
fn short(value: f64) -> String {
    match value.abs() {
        v if v >= 9.95 => format!("{value:.0}"),
        v if v >= 0.995 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

fn place(columns: u64, rows: u64, view: &View<'_>) -> String {
    let pixels = |levels: u64, count: usize, size: u16| {
        let (from, to) = axis::ends(levels);
        // The first pixel whose level, `pixel * count / size`, is this one.
        let at = |level: usize| (level * usize::from(size)).div_ceil(count);
        ((from, to) != (0, count)).then(|| format!("{}-{}", at(from), at(to) - 1))
    };
    let size = view.size();
    match (pixels(columns, TILES.0, size.width), pixels(rows, TILES.1, size.height)) {
        (None, None) => "everywhere in the image".to_owned(),
        (Some(x), None) => format!("in columns {x}"),
        (None, Some(y)) => format!("in rows {y}"),
        (Some(x), Some(y)) => format!("in columns {x} of rows {y}"),
    }
}

fn time(levels: u64, view: &View<'_>) -> String {
    let (from, to) = axis::ends(levels);
    if (from, to) == (0, TIMES) {
        return String::new();
    }
    let at = |level: usize| {
        view.window.start.as_seconds() + view.seconds() * level as f64 / TIMES as f64
    };
    format!("from {:.2} s to {:.2} s", at(from), at(to))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_model_scores_nothing_and_a_wrong_one_what_the_formula_says() {
        assert!(Sums { events: 30.0, runs: 120.0 }.score(4.0).abs() < 1e-12);
        // Ten events where four runs have none: each was one of five equally likely streams.
        let score = Sums { events: 10.0, runs: 0.0 }.score(4.0);
        assert!((score - 10.0 * 5f64.ln()).abs() < 1e-12, "{score}");
    }
}
