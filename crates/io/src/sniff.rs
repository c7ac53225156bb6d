//! Detection of columns without a name.

/// Orders of columns without names, as places of t, x, y and p.
pub(crate) const ORDERS: [([usize; 4], &str); 4] = [
    ([0, 1, 2, 3], "t x y p"),
    ([2, 0, 1, 3], "x y t p"),
    ([3, 0, 1, 2], "x y p t"),
    ([0, 2, 3, 1], "t p x y"),
];

/// Minimal share of steps in which times do not go back.
const MIN_FORWARD: f64 = 0.9;

/// Whether a column may hold times: over a lag of a twentieth of its length, values of any other
/// column fall as often as they rise.
pub(crate) fn is_time(values: &(impl ExactSizeIterator<Item = f64> + Clone)) -> bool {
    let lag = (values.len() / 20).max(1);
    let pairs = values.clone().zip(values.clone().skip(lag));
    let steps = values.len().saturating_sub(lag);
    let forward = pairs.filter(|(a, b)| b >= a).count();
    forward as f64 >= MIN_FORWARD * steps as f64
}

/// The usual orders that fit the values of columns, the likeliest last.
pub(crate) fn fitting_orders(columns: &[Vec<f64>]) -> Vec<[usize; 4]> {
    let fits = |[t, x, y, p]: [usize; 4]| {
        let is_pixel = |column: usize| {
            columns[column].iter().all(|v| (0.0..65_536.0).contains(v) && v.fract() == 0.0)
        };
        // -1 as an integer of 32 bits without a sign is 4294967295.
        let is_polarity = |value: &f64| [0.0, 1.0, -1.0, 4_294_967_295.0].contains(value);
        columns[p].iter().all(is_polarity)
            && is_pixel(x)
            && is_pixel(y)
            && is_time(&columns[t].iter().copied())
    };
    // Of several that fit, the one whose times reach furthest: few columns go from one end of
    // a sensor to the other.
    let span = |order: &[usize; 4]| {
        let times = &columns[order[0]];
        let end = |pick: fn(f64, f64) -> f64, from| times.iter().copied().fold(from, pick);
        end(f64::max, f64::MIN) - end(f64::min, f64::MAX)
    };
    let orders = ORDERS.iter().rev().map(|(order, _)| *order);
    let mut fitting: Vec<_> = orders.filter(|order| fits(*order)).collect();
    fitting.sort_by(|a, b| span(a).total_cmp(&span(b)));
    fitting
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_distinguished_from_coordinates_and_polarities() {
        let is_time = |value: fn(usize) -> usize| {
            let values: Vec<f64> = (0..1000).map(|k| value(k) as f64).collect();
            is_time(&values.iter().copied())
        };
        assert!(is_time(|k| 3 * k) && is_time(|k| k / 10 * 10 + (7 * k) % 10));
        assert!(!is_time(|k| (37 * k) % 101) && !is_time(|k| (k / 3) % 2));
    }
}
