//! The `%` lines before the data of Prophesee's files.
//!
//! A line is `% key value`; `% end` may close the header. Where it does not, data begin with the
//! first bytes that are no such line. Data may begin with a `%`, too, so a line counts only if it
//! is text to its end: the first word of data sets the time, and no byte of text has its highest
//! bits.

use evpose_core::SensorSize;

use crate::{Header, Input, IoError};

/// Ample for one key and its value; what is longer is data.
const MAX_LINE: usize = 4096;
/// No camera writes more than some hundred bytes.
const MAX_HEADER: usize = 1 << 20;
/// Bytes that are read first.
const USUAL_HEADER: usize = 1 << 16;

/// Names of facts, and the vendors' keys for each; the first key that the file has is taken.
const FACTS: &[(&str, &[&str])] = &[
    ("camera", &["camera_integrator_name", "integrator_name", "plugin_name"]),
    ("chip", &["sensor_name", "sensor_generation", "generation"]),
    ("serial", &["serial_number"]),
    ("firmware", &["firmware_version"]),
    ("date", &["date", "Date"]),
];

/// Keys and values of a header.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Lines {
    fields: Vec<(String, String)>,
    /// Bytes of all lines: where the data begin.
    pub(crate) length: usize,
    /// Whether the bytes ended where another line might begin or go on.
    pub(crate) is_open: bool,
}

impl Lines {
    /// The lines at the beginning of `bytes`.
    pub(crate) fn parse(bytes: &[u8]) -> Self {
        let mut lines = Self::default();
        loop {
            let rest = &bytes[lines.length..];
            let line = match line(rest) {
                Ok(Some(line)) => line,
                Ok(None) => return lines,
                Err(Unfinished) => {
                    lines.is_open = true;
                    return lines;
                }
            };
            // The line break is not in the text.
            lines.length += line.len() + 1;
            let text = line[1..].trim();
            let (key, value) = text.split_once([' ', '\t']).unwrap_or((text, ""));
            // Newer headers end with a line for it, older ones before the first line without `%`.
            if key == "end" && value.is_empty() {
                return lines;
            }
            lines.fields.push((key.to_owned(), value.trim().to_owned()));
        }
    }

    /// The lines of a file.
    ///
    /// # Errors
    /// If it cannot be read, or has no data within a mebibyte.
    pub(crate) fn read(input: &mut Input) -> Result<Self, IoError> {
        let mut max = USUAL_HEADER;
        loop {
            let bytes = input.head(max)?;
            let lines = Self::parse(&bytes);
            if !lines.is_open || bytes.len() < max {
                return Ok(lines);
            }
            if max >= MAX_HEADER {
                let reason = "a header of more than a mebibyte";
                return Err(IoError::damaged(&input.path, lines.length as u64, reason));
            }
            // Most headers are short: more is read only where the end was not found.
            max *= 2;
        }
    }

    /// Checks that a file does not end within a line.
    ///
    /// # Errors
    /// If it does.
    pub(crate) fn check_end(&self, input: &Input) -> Result<(), IoError> {
        let byte = self.length as u64;
        if !self.is_open || input.length <= byte {
            return Ok(());
        }
        Err(IoError::damaged(&input.path, byte, "the file ends within its header"))
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.fields.is_empty()
    }

