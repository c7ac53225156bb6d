//! Writes MCAP of ROS 2: one topic of `event_camera_msgs/EventPacket`.
//!
//! Events are encoded as EVT 3.0, those of sensors beyond 2048 pixels as `mono`. Packets are of 10 ms at
//! most; their header and the times of MCAP are those of their first event, on the clock of the events.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, Micros, SensorSize};
use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};

use crate::evt::{Evt3Encoder, WordEncoder};
use crate::{EventSink, IoError};

/// Topic and frame of the packets.
const TOPIC: &str = "/event_camera/events";
const FRAME: &str = "event_camera";
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
    writer: Writer<AtomicFile>,
    channel: u16,
    sensor: SensorSize,
    /// None for sensors that EVT 3.0 has no words for.
    evt3: Option<Evt3Encoder>,
    packets: u32,
}

/// Begins a file.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    if sensor.height > MAX_MONO {
        let reason = format!("a sensor of {sensor}, and packets hold up to {MAX_MONO} rows");
        return Err(IoError::unwritable(path, reason));
    }
    let file = AtomicFile::create(path).map_err(|e| IoError::file(path, "create", e))?;
    // The compressors of the crate are C, and there only if another crate wants them.
    let options = WriteOptions::new().compression(None).profile("ros2").library("evpose");
    let begin = || {
        let mut writer = options.create(file)?;
        let name = "event_camera_msgs/msg/EventPacket";
        let schema = writer.add_schema(name, "ros2msg", DEFINITION.as_bytes())?;
        let channel = writer.add_channel(schema, TOPIC, "cdr", &BTreeMap::new())?;
        Ok((writer, channel))
    };
    let (writer, channel) = begin().map_err(|fault| failed(path, fault))?;
    let is_small = sensor.width <= MAX_EVT3 && sensor.height <= MAX_EVT3;
    let evt3 = is_small.then(|| Evt3Encoder::new(sensor));
    let path = path.to_owned();
    Ok(Box::new(McapSink { path, writer, channel, sensor, evt3, packets: 0 }))
}

fn failed(path: &Path, fault: McapError) -> IoError {
    match fault {
        McapError::Io(error) => IoError::file(path, "write", error),
        other => IoError::unwritable(path, other.to_string()),
    }
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
            self.packet(events, at..end)?;
            at = end;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        self.writer.finish().map_err(|fault| failed(&self.path, fault))?;
        let file = self.writer.into_inner();
        file.commit().map_err(|e| IoError::file(&self.path, "finish", e))
    }
}

impl McapSink {
    /// Writes a message of the events of a range that is not empty.
    fn packet(&mut self, events: &EventStream, range: Range<usize>) -> Result<(), IoError> {
        let unwritable = |reason: String| IoError::unwritable(&self.path, reason);
        let first = events.t()[range.start];
        let before_0 = || unwritable(format!("event at {} µs: times of ROS begin at 0", first.0));
        let stamp_ns = u64::try_from(first.0).ok().and_then(|us| us.checked_mul(1_000));
        let stamp_ns = stamp_ns.ok_or_else(before_0)?;
        let seconds = u32::try_from(stamp_ns / 1_000_000_000);
        let seconds = seconds.map_err(|_| unwritable("times beyond the year 2106".to_owned()))?;
        let mut encoded = Vec::new();
        let encoding: &[u8] = match &mut self.evt3 {
            Some(evt3) => {
                let (t, x) =
                    (events.t()[range.clone()].to_vec(), events.x()[range.clone()].to_vec());
                let y = events.y()[range.clone()].to_vec();
                let polarity = events.polarity()[range].to_vec();
                let some = EventStream::from_columns(self.sensor, t, x, y, polarity);
                let some = some.map_err(|_| unwritable("events out of order".to_owned()))?;
                evt3.encode(&some, &mut encoded).map_err(unwritable)?;
                b"evt3\0"
            }
            None => {
                for event in range.filter_map(|k| events.get(k)) {
                    let after_ns = (event.t.0 - first.0).cast_unsigned() * 1_000;
                    let pixel = u64::from(event.y) << 48 | u64::from(event.x) << 32;
                    let polarity = u64::from(event.polarity.is_on()) << 63;
                    encoded.extend((polarity | pixel | after_ns).to_le_bytes());
                }
                b"mono\0"
            }
        };
        let nanoseconds = (stamp_ns % 1_000_000_000) as u32;
        let SensorSize { width, height } = self.sensor;
        // CDR, whose numbers stand at multiples of their length behind the first four bytes.
        let mut message = Cdr(vec![0, 1, 0, 0]);
        message.u32(seconds);
        message.u32(nanoseconds);
        message.bytes(format!("{FRAME}\0").as_bytes());
        message.u32(height.into());
        message.u32(width.into());
        message.u64(self.packets.into());
        message.u64(stamp_ns);
        message.bytes(encoding);
        message.0.push(0);
        message.bytes(&encoded);
        let header = MessageHeader {
            channel_id: self.channel,
            sequence: self.packets,
            log_time: stamp_ns,
            publish_time: stamp_ns,
        };
        self.packets = self.packets.wrapping_add(1);
        let written = self.writer.write_to_known_channel(&header, &message.0);
        written.map_err(|fault| failed(&self.path, fault))
    }
}

/// A message on its way.
struct Cdr(Vec<u8>);

impl Cdr {
    fn align(&mut self, size: usize) {
        self.0.resize(4 + (self.0.len() - 4).next_multiple_of(size), 0);
    }

    fn u32(&mut self, value: u32) {
        self.align(size_of::<u32>());
        self.0.extend(value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.align(size_of::<u64>());
        self.0.extend(value.to_le_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.u32(bytes.len() as u32);
        self.0.extend_from_slice(bytes);
    }
}
