//! Response that would explain a disagreement: excess or deficit of events as a fitted function of
//! light, of its change, of the time since the pixel's last event, of time and of place.
//!
//! # Model
//! Along each property, per polarity, `d = measured - expected` is one of two things: events that are
//! added at a rate per pixel, `d = a g(x) exposure`, or a fraction of those that are expected,
//! `d = a g(x) expected`. The shape `g` is even, a power of the property, or a step. Of all of them
//! the one with the least Bayesian information criterion is taken (Schwarz 1978), fitted by least
//! squares with the variances of counts and of runs. Properties go together in a scene, so that
//! several of them may describe the same difference: the first describes most.

use evpose_core::stats::moments::mean_and_deviation;
use serde::{Deserialize, Serialize};

use super::property::{Bins, Property};
use crate::View;

/// Powers of a property that are tried beside the first.
const POWERS: [f64; 5] = [-2.0, -1.0, -0.5, 0.5, 2.0];
/// Decrease of chi-square from which a response is reported.
const MIN_GAIN: f64 = 25.0;
/// Tolerance as a fraction of a count.
const TOLERANCE: f64 = 0.01;
/// Responses that are reported at most.
const REPORTED: usize = 6;

/// Difference of events along one property, and the function that describes it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// Property that the events are ordered by.
    pub property: Property,
    /// Whether it is about ON events.
    pub is_on: bool,
    /// Difference in each bin of the property.
    pub points: Vec<ResponsePoint>,
    /// The fitted function.
    pub fit: ResponseFit,
    /// Fraction of the squared differences along this property that it explains.
    pub explained: f64,
    /// Decrease of chi-square.
    pub gain: f64,
}

/// Difference of events in one range of a property.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResponsePoint {
    /// Value of the property.
    pub x: f64,
    /// Difference in the unit of the fit: events per pixel and second, or the fraction of those
    /// expected; none where nothing is expected.
    pub difference: Option<f64>,
    /// The fitted function there.
    pub fitted: f64,
}

/// Fitted function of a response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResponseFit {
    /// Quantity of the amplitude.
    pub form: ResponseForm,
    /// Dependence on the property.
    pub shape: ResponseShape,
    /// Amplitude, and its standard error.
    pub amplitude: f64,
    /// Standard error of the amplitude.
    pub error: f64,
}

/// Quantity of the amplitude of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResponseForm {
    /// Events per pixel and second.
    Rate,
    /// A fraction of the events that are expected.
    Fraction,
}

/// Dependence on a property.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResponseShape {
    /// None.
    Even,
    /// A power of it, one at one unit.
    Power(f64),
    /// Even below a value, nothing above.
    Below(f64),
    /// Even above a value, nothing below.
    Above(f64),
}

impl ResponseShape {
    /// Value at `x`.
    pub fn at(self, x: f64) -> f64 {
        match self {
            Self::Even => 1.0,
            Self::Power(_) if x <= 0.0 => 0.0,
            Self::Power(power) => x.powf(power),
            Self::Below(limit) => f64::from(x < limit),
            Self::Above(limit) => f64::from(x >= limit),
        }
    }

    /// Number of parameters beside the amplitude.
    fn parameters(self) -> f64 {
        match self {
            Self::Even | Self::Power(1.0) => 0.0,
            _ => 1.0,
        }
    }

    /// All that are tried with bins at `x`.
    fn all(bins: &Bins) -> Vec<Self> {
        let mut all = vec![Self::Even];
        if bins.property.has_powers() {
            all.push(Self::Power(1.0));
            all.extend(POWERS.map(Self::Power));
        }
        all.extend(bins.edges.iter().flat_map(|edge| [Self::Below(*edge), Self::Above(*edge)]));
        all
    }
}

struct Differences<'a> {
    bins: &'a Bins,
    difference: Vec<f64>,
    expected: Vec<f64>,
    variance: Vec<f64>,
}

