//! The lines before the first record, which describe the camera.

use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};

use evpose_core::SensorSize;

use crate::{Input, IoError, OpenOptions};

/// Maximal length of a line; no line of jAER's preferences is longer.
const MAX_LINE: u64 = 1 << 20;

/// Packing of an event into an address, by chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    Davis,
    Dvs128,
    Dvs640,
}

/// Sensors by a part of the lower-case name of their chip. The first match is taken.
const CHIPS: &[(&str, Layout, SensorSize)] = &[
    ("davis346", Layout::Davis, DAVIS346),
    ("davis240", Layout::Davis, SensorSize::DAVIS240C),
    ("sbret", Layout::Davis, SensorSize::DAVIS240C),
    ("davis208", Layout::Davis, size(208, 192)),
    ("davis128", Layout::Davis, size(128, 128)),
    ("davis640", Layout::Davis, DVS640),
    ("dvs128", Layout::Dvs128, DVS128),
    ("tmpdiff128", Layout::Dvs128, DVS128),
    ("dvs640", Layout::Dvs640, DVS640),
];

const DVS128: SensorSize = size(128, 128);
const DAVIS346: SensorSize = size(346, 260);
const DVS640: SensorSize = size(640, 480);

const fn size(width: u16, height: u16) -> SensorSize {
    SensorSize { width, height }
}

/// Camera, layout and date that the header of a file states.
#[derive(Debug, Clone)]
pub(super) struct Recorder {
    /// Offset of the first record.
    pub(super) start: u64,
    /// Bytes of an address.
    pub(super) address: usize,
    pub(super) layout: Layout,
    pub(super) sensor: SensorSize,
    /// Whether the sensor follows from the chip that the file states.
    pub(super) is_stated: bool,
    /// Whether addresses hold the index of a camera.
    pub(super) has_cameras: bool,
    chip: Option<String>,
    date: Option<String>,
}

impl Recorder {
    /// Reads the lines of a file.
    ///
    /// # Errors
    /// If they cannot be read, or name a chip whose sensor is neither known nor given.
    pub(super) fn read(input: &mut Input, options: &OpenOptions) -> Result<Self, IoError> {
        let failed = |path: &_, e| IoError::file(path, "read", e);
        let (mut chip, mut chip_at, mut date) = (None, 0, None);
        let (mut start, mut address) = (0, 4);
        input.bytes.rewind().map_err(|e| failed(&input.path, e))?;
        let mut bytes = BufReader::new(&mut input.bytes);
        let mut line = Vec::new();
        loop {
            line.clear();
            // Limited, so that a file without line breaks is not read into memory as one line.
            let read = (&mut bytes).take(MAX_LINE).read_until(b'\n', &mut line);
            read.map_err(|e| failed(&input.path, e))?;
            // What is no comment is data: the header ends before it, with or without its last line.
            let Some(text) = text_of(&line) else { break };
            if line.len() as u64 == MAX_LINE {
                let reason = "a line longer than any of a header";
                return Err(IoError::damaged(&input.path, start, reason));
            }
            if let Some(version) = text.strip_prefix("!AER-DAT") {
                address = if version.starts_with('1') { 2 } else { 4 };
            } else if let Some(name) = text.strip_prefix("AEChip:") {
                // The name of a Java class: drop its packages.
                let name = name.trim().rsplit('.').next().unwrap_or_default();
                if chip.is_none() {
                    (chip, chip_at) = (Some(name.to_owned()), start);
                }
            } else if let Some(when) =
                ["Creation date:", "created"].iter().find_map(|name| text.strip_prefix(name))
            {
                date.get_or_insert_with(|| when.trim().to_owned());
            }
            start += line.len() as u64;
            if text.eq_ignore_ascii_case("end of ascii header") {
                break;
            }
        }
        let path = input.path.clone();
        let unknown = |name: &str| {
            let reason = format!("the sensor of the chip {name} is not known: give its size");
            IoError::damaged(&path, chip_at, reason)
        };
        let lower = chip.as_deref().map(str::to_ascii_lowercase);
        let known =
            lower.as_ref().and_then(|name| CHIPS.iter().find(|(part, ..)| name.contains(part)));
        // A known chip is right about its own size, whatever is given.
        let (layout, sensor) = match (known, options.sensor) {
            (Some(&(_, layout, sensor)), _) => (layout, sensor),
            (None, Some(given)) => (layout_of(given), given),
            (None, None) if chip.is_some() => {
                return Err(unknown(chip.as_deref().unwrap_or_default()));
            }
            (None, None) => guess(&bytes_at(input, start, super::FIRST)?, address),
        };
        let is_davis = layout == Layout::Davis;
        if is_davis && address == 2 {
            // Addresses of a DAVIS have four bytes.
            return Err(unknown("of a DAVIS in a file of version 1.0"));
        }
        let has_cameras = is_davis && lower.is_some_and(|name| name.starts_with("multi"));
        let is_stated = known.is_some();
        Ok(Self { start, address, layout, sensor, is_stated, has_cameras, chip, date })
    }

