//! Names of the columns of events in tables, arrays and archives, with the unit that a name may state.

use crate::source::{ColumnNames, TimeUnit};

/// Usual names of time, column, row and polarity.
const NAMES: [&[&str]; 4] = [
    &["t", "ts", "time", "times", "timestamp", "timestamps"],
    &["x", "xs", "col", "cols", "column", "x_pos", "xpos", "pos_x"],
    &["y", "ys", "row", "rows", "y_pos", "ypos", "pos_y"],
    &["p", "ps", "pol", "pols", "polarity", "polarities", "on", "is_on", "is_increase"],
];
/// Names of units.
const UNITS: [(&[&str], TimeUnit); 4] = [
    (&["s", "sec", "seconds"], TimeUnit::Seconds),
    (&["ms", "milliseconds"], TimeUnit::Milliseconds),
    (&["us", "µs", "microseconds"], TimeUnit::Microseconds),
    (&["ns", "nanoseconds"], TimeUnit::Nanoseconds),
];

/// Columns of an event by what they are called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Places {
    /// Places of t, x, y and p among the names.
    pub(crate) places: [usize; 4],
    /// Unit that the name of times states.
    pub(crate) unit: Option<TimeUnit>,
}

/// The places of t, x, y and p among names, or which of the four are missing.
pub(crate) fn places<'n>(
    names: &(impl Iterator<Item = &'n str> + Clone),
    given: &ColumnNames,
) -> Result<Places, Vec<usize>> {
    let place = |what: usize| match &given.0[what] {
        Some(given) => names.clone().position(|name| plain(name) == plain(given)),
        None => NAMES[what].iter().find_map(|usual| {
            names.clone().position(|name| {
                let (name, unit) = split(&plain(name));
                // Only times have units: another column with one is something else.
                name == *usual && (what == 0 || unit.is_none())
            })
        }),
    };
    let found = [0, 1, 2, 3].map(place);
    let [Some(t), Some(x), Some(y), Some(p)] = found else {
        return Err((0..4).filter(|what| found[*what].is_none()).collect());
    };
    let unit = names.clone().nth(t).and_then(|name| split(&plain(name)).1);
    Ok(Places { places: [t, x, y, p], unit })
}

/// A name without quotes and capitals, and without the extent that faery states behind it (`x@346`).
fn plain(name: &str) -> String {
    let name = name.trim().trim_matches(['"', '\'']).trim();
    name.split('@').next().unwrap_or_default().to_lowercase()
}

/// The name before the unit, and the unit: `t_us`, `timestamp [ns]`, `time (s)`.
fn split(name: &str) -> (String, Option<TimeUnit>) {
    let parts = name.trim_end_matches([']', ')']);
    if let Some((before, unit)) = parts.rsplit_once(['[', '(', '_', ' '])
        && let Some(unit) = unit_by_name(unit)
    {
        return (before.trim_end_matches([' ', '_']).to_owned(), Some(unit));
    }
    (name.to_owned(), None)
}

/// A unit of times.
pub(crate) fn unit_by_name(name: &str) -> Option<TimeUnit> {
    UNITS.iter().find(|(names, _)| names.contains(&name.trim())).map(|(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &str) -> Result<Places, Vec<usize>> {
        places(&names.split(','), &ColumnNames::default())
    }

    #[test]
    fn names_of_other_programs_are_known_with_their_units() {
        let found = |places, unit| Ok(Places { places, unit });
        assert_eq!(of("t,x,y,p"), found([0, 1, 2, 3], None));
        assert_eq!(of("x,y,polarity,t_us"), found([3, 0, 1, 2], Some(TimeUnit::Microseconds)));
        let pixels = "frame,timestamp [ns],x_pos,y_pos,is_increase";
        assert_eq!(of(pixels), found([1, 2, 3, 4], Some(TimeUnit::Nanoseconds)));
        assert_eq!(of("\"Time (s)\",X@346,y@260,on"), found([0, 1, 2, 3], Some(TimeUnit::Seconds)));
        assert_eq!(of("timestamp_us,row,col,pol").unwrap().places, [0, 2, 1, 3]);
        assert_eq!((of("t,x,p"), of("a,b,c")), (Err(vec![2]), Err(vec![0, 1, 2, 3])));
    }

    #[test]
    fn names_that_were_given_come_first() {
        let given: ColumnNames = "t=stamp_ms,p=sign".parse().unwrap();
        let found = places(&"t,stamp_ms,x,y,sign".split(','), &given).unwrap();
        assert_eq!((found.places, found.unit), ([1, 2, 3, 4], Some(TimeUnit::Milliseconds)));
    }
}