impl<'a> Differences<'a> {
    fn new(bins: &'a Bins, measured: &[f64], runs: &[Vec<f64>]) -> Self {
        let n = runs.len() as f64;
        let mut all =
            Self { bins, difference: Vec::new(), expected: Vec::new(), variance: Vec::new() };
        for (k, measured) in measured.iter().enumerate() {
            let counts: Vec<f64> = runs.iter().map(|run| run[k]).collect();
            let (mean, deviation) = mean_and_deviation(&counts);
            // Counting statistics of the pooled rate; runs that scatter more, by noise of pixels,
            // decide.
            let by_chance = (measured + n * mean) / (n + 1.0);
            let scatter = deviation * deviation;
            let tolerance = TOLERANCE * mean;
            all.difference.push(measured - mean);
            all.expected.push(mean);
            all.variance
                .push(by_chance.max(scatter).max(1.0) * (1.0 + 1.0 / n) + tolerance * tolerance);
        }
        all
    }

    /// Events of a fit of amplitude one in each bin.
    fn unit(&self, form: ResponseForm, shape: ResponseShape) -> Vec<f64> {
        let base = |k: usize| match form {
            ResponseForm::Rate => self.bins.exposure_s.get(k).copied().unwrap_or(0.0),
            ResponseForm::Fraction => self.expected[k],
        };
        (0..self.difference.len()).map(|k| base(k) * shape.at(self.bins.x[k])).collect()
    }

    fn chi2(&self, events: impl Fn(usize) -> f64) -> f64 {
        let z2 = |k: usize| (self.difference[k] - events(k)).powi(2) / self.variance[k];
        (0..self.difference.len()).map(z2).sum()
    }

    fn best(&self) -> Option<(ResponseFit, f64)> {
        let n = self.difference.len() as f64;
        let forms: &[ResponseForm] = if self.bins.exposure_s.is_empty() {
            &[ResponseForm::Fraction]
        } else {
            &[ResponseForm::Rate, ResponseForm::Fraction]
        };
        let fits = forms.iter().flat_map(|form| {
            ResponseShape::all(self.bins).into_iter().filter_map(|shape| {
                let unit = self.unit(*form, shape);
                let weighted = |values: &[f64]| -> f64 {
                    (0..unit.len()).map(|k| unit[k] * values[k] / self.variance[k]).sum()
                };
                let power = weighted(&unit);
                (power > 0.0).then(|| {
                    let amplitude = weighted(&self.difference) / power;
                    let chi2 = self.chi2(|k| amplitude * unit[k]);
                    // Where the function does not describe the points, its error grows with what is
                    // left.
                    let error = (chi2 / (n - 1.0)).max(1.0).sqrt() / power.sqrt();
                    let criterion = chi2 + shape.parameters() * n.ln();
                    (ResponseFit { form: *form, shape, amplitude, error }, chi2, criterion)
                })
            })
        });
        fits.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(fit, chi2, _)| (fit, chi2))
    }

    /// The response, if it is beyond chance.
    fn response(&self, is_on: bool) -> Option<Response> {
        let (fit, chi2) = self.best()?;
        let without = self.chi2(|_| 0.0);
        let gain = without - chi2;
        let point = |k: usize| {
            // Points and function are shown per unit of exposure or of expected events, as the fit
            // is.
            let base = self.unit(fit.form, ResponseShape::Even)[k];
            ResponsePoint {
                x: self.bins.x[k],
                difference: (base > 0.0).then(|| self.difference[k] / base),
                fitted: fit.amplitude * fit.shape.at(self.bins.x[k]),
            }
        };
        (gain >= MIN_GAIN).then(|| Response {
            property: self.bins.property,
            is_on,
            points: (0..self.difference.len()).map(point).collect(),
            fit,
            explained: gain / without,
            gain,
        })
    }
}

/// Responses along all properties, that which describes most first.
pub(super) fn responses(measured: &View<'_>, runs: &[View<'_>]) -> Vec<Response> {
    let mut all = Vec::new();
    // Each property alone: a fit over all of them would divide one difference among several.
    for property in Property::ALL {
        let bins = Bins::of_scene(property, measured);
        let runs: Vec<[Vec<f64>; 2]> = runs.iter().map(|run| bins.counts(run)).collect();
        let counts = bins.counts(measured);
        for (is_on, counts) in [false, true].into_iter().zip(&counts) {
            let runs: Vec<Vec<f64>> =
                runs.iter().map(|run| run[usize::from(is_on)].clone()).collect();
            all.extend(Differences::new(&bins, counts, &runs).response(is_on));
        }
    }
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all.truncate(REPORTED);
    all
}

