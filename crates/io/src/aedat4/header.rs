//! The header before the packets: their compression, and the list of streams.

use std::fmt;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use evpose_core::SensorSize;
use twox_hash::XxHash32;

use super::build::{Builder, Field};
use super::compression::Compression;
use super::flat::{Broken, Table, identifier};
use super::{MAGIC, xml};
use crate::{Input, IoError};

/// Content of the packets of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StreamKind {
    /// Events.
    Events,
    /// Frames.
    Frames,
    /// Samples of an inertial unit.
    Imu,
    /// Triggers.
    Triggers,
    /// Anything else, by its four letters.
    Other([u8; 4]),
}

impl StreamKind {
    /// The content of a four-letter type identifier.
    pub(super) fn from_identifier(letters: [u8; 4]) -> Self {
        match &letters {
            b"EVTS" => Self::Events,
            b"FRME" => Self::Frames,
            b"IMUS" => Self::Imu,
            b"TRIG" => Self::Triggers,
            _ => Self::Other(letters),
        }
    }

    /// The four letters.
    pub fn letters(self) -> [u8; 4] {
        match self {
            Self::Events => *b"EVTS",
            Self::Frames => *b"FRME",
            Self::Imu => *b"IMUS",
            Self::Triggers => *b"TRIG",
            Self::Other(letters) => letters,
        }
    }
}

impl fmt::Display for StreamKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Events => f.write_str("events"),
            Self::Frames => f.write_str("frames"),
            Self::Imu => f.write_str("imu"),
            Self::Triggers => f.write_str("triggers"),
            Self::Other(letters) => write!(f, "{}", letters.escape_ascii()),
        }
    }
}

/// A stream of packets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stream {
    /// Its number, which every packet carries.
    pub id: i32,
    /// Content of its packets.
    pub kind: StreamKind,
    /// Its name, such as `events`.
    pub name: String,
    /// The camera it is from, such as `DAVIS346_00000499`.
    pub source: String,
    /// Size of the sensor, where the file states it.
    pub size: Option<SensorSize>,
}

/// The header of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FileHeader {
    pub(super) compression: Compression,
    /// Offset of the data table, if there is one.
    pub(super) table: Option<u64>,
    /// Streams, in ascending order of their identifiers.
    pub(super) streams: Vec<Stream>,
    /// Offset of the first packet.
    pub(super) end: u64,
}

/// The four letters of its FlatBuffer.
pub(super) const IDENTIFIER: &[u8; 4] = b"IOHE";

/// A recording has some for each camera. Every packet is looked up among them.
pub(super) const MAX_STREAMS: usize = 256;

/// Reads a header.
pub(super) fn read(input: &mut Input) -> Result<FileHeader, IoError> {
    let start = MAGIC.len() as u64;
    let path = input.path.clone();
    let failed = |e| IoError::file(&path, "read", e);
    let (mut magic, mut bytes) = (Vec::new(), Vec::new());
    input.bytes.rewind().map_err(failed)?;
    (&mut input.bytes).take(start).read_to_end(&mut magic).map_err(failed)?;
    if magic != MAGIC {
        return Err(IoError::damaged(&path, 0, "the first line is not `#!AER-DAT4.0`"));
    }
    (&mut input.bytes).take(4).read_to_end(&mut bytes).map_err(failed)?;
    let cut = || IoError::damaged(&path, start, "the header is cut");
    let size = u64::from(u32::from_le_bytes(*bytes.first_chunk().ok_or_else(cut)?));
    let end = start + 4 + size;
    // Checked before reading: a size out of a broken file may be four gigabytes.
    if end > input.length {
        return Err(cut());
    }
    (&mut input.bytes).take(size).read_to_end(&mut bytes).map_err(failed)?;
    let header = parse(&path, start, &bytes)?;
    input.bytes.seek(SeekFrom::Start(end)).map_err(failed)?;
    Ok(header)
}

/// The header that a FlatBuffer is, behind its size, from byte `start` of a file on.
pub(super) fn parse(path: &Path, start: u64, bytes: &[u8]) -> Result<FileHeader, IoError> {
    let broken = |Broken { at, reason }: Broken| {
        IoError::damaged(path, start + at as u64, format!("the header: {reason}"))
    };
    if identifier(bytes).map_err(broken)? != *IDENTIFIER {
        return Err(IoError::damaged(path, start + 8, "the header is none"));
    }
    let table = Table::root(bytes).map_err(broken)?;
    let number = table.i32(0).map_err(broken)?;
    let known = usize::try_from(number).ok().and_then(|k| Compression::ALL.get(k));
    let unknown = || IoError::damaged(path, start, format!("compression {number} is not known"));
    let compression = *known.ok_or_else(unknown)?;
    // A recorder that was stopped has written -1: no data table.
    let place = table.i64(1).map_err(broken)?.unwrap_or(-1);
    let text = table.vector(2).map_err(broken)?.whole(1).map_err(broken)?;
    let text = String::from_utf8_lossy(text);
    if !has_its_sum(&text) {
        return Err(IoError::damaged(path, start, "the header: its checksum does not fit"));
    }
    let streams = streams(&text);
    let end = start + bytes.len() as u64;
    Ok(FileHeader { compression, table: u64::try_from(place).ok(), streams, end })
}

