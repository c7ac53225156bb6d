//! Ticks of logarithmic axes.

/// Labels that fit on an axis.
const MAX_TICKS: usize = 7;
/// Fewer leave a reader without a scale.
const MIN_TICKS: usize = 3;

/// Values of a logarithmic axis that are labelled: powers of ten, every few of them where there are
/// many, or 1, 2, 5 times them, or round values evenly spaced over a part of a decade.
///
/// `0 < low <= high` are the ends of the axis.
pub(crate) fn log_ticks(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let is_on_axis = |value: &f64| (low..=high).contains(value);
    let times = |factors: &[f64]| -> Vec<f64> {
        let decades = (first..=last).flat_map(|power| factors.iter().map(move |f| (f, power)));
        decades.map(|(factor, power)| factor * 10_f64.powi(power)).filter(is_on_axis).collect()
    };
    // The finest ones that are not too many.
    for factors in [&[1.0, 2.0, 5.0][..], &[1.0, 3.0], &[1.0]] {
        let ticks = times(factors);
        // A part of a decade has few of them.
        if ticks.len() < MIN_TICKS && factors.len() == 3 {
            return even_ticks(low, high);
        }
        if ticks.len() <= MAX_TICKS {
            return ticks;
        }
    }
    let decades = times(&[1.0]);
    let every = decades.len().div_ceil(MAX_TICKS);
    decades.into_iter().step_by(every).collect()
}

/// Multiples of a round value between the ends of a short axis.
fn even_ticks(low: f64, high: f64) -> Vec<f64> {
    let span = high - low;
    if span <= 0.0 {
        return vec![low];
    }
    let power = 10_f64.powf((span / MAX_TICKS as f64).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    // So many intervals have one tick more, at their end.
    let fits = |step: &&f64| span / **step <= MAX_TICKS as f64 - 1.0;
    let step = *step.iter().find(fits).unwrap_or(&step[3]);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|k| k as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_neither_few_nor_many() {
        assert_eq!(log_ticks(0.8, 130.0), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(log_ticks(0.8, 1300.0), [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0]);
        assert_eq!(log_ticks(0.8, 13_000.0), [1.0, 10.0, 100.0, 1e3, 1e4]);
        assert_eq!(log_ticks(41.0, 97.0), [50.0, 60.0, 70.0, 80.0, 90.0]);
        for (low, high) in [(1e-9, 1e9), (0.3, 0.31), (1.0, 1.0), (5.0, 5.1), (1e-3, 2.0)] {
            let ticks = log_ticks(low, high);
            assert!((1..=MAX_TICKS).contains(&ticks.len()), "{low} to {high}: {ticks:?}");
            assert!(ticks.is_sorted() && low == high || ticks.len() >= MIN_TICKS, "{ticks:?}");
            let room = 1e-9 * high;
            assert!(ticks.iter().all(|t| (low - room..=high + room).contains(t)), "{ticks:?}");
        }
    }
}
