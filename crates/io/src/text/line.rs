//! What a line of a text recording says.

use std::fmt;

use evpose_core::{Event, Micros, Polarity, SensorSize};

/// What is wrong with a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TextFault {
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
        /// What stands there.
        text: String,
    },
}

impl fmt::Display for TextFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong => f.write_str("longer than any line of events"),
            Self::NotText => f.write_str("not text"),
            Self::Fields(1) => f.write_str("1 field instead of t x y p"),
            Self::Fields(n) => write!(f, "{n} fields instead of t x y p"),
            Self::Field { name, text } => write!(f, "`{text}` is no {name}"),
        }
    }
}

/// How times are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeUnit {
    Seconds,
    Microseconds,
}

impl TimeUnit {
    fn of(field: &str) -> Self {
        if field.contains(['.', 'e', 'E']) { Self::Seconds } else { Self::Microseconds }
    }

    fn parse(self, text: &str) -> Result<Micros, TextFault> {
        let parsed = match self {
            Self::Microseconds => text.parse().ok().map(Micros),
            Self::Seconds => {
                let seconds = text.parse::<f64>().ok();
                // Beyond 285 years a double no longer tells microseconds apart.
                seconds.filter(|s| s.abs() < 9e9).map(Micros::from_seconds)
            }
        };
        let name = match self {
            Self::Seconds => "time in seconds",
            Self::Microseconds => "time in whole microseconds, as the first event has it",
        };
        parsed.ok_or_else(|| TextFault::Field { name, text: text.to_owned() })
    }
}

/// A line with something on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Line {
    Sensor(SensorSize),
    Event(Event),
}

/// Reads a line; `unit` is decided by the first event.
pub(super) fn parse(
    bytes: &[u8],
    may_be_sensor: bool,
    unit: &mut Option<TimeUnit>,
) -> Result<Option<Line>, TextFault> {
    let text = str::from_utf8(bytes).map_err(|_| TextFault::NotText)?;
    let text = text.split('#').next().unwrap_or_default();
    let mut fields = text.split_ascii_whitespace();
    let fields = [(); 5].map(|()| fields.next());
    match fields {
        [None, ..] => Ok(None),
        [Some(width), Some(height), None, ..] if may_be_sensor => {
            let sensor = SensorSize {
                width: number("sensor width", width)?,
                height: number("sensor height", height)?,
            };
            Ok(Some(Line::Sensor(sensor)))
        }
        [Some(t), Some(x), Some(y), Some(p), None] => {
            let unit = *unit.get_or_insert_with(|| TimeUnit::of(t));
            let polarity = match p {
                "0" => Polarity::Off,
                "1" => Polarity::On,
                _ => return Err(TextFault::Field { name: "polarity, 0 or 1", text: p.to_owned() }),
            };
            let (x, y) = (coordinate("column", x)?, coordinate("row", y)?);
            Ok(Some(Line::Event(Event { t: unit.parse(t)?, x, y, polarity })))
        }
        _ => Err(TextFault::Fields(text.split_ascii_whitespace().count())),
    }
}

fn number(name: &'static str, text: &str) -> Result<u16, TextFault> {
    let positive = text.parse().ok().filter(|&n| n > 0);
    positive.ok_or_else(|| TextFault::Field { name, text: text.to_owned() })
}

/// An integer that fits no sensor becomes one that lies outside every sensor.
fn coordinate(name: &'static str, text: &str) -> Result<u16, TextFault> {
    let value: Option<i64> = text.parse().ok();
    let value = value.ok_or_else(|| TextFault::Field { name, text: text.to_owned() })?;
    Ok(u16::try_from(value).unwrap_or(u16::MAX))
}