/// An attribute of our own among the facts of a stream, which other programs pass over: the XXH32
/// of all that stands before it.
const SUM: &str = "<attr key=\"xxh32\" type=\"string\">";

/// Whether an XML has no checksum, or the right one.
fn has_its_sum(text: &str) -> bool {
    let Some((before, behind)) = text.rsplit_once(SUM) else { return true };
    behind.starts_with(&sum(before))
}

fn sum(text: &str) -> String {
    format!("{:08x}<", XxHash32::oneshot(0, text.as_bytes()))
}

/// The streams that an XML names.
pub(super) fn streams(text: &str) -> Vec<Stream> {
    let mut streams: Vec<Stream> = Vec::new();
    let mut sizes: Vec<[Option<u16>; 2]> = Vec::new();
    xml::attributes(text, |nodes, key, text| {
        // Some programs keep settings of their own beside the identifiers of streams.
        let place = nodes.iter().position(|name| name == "outInfo");
        let (id, inner) = match place.map(|place| &nodes[place + 1..]) {
            Some([id]) => (id, None),
            Some([id, inner]) => (id, Some(inner)),
            _ => return,
        };
        let Ok(id) = id.parse() else { return };
        // A broken header may name any number of streams.
        if streams.len() == MAX_STREAMS && streams.iter().all(|stream| stream.id != id) {
            return;
        }
        let k = streams.iter().position(|stream| stream.id == id).unwrap_or_else(|| {
            let (name, source) = (String::new(), String::new());
            streams.push(Stream {
                id,
                kind: StreamKind::Other(*b"    "),
                name,
                source,
                size: None,
            });
            sizes.push([None; 2]);
            streams.len() - 1
        });
        let stream = &mut streams[k];
        match (inner.map(|name| &**name), key) {
            (None, "typeIdentifier") => {
                stream.kind = text
                    .as_bytes()
                    .as_array()
                    .map_or(stream.kind, |four| StreamKind::from_identifier(*four));
            }
            (None, "originalOutputName") => stream.name = text.to_owned(),
            (Some("info"), "source") => stream.source = text.to_owned(),
            (Some("info"), "sizeX") => sizes[k][0] = text.parse().ok(),
            (Some("info"), "sizeY") => sizes[k][1] = text.parse().ok(),
            _ => {}
        }
    });
    // A stream of which only one side is given has no size.
    for (stream, size) in streams.iter_mut().zip(sizes) {
        if let [Some(width @ 1..), Some(height @ 1..)] = size {
            stream.size = Some(SensorSize { width, height });
        }
    }
    // By number, as cameras are counted, whatever the order of the text.
    streams.sort_by_key(|stream| stream.id);
    streams
}

/// The bytes of a header, whose place of the table can be written later: they stay as many.
pub(super) fn bytes(compression: Compression, table: Option<u64>, streams: &[Stream]) -> Vec<u8> {
    let number = Compression::ALL.iter().position(|&other| other == compression);
    let mut builder = Builder::default();
    builder.begin(*IDENTIFIER);
    let place = builder.root(&[
        Field::Int(number.unwrap_or_default() as i32),
        Field::Long(table.map_or(-1, |place| place as i64)),
        Field::Next,
    ]);
    builder.string(place, &xml(compression, streams));
    [MAGIC, builder.finish()].concat()
}

fn xml(compression: Compression, streams: &[Stream]) -> String {
    let attribute = |key: &str, kind: &str, text: &str| {
        format!("<attr key=\"{key}\" type=\"{kind}\">{}</attr>\n", xml::escaped(text))
    };
    let mut text = "<dv version=\"2.0\">\n<node name=\"outInfo\" path=\"/outInfo/\">\n".to_owned();
    for Stream { id, kind, name, source, size } in streams {
        let letters = kind.letters();
        let letters = String::from_utf8_lossy(&letters);
        text += &format!("<node name=\"{id}\" path=\"/outInfo/{id}/\">\n");
        text += &attribute("compression", "string", compression.name());
        text += &attribute("originalModuleName", "string", "evpose");
        text += &attribute("originalOutputName", "string", name);
        text += &attribute("typeDescription", "string", &kind.to_string());
        text += &attribute("typeIdentifier", "string", &letters);
        text += &format!("<node name=\"info\" path=\"/outInfo/{id}/info/\">\n");
        if let Some(size) = size {
            text += &attribute("sizeX", "int", &size.width.to_string());
            text += &attribute("sizeY", "int", &size.height.to_string());
        }
        text += &attribute("source", "string", source);
        // It is the sum of all that stands before it, and so comes last.
        let sum = sum(&text);
        text += &format!("{SUM}{sum}/attr>\n</node>\n</node>\n");
    }
    text + "</node>\n</dv>\n"
}
