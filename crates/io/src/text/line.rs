//! Parsing of a line of a text recording.

use std::fmt;

use evpose_core::{Event, Micros, Polarity, SensorSize};

/// Beyond 285 years a double no longer resolves microseconds.
const MAX_SECONDS: f64 = 9e9;

/// A fault of a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum TextFault {
    /// Longer than any line of events.
    TooLong,
    /// Not text.
    NotText,
    /// An event has four fields.
    Fields(usize),
    /// A field that cannot be read.
    Field {
        /// Its name.
        name: &'static str,
        /// Its text.
        text: String,
    },
    /// The first column is not that of times.
    Order,
    /// The file ends in it, and perhaps within its last number.
    Open,
}

impl fmt::Display for TextFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong => f.write_str("longer than any line of events"),
            Self::NotText => f.write_str("not text"),
            Self::Fields(1) => f.write_str("1 field instead of t x y p"),
            Self::Fields(n) => write!(f, "{n} fields instead of t x y p"),
            Self::Field { name, text } => write!(f, "`{text}` is no {name}"),
            Self::Order => f.write_str(
                "the values of the first column go up and down as times do not: put a line that \
                 names the columns before the first, such as `x y t p`",
            ),
            Self::Open => f.write_str(
                "the file ends in it, perhaps within a number: if it is whole, end it with a line \
                 break",
            ),
        }
    }
}

/// Unit of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeUnit {
    Seconds,
    Microseconds,
}

impl TimeUnit {
    /// Detects the unit of a time; none for a zero, which is the same in all units.
    fn detect(field: &str) -> Option<Self> {
        match field {
            "0" => None,
            _ if field.contains(['.', 'e', 'E']) => Some(Self::Seconds),
            _ => Some(Self::Microseconds),
        }
    }

    fn parse(self, text: &str) -> Result<Micros, TextFault> {
        let parsed = match self {
            Self::Microseconds => text.parse().ok().map(Micros),
            Self::Seconds => {
                let seconds = text.parse::<f64>().ok();
                seconds.filter(|s| s.abs() < MAX_SECONDS).map(Micros::from_seconds)
            }
        };
        let name = match self {
            Self::Seconds => "time in seconds",
            Self::Microseconds => "time in whole microseconds, as the first event has it",
        };
        parsed.ok_or_else(|| TextFault::Field { name, text: text.to_owned() })
    }
}

/// Properties of a file that earlier lines establish.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Known {
    /// Whether nothing but comments came before.
    pub(super) is_first: bool,
    /// Unit of times; none until an event decides it.
    pub(super) unit: Option<TimeUnit>,
    /// Indices of t, x, y and p in a line; none until a line decides them.
    pub(super) order: Option<[usize; 4]>,
}

/// Order of the data sets of the Robotics and Perception Group.
pub(super) const USUAL: [usize; 4] = [0, 1, 2, 3];
/// `x y p t`, as tables of Prophesee's programs.
pub(super) const TIME_LAST: [usize; 4] = [3, 0, 1, 2];

/// Names of t, x, y and p in a line of names.
const NAMES: [&[&str]; 4] = [
    &["t", "ts", "timestamp", "time", "timestamps"],
    &["x", "col", "xs"],
    &["y", "row", "ys"],
    &["p", "pol", "polarity", "ps", "on"],
];

/// A line that is neither empty nor a comment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Line {
    Sensor(SensorSize),
    Names,
    Event(Event),
}

/// Splits a line at spaces, tabs, commas and semicolons.
fn fields(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_ascii_whitespace() || c == ',' || c == ';').filter(|f| !f.is_empty())
}

/// The places of t, x, y and p in a line that names them.
pub(super) fn names(text: &str) -> Option<[usize; 4]> {
    let listed: Vec<String> = fields(text).map(str::to_ascii_lowercase).collect();
    let mut places = USUAL;
    for (place, known) in places.iter_mut().zip(NAMES) {
        *place = listed.iter().position(|name| known.contains(&name.as_str()))?;
    }
    (listed.len() == 4).then_some(places)
}

/// Parses a line, and updates `known` for the lines behind it.
pub(super) fn parse(bytes: &[u8], known: &mut Known) -> Result<Option<Line>, TextFault> {
    let text = str::from_utf8(bytes).map_err(|_| TextFault::NotText)?;
    let text = text.split('#').next().unwrap_or_default();
    let mut words = fields(text);
    let words = [(); 5].map(|()| words.next());
    match words {
        [None, ..] => Ok(None),
        [Some(width), Some(height), None, ..] if known.is_first => {
            let sensor = SensorSize {
                width: number("sensor width", width)?,
                height: number("sensor height", height)?,
            };
            Ok(Some(Line::Sensor(sensor)))
        }
        [Some(a), Some(b), Some(c), Some(d), None] => {
            if known.is_first
                && let Some(order) = names(text)
            {
                known.order = Some(order);
                return Ok(Some(Line::Names));
            }
            let is_last = || polarity(d).is_err() && polarity(c).is_ok();
            let order =
                *known.order.get_or_insert_with(|| if is_last() { TIME_LAST } else { USUAL });
            let [t, x, y, p] = order.map(|place| [a, b, c, d][place]);
            known.unit = known.unit.or_else(|| TimeUnit::detect(t));
            let unit = known.unit.unwrap_or(TimeUnit::Microseconds);
            let polarity = polarity(p)?;
            let (x, y) = (coordinate("column", x)?, coordinate("row", y)?);
            Ok(Some(Line::Event(Event { t: unit.parse(t)?, x, y, polarity })))
        }
        _ => Err(TextFault::Fields(fields(text).count())),
    }
}

fn polarity(text: &str) -> Result<Polarity, TextFault> {
    match text {
        "0" | "-1" | "False" | "false" => Ok(Polarity::Off),
        "1" | "+1" | "True" | "true" => Ok(Polarity::On),
        _ => match text.parse::<f64>() {
            // Tables of floats.
            Ok(0.0 | -1.0) => Ok(Polarity::Off),
            Ok(1.0) => Ok(Polarity::On),
            _ => {
                let name = "polarity, 0 or 1, or -1 or 1";
                Err(TextFault::Field { name, text: text.to_owned() })
            }
        },
    }
}

fn number(name: &'static str, text: &str) -> Result<u16, TextFault> {
    let positive = text.parse().ok().filter(|&n| n > 0);
    positive.ok_or_else(|| TextFault::Field { name, text: text.to_owned() })
}

/// An integer that fits no sensor becomes one that lies outside every sensor.
fn coordinate(name: &'static str, text: &str) -> Result<u16, TextFault> {
    let whole = || {
        let number: f64 = text.parse().ok()?;
        (number.fract() == 0.0 && number.abs() < 1e9).then_some(number as i64)
    };
    let value: Option<i64> = text.parse().ok().or_else(whole);
    let value = value.ok_or_else(|| TextFault::Field { name, text: text.to_owned() })?;
    Ok(u16::try_from(value).unwrap_or(u16::MAX))
}