    /// The value behind `key`.
    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.fields.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
    }

    /// An option of the format line, such as `width` of `EVT3;height=720;width=1280`.
    pub(crate) fn format_option(&self, name: &str) -> Option<&str> {
        let options = self.get("format")?.split(';').skip(1);
        let mut pairs = options.filter_map(|option| option.split_once('='));
        pairs.find(|(key, _)| key.trim() == name).map(|(_, value)| value.trim())
    }

    /// The sensor and the facts that the lines state.
    pub(crate) fn header(&self) -> Header {
        let facts = FACTS.iter().filter_map(|&(name, keys)| {
            let value = keys.iter().find_map(|key| self.get(key).filter(|v| !v.is_empty()))?;
            Some((name, value.to_owned()))
        });
        Header { sensor: self.sensor(), usual_sensor: self.usual_sensor(), facts: facts.collect() }
    }

    /// The time that times count from, in microseconds: faery writes it.
    pub(crate) fn t0(&self) -> i64 {
        let stated = self.get("T0").or_else(|| self.get("t0"));
        stated.and_then(|t0| t0.parse().ok()).unwrap_or(0)
    }

    fn sensor(&self) -> Option<SensorSize> {
        let of_format = self.format_option("width").zip(self.format_option("height"));
        let of_geometry = self.get("geometry").and_then(|size| size.split_once('x'));
        let of_lines = self.get("Width").zip(self.get("Height"));
        [of_format, of_geometry, of_lines].into_iter().flatten().find_map(|(width, height)| {
            let number = |text: &str| text.trim().parse().ok().filter(|&n: &u16| n > 0);
            Some(SensorSize { width: number(width)?, height: number(height)? })
        })
    }

    /// The sensor of a generation, for files older than the line that states it.
    fn usual_sensor(&self) -> Option<SensorSize> {
        let generation = self.get("sensor_generation").or_else(|| self.get("generation"))?;
        match generation.split('.').next()? {
            "3" => Some(SensorSize { width: 640, height: 480 }),
            "4" => Some(SensorSize { width: 1280, height: 720 }),
            _ => None,
        }
    }
}

/// The bytes end before it is clear whether they are a line.
struct Unfinished;

/// The line at the beginning of `bytes`, without its end, if there is one.
fn line(bytes: &[u8]) -> Result<Option<&str>, Unfinished> {
    match bytes {
        [] | [b'%'] => return Err(Unfinished),
        [b'%', b' ' | b'\t', ..] => {}
        _ => return Ok(None),
    }
    let near = &bytes[..bytes.len().min(MAX_LINE)];
    // Binary data may begin with `%` as well: a line has no other control characters.
    let end = near.iter().position(|&b| b < b' ' && b != b'\t' && b != b'\r');
    match end {
        Some(end) if near[end] == b'\n' => Ok(str::from_utf8(&near[..end]).ok()),
        None if near.len() < MAX_LINE => Err(Unfinished),
        _ => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cameras_write_is_understood() {
        let text = b"% camera_integrator_name Prophesee\n% date 2023-03-29 16:37:46\n% evt 3.0\n\
            % format EVT3;height=720;width=1280\n% generation 4.2\n% geometry 1280x720\r\n\
            % serial_number 00ca0009\n% \n% a line of (another) vendor: x = 3\n% end\n%";
        let lines = Lines::parse(text);
        assert_eq!((lines.length, lines.is_open), (text.len() - 1, false));
        assert_eq!(lines.get("evt"), Some("3.0"));
        let header = lines.header();
        assert_eq!(header.sensor, Some(SensorSize { width: 1280, height: 720 }));
        let facts = [
            ("camera", "Prophesee"),
            ("chip", "4.2"),
            ("serial", "00ca0009"),
            ("date", "2023-03-29 16:37:46"),
        ];
        assert_eq!(header.facts, facts.map(|(name, value)| (name, value.to_owned())));
    }

    #[test]
    fn data_that_begin_with_a_percent_sign_are_no_line() {
        for data in [&b"% \x80\x12\n"[..], b"%\x80ab\n", b"%a\n", b"% \0\0\n", b"% \xff\xfe\n"] {
            let lines = Lines::parse(&[b"% evt 2.0\n", data].concat());
            assert_eq!((lines.length, lines.is_open), (10, false), "{data:?}");
        }
        assert!(Lines::parse(b"% evt 2.0\n% ge").is_open && Lines::parse(b"% evt 2.0\n").is_open);
    }

    #[test]
    fn a_header_longer_than_a_probe_sees_is_read_to_its_end() {
        let comment = format!("% {}\n", "x".repeat(3000));
        let text = comment.repeat(40) + "% geometry 640x480\n% end\n";
        let mut input = Input::memory("long", (text.clone() + "data").into_bytes());
        let lines = Lines::read(&mut input).map(|l| (l.length, l.header().sensor));
        assert_eq!(lines.ok(), Some((text.len(), Some(SensorSize { width: 640, height: 480 }))));
        let mut endless = Input::memory("endless", comment.repeat(400).into_bytes());
        assert!(matches!(Lines::read(&mut endless), Err(IoError::Damaged { .. })));
    }
}
