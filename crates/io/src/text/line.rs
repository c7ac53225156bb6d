//! Parsing of a line of a text recording.

use evpose_core::{Event, Micros, Polarity, SensorSize};

use crate::names::{self, Places};
use crate::{ColumnNames, TimeUnit};

/// Beyond 285 years a double no longer resolves microseconds.
const MAX_SECONDS: f64 = 9e9;

/// A fault of a line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(super) enum TextFault {
    /// Longer than any line of events.
    #[error("longer than any line of events")]
    TooLong,
    /// Not text.
    #[error("not text")]
    NotText,
    /// An event has four fields.
    #[error("{0} field{s} instead of t x y p", s = if *.0 == 1 { "" } else { "s" })]
    Fields(usize),
    /// A line has as many fields as there are names.
    #[error("{got} fields instead of the {of} that are named")]
    Named {
        /// Fields of the line.
        got: usize,
        /// Names.
        of: usize,
    },
    /// A field that cannot be read.
    #[error("`{text}` is no {name}")]
    Field {
        /// Its name.
        name: &'static str,
        /// Its text.
        text: String,
    },
    /// A line of names without those of an event.
    #[error(
        "not all of t, x, y and p are among the names `{0}`: say which they are, as --columns \
         t=NAME,x=NAME,y=NAME,p=NAME"
    )]
    Names(String),
    /// The first column is not that of times.
    #[error(
        "the values of the first column go up and down as times do not: say where they are, as --columns \
         t=2,x=0,y=1,p=3, or sort all events with --sort"
    )]
    Order,
    /// The file ends in it, and perhaps within its last number.
    #[error(
        "the file ends in it, perhaps within a number: if it is whole, end it with a line break"
    )]
    Open,
}

/// Detects the unit of a time; none for a zero, which is the same in all units.
fn unit_of(field: &str) -> Option<TimeUnit> {
    match field {
        "0" => None,
        _ if field.contains(['.', 'e', 'E']) => Some(TimeUnit::Seconds),
        _ => Some(TimeUnit::Microseconds),
    }
}

fn time(text: &str, unit: TimeUnit, is_stated: bool) -> Result<Micros, TextFault> {
    let whole = || unit.whole(text.parse().ok()?);
    let real = || text.parse().ok().and_then(|value| unit.real(value));
    let (parsed, name) = match unit {
        TimeUnit::Seconds => {
            let seconds = text.parse::<f64>().ok().filter(|s| s.abs() < MAX_SECONDS);
            (seconds.map(Micros::from_seconds), "time in seconds")
        }
        // Of a unit that nobody stated, the first event is all there is.
        _ if !is_stated => (whole(), "time in whole microseconds, as the first event has it"),
        _ => (whole().or_else(real), "time"),
    };
    parsed.ok_or_else(|| TextFault::Field { name, text: text.to_owned() })
}

/// Properties of a file that options and earlier lines establish.
#[derive(Debug, Clone, Default)]
pub(super) struct Known {
    /// Whether nothing but comments came before.
    pub(super) is_first: bool,
    /// Unit of times; none until an event decides it.
    pub(super) unit: Option<TimeUnit>,
    /// Whether the unit was stated, by a name or the caller.
    pub(super) is_unit_stated: bool,
    /// Names of columns, as the caller has them.
    pub(super) columns: ColumnNames,
    /// Order of the fields; none until a line decides it.
    pub(super) order: Option<FieldOrder>,
    /// The order by the values of the first lines.
    pub(super) order_by_values: Option<FieldOrder>,
}

/// Fields of a line, and which of them are those of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FieldOrder {
    /// Indices of t, x, y and p.
    pub(super) places: [usize; 4],
    /// Fields of a line.
    pub(super) fields: usize,
}

/// Order of the data sets of the Robotics and Perception Group.
pub(super) const USUAL: FieldOrder = FieldOrder { places: [0, 1, 2, 3], fields: 4 };
/// `x y p t`, as tables of Prophesee's programs.
pub(super) const TIME_LAST: FieldOrder = FieldOrder { places: [3, 0, 1, 2], fields: 4 };

/// Fields that a line may have.
const MAX_FIELDS: usize = 16;
/// Begins the line that states the sensor in tables of Prophesee's programs.
pub(super) const GEOMETRY: &str = "%geometry:";

/// A line that is neither empty nor a comment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Line {
    Sensor(SensorSize),
    Names,
    Event(Event),
}

/// Splits a line at spaces, tabs, commas and semicolons.
pub(super) fn fields(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_ascii_whitespace() || c == ',' || c == ';').filter(|f| !f.is_empty())
}

