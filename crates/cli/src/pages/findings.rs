//! Findings of a training in words, learned or not: its errors beside those of the mean pose, which
//! uses no events.

use evpose_core::stats::interval::Interval;
use evpose_pose::metric::HandRatios;

use crate::pages::held_out::Metrics;

/// One part of a hand's pose, and its error relative to the mean pose's.
struct Part {
    name: &'static str,
    ratio: fn(&HandRatios) -> Option<Interval>,
}

const PARTS: [Part; 3] = [
    Part { name: "The position of the wrist", ratio: |ratios| ratios.translation },
    Part { name: "The rotation of the wrist", ratio: |ratios| ratios.rotation },
    Part { name: "The articulation of the fingers", ratio: |ratios| ratios.articulation },
];

/// A sentence for each part of the pose, and one on the Kalman filter.
pub(crate) fn sentences(metrics: &Metrics) -> Vec<String> {
    let ratios = &metrics.trained_over_mean_pose;
    let mut sentences: Vec<String> =
        PARTS.iter().map(|part| sentence(part.name, (part.ratio)(ratios))).collect();
    let filtered = &metrics.trained_kalman_over_mean_pose;
    sentences.push(filter_sentence(ratios.translation, filtered.translation));
    sentences
}

/// Whether a part was learned: whether the interval of the ratio of errors lies below 1.
fn sentence(name: &str, ratio: Option<Interval>) -> String {
    let Some(Interval { estimate, low, high }) = ratio else {
        return format!("{name} was not evaluated.");
    };
    let interval = match (low, high) {
        (Some(low), Some(high)) => format!(" [{low:.2}, {high:.2}]"),
        _ => String::new(),
    };
    let share = format!("its error is {estimate:.2}{interval} of the mean pose's");
    // By the ends of the interval, not by the estimate: few sequences prove little.
    match (low, high) {
        (_, Some(high)) if high < 0.5 => format!("{name} was learned well: {share}."),
        (_, Some(high)) if high < 1.0 => format!("{name} was learned in part: {share}."),
        (Some(low), _) if low > 1.0 => {
            format!("{name} was not learned: {share}, so that the mean pose is more accurate.")
        }
        (Some(_), Some(_)) => {
            format!("{name} was not learned: {share}, which does not differ from 1 significantly.")
        }
        _ => format!("{name}: {share}; too few sequences for an interval."),
    }
}

/// Effect of the filter on the position of the wrist.
fn filter_sentence(plain: Option<Interval>, filtered: Option<Interval>) -> String {
    let (Some(plain), Some(filtered)) = (plain, filtered) else {
        return "The Kalman filter was not evaluated.".to_owned();
    };
    let change = filtered.estimate / plain.estimate - 1.0;
    match change.abs() < 0.02 {
        true => "The Kalman filter changes the error of the wrist's position by less than 2 %."
            .to_owned(),
        false => format!(
            "The Kalman filter {} the error of the wrist's position by {:.0} %.",
            if change > 0.0 { "raises" } else { "lowers" },
            100.0 * change.abs()
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(low: f64, estimate: f64, high: f64) -> Option<Interval> {
        Some(Interval { estimate, low: Some(low), high: Some(high) })
    }

    #[test]
    fn learned_is_what_is_significantly_better_than_the_mean_pose() {
        let of = |low, estimate, high| sentence("X", interval(low, estimate, high));
        assert!(
            of(0.3, 0.4, 0.45).starts_with("X was learned well: its error is 0.40 [0.30, 0.45]")
        );
        assert!(of(0.6, 0.8, 0.9).starts_with("X was learned in part"));
        assert!(
            of(0.9, 0.98, 1.05).contains("not learned") && of(0.9, 1.0, 1.1).contains("differ")
        );
        assert!(of(1.1, 1.2, 1.3).contains("the mean pose is more accurate"));
        assert_eq!(sentence("X", None), "X was not evaluated.");
        let alone = Some(Interval { estimate: 0.2, low: None, high: None });
        assert!(sentence("X", alone).contains("too few sequences"));
    }

    #[test]
    fn the_filter_lowers_raises_or_leaves_an_error() {
        let of = |after| filter_sentence(interval(0.4, 0.5, 0.6), interval(0.3, after, 0.9));
        assert!(of(0.45).contains("lowers the error of the wrist's position by 10 %"));
        assert!(of(0.6).contains("raises the error of the wrist's position by 20 %"));
        assert!(of(0.501).contains("less than 2 %"));
    }
}
