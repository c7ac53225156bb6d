//! Writes MCAP of ROS 2: one topic of `event_camera_msgs/EventPacket`.
//!
//! Events are encoded as EVT 3.0, those of sensors beyond 2048 pixels and with times of the calendar, for
//! which EVT 3.0 has no words, as `mono`. Packets are of 10 ms at
//! most; their header and the times of MCAP are those of their first event, on the clock of the events.

use std::io::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, Micros, SensorSize};

use super::mcap::{
    CHANNEL, CHUNK, CHUNK_INDEX, DATA_END, FOOTER, HEADER, MAGIC, MESSAGE, MESSAGE_INDEX, SCHEMA,
    STATISTICS,
};
use super::source::CALENDAR_US;
use crate::evt::{Evt3Encoder, WordEncoder};
use crate::{EventSink, IoError};

/// Topic and frame of the packets.
const TOPIC: &str = "/event_camera/events";
const FRAME: &str = "event_camera";
/// Identifier of the only schema and of the only channel.
const ID: u16 = 1;
/// Bytes from which on a chunk of messages is written.
const CHUNK_BYTES: usize = 1 << 20;
/// Longest packet, and most events of one.
const PACKET_US: i64 = 10_000;
const EVENTS: usize = 1 << 14;
/// Columns and rows that words of EVT 3.0 hold, and rows that `mono` does.
const MAX_EVT3: u16 = 1 << 11;
const MAX_MONO: u16 = 1 << 15;
/// Definition of the messages, with those that they refer to.
const DEFINITION: &str = "\
std_msgs/Header header
uint32 height
uint32 width
uint64 seq
uint64 time_base
string encoding
bool is_bigendian
uint8[] events
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

struct McapSink {
    path: PathBuf,
    file: AtomicFile,
    /// Bytes written so far.
    at: u64,
    sensor: SensorSize,
    /// None for sensors and times that EVT 3.0 has no words for.
    evt3: Option<Evt3Encoder>,
    packets: u32,
    /// Records of the chunk to come, time and place of each message in it.
    chunk: Bytes,
    index: Vec<(u64, u64)>,
    /// Records about the chunks so far, and the times of the first and the last message.
    chunks: Vec<Bytes>,
    span_ns: Option<(u64, u64)>,
}

/// Begins a file.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    if sensor.height > MAX_MONO {
        let reason = format!("a sensor of {sensor}, and packets hold up to {MAX_MONO} rows");
        return Err(IoError::unwritable(path, reason));
    }
    let file = AtomicFile::create(path).map_err(|e| IoError::file(path, "create", e))?;
    // Words of EVT 3.0 have 11 bits for a coordinate.
    let is_small = sensor.width <= MAX_EVT3 && sensor.height <= MAX_EVT3;
    let mut sink = McapSink {
        path: path.to_owned(),
        file,
        at: 0,
        sensor,
        evt3: is_small.then(|| Evt3Encoder::new(sensor)),
        packets: 0,
        chunk: schema_and_channel(),
        index: Vec::new(),
        chunks: Vec::new(),
        span_ns: None,
    };
    let mut begin = Bytes(MAGIC.to_vec());
    begin.record(HEADER, Bytes::default().text("ros2").text("evpose"));
    sink.put(&begin)?;
    Ok(Box::new(sink))
}

/// Records of the type of the messages and of their topic.
fn schema_and_channel() -> Bytes {
    let mut records = Bytes::default();
    let schema = Bytes::default().u16(ID).text("event_camera_msgs/msg/EventPacket");
    records.record(SCHEMA, schema.text("ros2msg").text(DEFINITION));
    // Without metadata.
    let channel = Bytes::default().u16(ID).u16(ID).text(TOPIC).text("cdr").u32(0);
    records.record(CHANNEL, channel);
    records
}

impl EventSink for McapSink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        if let Some(event) = events.iter().find(|event| !self.sensor.contains(event.x, event.y)) {
            let reason = format!("event at ({}, {}) of {}", event.x, event.y, self.sensor);
            return Err(IoError::unwritable(&self.path, reason));
        }
        let (times, mut at) = (events.t(), 0);
        while let Some(first) = times.get(at) {
            let last = Micros(first.0.saturating_add(PACKET_US));
            let some = &times[at..times.len().min(at + EVENTS)];
            let end = at + some.partition_point(|t| *t < last);
            self.packet(*first, events, at..end)?;
            at = end;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        if self.packets == 0 {
            // Messages alone state the size of the sensor.
            self.packet(Micros(0), &EventStream::empty(self.sensor), 0..0)?;
        }
        self.write_chunk()?;
        let mut end = Bytes::default();
        // Checksums of 0 are none: chunks have theirs.
        end.record(DATA_END, Bytes::default().u32(0));
        let summary = self.at + end.0.len() as u64;
        end.0.extend(schema_and_channel().0);
        let messages = u64::from(self.packets);
        let (first, last) = self.span_ns.unwrap_or((0, 0));
        // One schema and one channel, neither attachments nor metadata.
        let counts = Bytes::default().u64(messages).u16(1).u32(1).u32(0).u32(0);
        let counts = counts.u32(self.chunks.len() as u32).u64(first).u64(last);
        end.record(STATISTICS, counts.u32(10).u16(ID).u64(messages));
        for chunk in std::mem::take(&mut self.chunks) {
            end.record(CHUNK_INDEX, chunk);
        }
        end.record(FOOTER, Bytes::default().u64(summary).u64(0).u32(0));
        end.0.extend_from_slice(MAGIC);
        self.put(&end)?;
        self.file.commit().map_err(|e| IoError::file(&self.path, "finish", e))
    }
}

