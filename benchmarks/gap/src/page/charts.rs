//! The charts of the page.

use std::collections::BTreeMap;

use crate::opened::Opened;
use crate::own::OwnRow;
use crate::score::{Estimate, Power};
use crate::stats::{Bin, Rate};
use evpose_report::bars::{self, Along, Bar};
use evpose_report::chart::{self, Chart, ChartAxis, Mark, Series};
use evpose_report::colour::{Colour, PALETTE};
use evpose_report::drawing::DrawingError;

/// Colours of results, of targets, and of the background.
const FOUND: Colour = PALETTE[0];
const AIM: Colour = PALETTE[4];
const AROUND: Colour = PALETTE[5];
const CHANCE: Colour = (190, 195, 204);
/// Sizes in pixels.
const SMALL: (u32, u32) = (218, 178);
const SQUARE: (u32, u32) = (430, 400);
const WIDE: (u32, u32) = (560, 300);
const BINS: usize = 24;

fn series(label: &str, colour: Colour, mark: Mark, points: Vec<(f64, f64)>) -> Series {
    Series { label: label.to_owned(), colour, mark, points }
}

fn shares(x: &[f64], rates: &[Rate]) -> [Series; 2] {
    let low = x.iter().zip(rates).map(|(x, rate)| (*x, rate.lo95));
    let high = x.iter().zip(rates).rev().map(|(x, rate)| (*x, rate.hi95));
    let middle = x.iter().zip(rates).filter_map(|(x, rate)| Some((*x, rate.share?)));
    [
        series("", AROUND, Mark::Band, low.chain(high).collect()),
        series("", FOUND, Mark::Line, middle.collect()),
    ]
}

pub(super) fn power(power: &[Power]) -> Result<Vec<String>, DrawingError> {
    let of_effect = |of: &[Power]| {
        let x: Vec<f64> = of.iter().map(|power| power.strength as f64).collect();
        let rates: Vec<Rate> = of.iter().map(|power| power.right).collect();
        let seen: Vec<String> = of.iter().map(|power| power.visible.to_string()).collect();
        let chart = Chart {
            title: of.first().map_or("", |power| power.effect).to_owned(),
            x: ChartAxis::new(&format!("strength (seen in {})", seen.join(", ")))
                .over(0.0, 3.0)
                .whole(),
            y: ChartAxis::new("").over(0.0, 1.0),
            series: shares(&x, &rates).into(),
        };
        chart::svg(&chart, SMALL)
    };
    // Sorted by effect, so that neighbours of one effect are all of it.
    power.chunk_by(|a, b| a.effect == b.effect).map(of_effect).collect()
}

pub(super) fn reliability(bins: &[Bin]) -> Result<String, DrawingError> {
    // On the diagonal, stated probabilities hold.
    let mut all = vec![series("", AIM, Mark::Line, vec![(0.0, 0.0), (1.0, 1.0)])];
    let x: Vec<f64> = bins.iter().map(|bin| bin.stated).collect();
    let rates: Vec<Rate> = bins.iter().map(|bin| bin.right).collect();
    all.extend(shares(&x, &rates));
    for bin in bins {
        let interval = vec![(bin.stated, bin.right.lo95), (bin.stated, bin.right.hi95)];
        all.push(series("", FOUND, Mark::Line, interval));
    }
    let chart = Chart {
        title: String::new(),
        x: ChartAxis::new("stated probability").over(0.0, 1.0),
        y: ChartAxis::new("share that is right").over(0.0, 1.0),
        series: all,
    };
    chart::svg(&chart, SQUARE)
}