impl Response {
    /// The fit in words: what a physicist would write next.
    pub fn sentence(&self) -> String {
        let polarity = if self.is_on { "ON" } else { "OFF" };
        let ResponseFit { form, shape, mut amplitude, mut error } = self.fit;
        // Powers at the point where they are largest: at one unit, there may be nothing to see.
        let largest = self.points.iter().max_by(|a, b| a.fitted.abs().total_cmp(&b.fitted.abs()));
        let at = largest.filter(|_| matches!(shape, ResponseShape::Power(_))).map(|point| point.x);
        if let Some(factor) = at.map(|x| shape.at(x)) {
            amplitude *= factor;
            error *= factor;
        }
        let sign = if amplitude > 0.0 { "more" } else { "fewer" };
        let size = match form {
            ResponseForm::Rate => {
                format!(
                    "{:.3} ± {:.3} {polarity} events per pixel and second {sign}",
                    amplitude.abs(),
                    error
                )
            }
            ResponseForm::Fraction => format!(
                "{:.1} ± {:.1} % {sign} {polarity} events than expected",
                100.0 * amplitude.abs(),
                100.0 * error
            ),
        };
        let (name, unit) = (self.property.name(), self.property.unit());
        let at = at.unwrap_or(1.0);
        match shape {
            ResponseShape::Even => format!("{size}, whatever the {name}"),
            ResponseShape::Power(1.0) => {
                format!("{size} at a {name} of {at:.3} {unit}, in proportion to it")
            }
            ResponseShape::Power(power) => {
                format!("{size} at a {name} of {at:.3} {unit}, as its power of {power}")
            }
            ResponseShape::Below(limit) => {
                format!("{size} where the {name} is below {limit:.3} {unit}")
            }
            ResponseShape::Above(limit) => {
                format!("{size} where the {name} is above {limit:.3} {unit}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bins() -> Bins {
        Bins {
            property: Property::Light,
            edges: (1..8).map(|k| 0.1 * f64::from(k)).collect(),
            x: (0..8).map(|k| 0.05 + 0.1 * f64::from(k)).collect(),
            exposure_s: vec![1_000.0; 8],
        }
    }

    fn response(more: impl Fn(f64) -> f64) -> Option<Response> {
        let bins = bins();
        let runs = vec![vec![2_000.0; 8], vec![2_010.0; 8], vec![1_990.0; 8]];
        let measured: Vec<f64> = bins.x.iter().map(|x| 2_000.0 + more(*x)).collect();
        Differences::new(&bins, &measured, &runs).response(true)
    }

    #[test]
    fn a_leak_is_even_and_a_photo_leak_goes_with_light() {
        let leak = response(|_| 500.0).unwrap();
        assert_eq!(leak.fit.shape, ResponseShape::Even);
        let photo = response(|x| 3_000.0 * x).unwrap();
        assert_eq!(
            (photo.fit.form, photo.fit.shape),
            (ResponseForm::Rate, ResponseShape::Power(1.0))
        );
        assert!((photo.fit.amplitude - 3.0).abs() < 1e-6 && photo.explained > 0.99);
        // At the brightest point.
        assert!(photo.sentence().starts_with("2.250 ± "), "{}", photo.sentence());
        assert!(photo.sentence().contains(" of 0.750 "), "{}", photo.sentence());
        assert!(photo.sentence().contains("in proportion to it"));
    }

    #[test]
    fn what_is_lost_in_the_dark_is_a_step() {
        let lost = response(|x| if x < 0.3 { -800.0 } else { 0.0 }).unwrap();
        assert!(
            matches!(lost.fit.shape, ResponseShape::Below(limit) if (limit - 0.3).abs() < 1e-9)
        );
        assert!(lost.sentence().contains("fewer"), "{}", lost.sentence());
    }

    #[test]
    fn chance_is_no_response() {
        assert!(response(|x| 30.0 * (40.0 * x).sin()).is_none());
    }
}