impl McapSink {
    fn put(&mut self, bytes: &Bytes) -> Result<(), IoError> {
        self.file.write_all(&bytes.0).map_err(|e| IoError::file(&self.path, "write", e))?;
        self.at += bytes.0.len() as u64;
        Ok(())
    }

    /// Writes the messages that wait, and the index of their places.
    fn write_chunk(&mut self) -> Result<(), IoError> {
        let (Some((first, _)), Some((last, _))) = (self.index.first(), self.index.last()) else {
            return Ok(());
        };
        let (first, last) = (*first, *last);
        let records = std::mem::take(&mut self.chunk).0;
        let length = records.len() as u64;
        let mut chunk = Bytes::default();
        let body = Bytes::default().u64(first).u64(last).u64(length).u32(crc32fast::hash(&records));
        // Not packed: an empty name of the compression.
        chunk.record(CHUNK, body.text("").u64(length).bytes(&records));
        let (chunk_at, chunk_length) = (self.at, chunk.0.len() as u64);
        let places = self
            .index
            .drain(..)
            .fold(Bytes::default(), |places, (time, place)| places.u64(time).u64(place));
        chunk.record(MESSAGE_INDEX, Bytes::default().u16(ID).sized(&places.0));
        let index_length = chunk.0.len() as u64 - chunk_length;
        let about = Bytes::default().u64(first).u64(last).u64(chunk_at).u64(chunk_length);
        let about = about.u32(10).u16(ID).u64(chunk_at + chunk_length).u64(index_length);
        self.chunks.push(about.text("").u64(length).u64(length));
        self.span_ns = Some((self.span_ns.map_or(first, |(first, _)| first), last));
        self.put(&chunk)
    }

    /// Writes a message of the events of a range, which begins at this time.
    fn packet(
        &mut self,
        first: Micros,
        events: &EventStream,
        range: Range<usize>,
    ) -> Result<(), IoError> {
        let unwritable = |reason: String| IoError::unwritable(&self.path, reason);
        let before_0 = || unwritable(format!("event at {} µs: times of ROS begin at 0", first.0));
        let stamp_ns = u64::try_from(first.0).ok().and_then(|us| us.checked_mul(1_000));
        let stamp_ns = stamp_ns.ok_or_else(before_0)?;
        let seconds = i32::try_from(stamp_ns / 1_000_000_000);
        let seconds = seconds.map_err(|_| unwritable("times beyond the year 2038".to_owned()))?;
        if first.0 >= CALENDAR_US {
            self.evt3 = None;
        }
        let mut encoded = Vec::new();
        let encoding = match &mut self.evt3 {
            Some(evt3) => {
                let (t, x) =
                    (events.t()[range.clone()].to_vec(), events.x()[range.clone()].to_vec());
                let y = events.y()[range.clone()].to_vec();
                let polarity = events.polarity()[range].to_vec();
                let some = EventStream::from_columns(self.sensor, t, x, y, polarity);
                let some = some.map_err(|_| unwritable("events out of order".to_owned()))?;
                evt3.encode(&some, &mut encoded).map_err(|e| unwritable(e.to_string()))?;
                "evt3\0"
            }
            None => {
                for event in range.filter_map(|k| events.get(k)) {
                    let after_ns = (event.t.0 - first.0).cast_unsigned() * 1_000;
                    let pixel = u64::from(event.y) << 48 | u64::from(event.x) << 32;
                    let polarity = u64::from(event.polarity.is_on()) << 63;
                    encoded.extend((polarity | pixel | after_ns).to_le_bytes());
                }
                "mono\0"
            }
        };
        let nanoseconds = (stamp_ns % 1_000_000_000) as u32;
        let SensorSize { width, height } = self.sensor;
        // CDR, whose values stand at multiples of their length behind the first four bytes.
        let message = Bytes(vec![0, 1, 0, 0]).u32(seconds.cast_unsigned()).u32(nanoseconds);
        let message = message.text(&format!("{FRAME}\0")).align(4).u32(height.into());
        let message = message.u32(width.into()).align(8).u64(self.packets.into()).u64(stamp_ns);
        // The text, and that the machine is little-endian.
        let message = message.text(encoding).bytes(&[0]).align(4).sized(&encoded);
        self.index.push((stamp_ns, self.chunk.0.len() as u64));
        let head = Bytes::default().u16(ID).u32(self.packets).u64(stamp_ns).u64(stamp_ns);
        self.chunk.record(MESSAGE, head.bytes(&message.0));
        self.packets = self.packets.wrapping_add(1);
        if self.chunk.0.len() >= CHUNK_BYTES { self.write_chunk() } else { Ok(()) }
    }
}

/// Bytes of records and messages, little-endian.
#[derive(Debug, Default)]
pub(super) struct Bytes(pub(super) Vec<u8>);

impl Bytes {
    pub(super) fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.extend_from_slice(bytes);
        self
    }

    pub(super) fn u16(self, value: u16) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    pub(super) fn u32(self, value: u32) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    pub(super) fn u64(self, value: u64) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    /// Bytes behind their length.
    pub(super) fn sized(self, bytes: &[u8]) -> Self {
        self.u32(bytes.len() as u32).bytes(bytes)
    }

    pub(super) fn text(self, text: &str) -> Self {
        self.sized(text.as_bytes())
    }

    /// Zeros up to a multiple of `size` behind the first four bytes.
    pub(super) fn align(mut self, size: usize) -> Self {
        self.0.resize(4 + (self.0.len() - 4).next_multiple_of(size), 0);
        self
    }

    /// Appends a record.
    pub(super) fn record(&mut self, kind: u8, body: Self) {
        self.0.push(kind);
        self.0.extend((body.0.len() as u64).to_le_bytes());
        self.0.extend(body.0);
    }
}