/// Probabilities of recordings of our own model against uniform ones.
pub(super) fn quantiles(own: &[OwnRow]) -> Result<String, DrawingError> {
    let mut ps: Vec<f64> = own.iter().map(|row| row.p).collect();
    ps.sort_by(f64::total_cmp);
    let n = ps.len() as f64;
    let at = |i: usize| (i as f64 + 0.5) / n;
    // Where order statistics of a uniform sample are, as normal deviations about their mean.
    let side = |i: usize| 1.96 * (at(i) * (1.0 - at(i)) / n).sqrt();
    let low = (0..ps.len()).map(|i| (at(i), (at(i) - side(i)).max(0.0)));
    let high = (0..ps.len()).rev().map(|i| (at(i), (at(i) + side(i)).min(1.0)));
    let chart = Chart {
        title: String::new(),
        x: ChartAxis::new("uniform").over(0.0, 1.0),
        y: ChartAxis::new("found").over(0.0, 1.0),
        series: vec![
            series("", CHANCE, Mark::Band, low.chain(high).collect()),
            series("", AIM, Mark::Line, vec![(0.0, 0.0), (1.0, 1.0)]),
            series(
                "",
                FOUND,
                Mark::Steps,
                ps.iter().enumerate().map(|(i, p)| (at(i), *p)).collect(),
            ),
        ],
    };
    chart::svg(&chart, SQUARE)
}

/// Coverage of the intervals of 90 %, a bar a finding.
pub(super) fn coverage(coverage: &BTreeMap<String, Rate>) -> Result<String, DrawingError> {
    let bar = |(name, rate): (&String, &Rate)| Bar {
        label: name.clone(),
        value: rate.share.unwrap_or(0.0),
        interval: Some((rate.lo95, rate.hi95)),
        colour: AROUND,
        note: format!("{}/{}", rate.of, rate.n),
    };
    let along = Along { mark: Some((0.9, "90 %")), notes: 60.0, length: 280.0, ..Along::shares() };
    bars::svg(&coverage.iter().map(bar).collect::<Vec<_>>(), &along)
}

/// Relative errors of estimates, as a histogram on a logarithmic axis.
pub(super) fn errors(estimates: &[Estimate]) -> Result<String, DrawingError> {
    let errors: Vec<f64> =
        estimates.iter().filter_map(Estimate::error).map(|e| e.max(1e-4)).collect();
    let logs: Vec<f64> = errors.iter().map(|error| error.log10()).collect();
    let steps = histogram(&logs, -4.0, 1.0).into_iter().map(|(x, n)| (10f64.powf(x), n)).collect();
    let chart = Chart {
        title: "Relative error of estimates".to_owned(),
        x: ChartAxis::log("relative error; 1e-4 stands for less").over(1e-4, 10.0),
        y: ChartAxis::new("estimates"),
        series: vec![series("", FOUND, Mark::Steps, steps)],
    };
    chart::svg(&chart, (430, 300))
}

pub(super) fn times(opened: &[Opened]) -> Result<String, DrawingError> {
    let times =
        |seconds: &dyn Fn(&Opened) -> f64| -> Vec<f64> { opened.iter().map(seconds).collect() };
    let (all, naming) = (times(&|case| case.row.seconds()), times(&|case| case.row.name_s));
    // At least 26 s, so that plots of fast runs can be compared.
    let most = all.iter().copied().fold(26.0, f64::max);
    let chart = Chart {
        title: String::new(),
        x: ChartAxis::new("seconds").over(0.0, most),
        y: ChartAxis::new("cases"),
        series: vec![
            series("naming alone", CHANCE, Mark::Steps, histogram(&naming, 0.0, most)),
            series("with its files", FOUND, Mark::Steps, histogram(&all, 0.0, most)),
        ],
    };
    chart::svg(&chart, WIDE)
}

/// Corners of a histogram of steps; what is outside counts at the ends.
fn histogram(values: &[f64], low: f64, high: f64) -> Vec<(f64, f64)> {
    let mut counts = [0.0; BINS];
    let width = (high - low) / BINS as f64;
    for value in values {
        counts[(((value - low) / width).max(0.0) as usize).min(BINS - 1)] += 1.0;
    }
    let edge = |i: usize| low + width * i as f64;
    let steps = counts.iter().enumerate().map(|(i, n)| (edge(i), *n));
    std::iter::once((low, 0.0)).chain(steps).chain([(high, 0.0)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_counts_every_value_once() {
        let values: Vec<f64> = (-10..200).map(|i| 0.1 * f64::from(i)).collect();
        let corners = histogram(&values, 0.0, 12.0);
        let sum: f64 = corners.iter().map(|(_, n)| n).sum();
        assert!((sum - values.len() as f64).abs() < 1e-9);
        assert_eq!((corners[0], corners[corners.len() - 1]), ((0.0, 0.0), (12.0, 0.0)));
    }
}