/// The order of the fields in a line that names them, and the unit that a name states. The first may
/// have no name, as the row index of tables of pandas.
pub(super) fn names(text: &str, given: &ColumnNames) -> Option<(FieldOrder, Option<TimeUnit>)> {
    // Names may have spaces in them where commas separate.
    let listed: Vec<&str> = match text.find([',', ';']) {
        // A separator at the end of lines begins no column.
        Some(_) => text.trim_end().trim_end_matches([',', ';']).split([',', ';']).collect(),
        None => {
            // Tables of pandas begin with a nameless column of row indices.
            let unnamed = text.starts_with('\t').then_some("");
            unnamed.into_iter().chain(fields(text)).collect()
        }
    };
    let Places { places, unit } = names::places(&listed.iter().copied(), given).ok()?;
    let order = FieldOrder { places, fields: listed.len() };
    (order.fields <= MAX_FIELDS).then_some((order, unit))
}

/// Parses a line, and updates `known` for the lines behind it.
pub(super) fn parse(bytes: &[u8], known: &mut Known) -> Result<Option<Line>, TextFault> {
    let text = str::from_utf8(bytes).map_err(|_| TextFault::NotText)?;
    let text = text.split('#').next().unwrap_or_default();
    if let Some(remark) = text.strip_prefix('%') {
        return match text.strip_prefix(GEOMETRY) {
            Some(size) if known.is_first => {
                known.order = Some(TIME_LAST);
                sensor(size.split_once(',').unwrap_or((size, "")))
            }
            _ if remark.starts_with(|c: char| c.is_ascii_graphic()) => Ok(None),
            _ => Err(TextFault::NotText),
        };
    }
    let (mut words, mut count) = ([""; MAX_FIELDS], 0);
    for word in fields(text) {
        let place = words.get_mut(count).ok_or_else(|| TextFault::Fields(fields(text).count()))?;
        *place = word;
        count += 1;
    }
    if count == 0 {
        return Ok(None);
    }
    if known.is_first {
        // Some published files begin with the size of the sensor.
        if count == 2 && known.order.is_none() {
            return sensor((words[0], words[1]));
        }
        if let Some((order, unit)) = names(text, &known.columns) {
            known.order = Some(order);
            known.unit = known.unit.or(unit);
            known.is_unit_stated |= unit.is_some();
            return Ok(Some(Line::Names));
        }
        if words[0].trim_matches('"').starts_with(char::is_alphabetic) {
            return Err(TextFault::Names(text.trim().to_owned()));
        }
        if let Some(places) = known.columns.indices() {
            known.order = Some(FieldOrder { places, fields: count });
        }
    }
    let order = match known.order.or(known.order_by_values) {
        Some(order) => order,
        None if count != USUAL.fields => return Err(TextFault::Fields(count)),
        // In a file without names the polarity's place says which of both orders it is.
        None if polarity(words[3]).is_err() && polarity(words[2]).is_ok() => TIME_LAST,
        None => USUAL,
    };
    known.order = Some(order);
    // Every line as the first one: a missing value shifts all behind it.
    match order.fields {
        fields if fields == count => {}
        4 => return Err(TextFault::Fields(count)),
        of => return Err(TextFault::Named { got: count, of }),
    }
    let [t, x, y, p] = order.places.map(|place| words.get(place).copied().unwrap_or_default());
    known.unit = known.unit.or_else(|| unit_of(t));
    let unit = known.unit.unwrap_or(TimeUnit::Microseconds);
    let polarity = polarity(p)?;
    let (x, y) = (coordinate("column", x)?, coordinate("row", y)?);
    Ok(Some(Line::Event(Event { t: time(t, unit, known.is_unit_stated)?, x, y, polarity })))
}

/// The size of a sensor, of the texts of its width and height.
fn sensor((width, height): (&str, &str)) -> Result<Option<Line>, TextFault> {
    let width = number("sensor width", width.trim())?;
    let height = number("sensor height", height.trim())?;
    Ok(Some(Line::Sensor(SensorSize { width, height })))
}

fn polarity(text: &str) -> Result<Polarity, TextFault> {
    match text {
        "0" | "-1" | "False" | "false" => Ok(Polarity::Off),
        "1" | "+1" | "True" | "true" => Ok(Polarity::On),
        _ => match text.parse::<f64>() {
            // Tables of floats, and -1 as integers without a sign.
            Ok(0.0 | -1.0 | 255.0 | 4_294_967_295.0) => Ok(Polarity::Off),
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