    /// Facts of the header for descriptions of the file.
    pub(super) fn facts(&self, camera: Option<u8>) -> Vec<(&'static str, String)> {
        let chip = self.chip.clone().unwrap_or_else(|| "not stated".to_owned());
        let mut facts = vec![("chip", chip)];
        facts.extend(camera.map(|camera| ("camera", camera.to_string())));
        facts.extend(self.date.clone().map(|date| ("recorded", date)));
        facts
    }
}

/// Address layout of an unknown camera, by its sensor.
fn layout_of(sensor: SensorSize) -> Layout {
    match sensor {
        DVS128 => Layout::Dvs128,
        DVS640 => Layout::Dvs640,
        _ => Layout::Davis,
    }
}

/// The camera of a file that names none, by the bits that its first addresses use and, of a DAVIS,
/// by the smaller sensor that holds their events.
fn guess(first: &[u8], address: usize) -> (Layout, SensorSize) {
    if address == 2 {
        return (Layout::Dvs128, DVS128);
    }
    let records = first.as_chunks::<8>().0.iter();
    let addresses = records.map(|&[a, b, c, d, ..]| u32::from_be_bytes([a, b, c, d]));
    // The highest bit marks frames and motion sensors, whose other bits are no coordinates.
    let events = addresses.filter(|address| address >> 31 == 0);
    let (mut bits, mut x, mut y) = (0, 0, 0);
    for address in events {
        bits |= address;
        (x, y) = (x.max(address >> 12 & 0x3ff), y.max(address >> 22));
    }
    match bits {
        0..0x1_0000 => (Layout::Dvs128, DVS128),
        0x1_0000..0x20_0000 => (Layout::Dvs640, DVS640),
        _ if x < 240 && y < 180 => (Layout::Davis, SensorSize::DAVIS240C),
        _ => (Layout::Davis, DAVIS346),
    }
}

/// The text of a line of the header, if it is one: an address may well begin with the byte of a
/// `#`, but a record holds bytes that no text does. A file that is cut may end within a line.
fn text_of(line: &[u8]) -> Option<&str> {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    let line = line.strip_suffix(b"\r").unwrap_or(line).strip_prefix(b"#")?;
    let is_text = line.iter().all(|&b| b >= b' ' || b == b'\t');
    let text = str::from_utf8(line).unwrap_or_default();
    is_text.then_some(text.trim())
}

/// Reads up to `max` bytes of a file from `start` on.
pub(super) fn bytes_at(input: &mut Input, start: u64, max: usize) -> Result<Vec<u8>, IoError> {
    let mut bytes = Vec::new();
    let sought = input.bytes.seek(SeekFrom::Start(start));
    let read = sought.and_then(|_| (&mut input.bytes).take(max as u64).read_to_end(&mut bytes));
    read.map_err(|e| IoError::file(&input.path, "read", e))?;
    Ok(bytes)
}
