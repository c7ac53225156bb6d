//! Detection of the encoding of a file.

use super::content::{detect, detect_without_header, is_legacy};
use super::header::Lines;

/// An encoding of words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Evt2,
    Evt21 {
        /// Whether the upper half of a word comes first.
        is_legacy: bool,
    },
    Evt3,
    Evt4,
}

/// Systems from here on send EVT 2.1 with the lower half of a word first (OpenEB,
/// `psee_raw_file_header.cpp`).
const FIRST_LITTLE_SYSTEM: u32 = 0x37;

/// Keys of which every RAW header has some, and no other file has.
const KEYS: &[&str] = &[
    "camera_integrator_name",
    "firmware_version",
    "geometry",
    "integrator_name",
    "plugin_integrator_name",
    "plugin_name",
    "sensor_generation",
    "serial_number",
    "subsystem_ID",
    "system_ID",
];

impl Encoding {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Evt2 => "evt2",
            Self::Evt21 { .. } => "evt2.1",
            Self::Evt3 => "evt3",
            Self::Evt4 => "evt4",
        }
    }

    /// The encoding that a header states, or that is detected by the words behind it.
    pub(super) fn detect(lines: &Lines, data: &[u8]) -> Option<Self> {
        // An option may follow the name, behind a semicolon.
        let format = lines.get("format").and_then(|format| format.split(';').next());
        match (format, lines.get("evt")) {
            (Some("EVT2"), _) | (None, Some("2.0")) => Some(Self::Evt2),
            (Some("EVT3"), _) | (None, Some("3.0")) => Some(Self::Evt3),
            (Some("EVT4"), _) | (None, Some("4.0")) => Some(Self::Evt4),
            (Some("EVT21" | "EVT2.1"), _) | (None, Some("2.1")) => {
                let stated = lines.format_option("endianness").or_else(|| lines.get("endianness"));
                match stated {
                    Some("legacy") => Some(Self::Evt21 { is_legacy: true }),
                    Some("little") => Some(Self::Evt21 { is_legacy: false }),
                    // Big-endian words are documented, but no camera is known to record them.
                    Some(_) => None,
                    None => {
                        // Old files say nothing: the words decide, or else the camera's age.
                        let system = lines.get("system_ID").and_then(|id| id.parse().ok());
                        let is_old = system.is_some_and(|id: u32| id < FIRST_LITTLE_SYSTEM);
                        Some(Self::Evt21 { is_legacy: is_legacy(data).unwrap_or(is_old) })
                    }
                }
            }
            // Nothing says that this is a recording: its first word must be a high time as well.
            (None, None) if lines.is_empty() => detect_without_header(data),
            (None, None) => detect(data),
            _ => None,
        }
    }

    /// As [`Encoding::detect`], of the first bytes of a file. Where they are only the beginning of a
    /// header that does not say, EVT 3.0 stands for any.
    pub(super) fn detect_in_head(head: &[u8]) -> Option<Self> {
        let lines = Lines::parse(head);
        if crate::dat::is_dat(&lines, head) {
            return None;
        }
        let is_unknown = lines.get("format").or(lines.get("evt")).is_none();
        if lines.is_open && !lines.is_empty() && is_unknown {
            let is_raw = KEYS.iter().any(|key| lines.get(key).is_some());
            return is_raw.then_some(Self::Evt3);
        }
        Self::detect(&lines, &head[lines.length..])
    }
}
