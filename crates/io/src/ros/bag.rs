//! ROS 1 bags, format 2.0: records of a header and data; messages stand in compressed chunks.
//!
//! A header is a list of fields `name=value`, of which `op` is the type of the record. Connections give
//! the topic and type of messages; those of the whole file stand behind its data, where the record at its
//! beginning says. A bag whose recorder was killed has none, and is read through once.
//!
//! The reader is our own: the crate `rosbag` needs three C libraries and has no places for damage.
//!
//! # Source
//! <https://wiki.ros.org/Bags/Format/2.0>

use std::collections::BTreeMap;
use std::io::Read;

use super::fields::{Reason, Serialisation};
use super::file::{
    Bytes, Fault, MessageFile, MessageVisitor, NextUnit, Topic, add_topic, to_the_end,
};
use crate::Input;
use crate::aedat4::{Compression, Inflater};

/// How the files begin.
pub(super) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Types of records.
const MESSAGE: u8 = 2;
const BAG: u8 = 3;
const CHUNK: u8 = 5;
const CHUNK_INFO: u8 = 6;
const CONNECTION: u8 = 7;
/// Bytes of a chunk that are believed.
const MAX_CHUNK: u64 = 1 << 28;

/// Takes a record of a connection or a message.
type RecordVisitor<'a> = dyn FnMut(&Head<'_>, &[u8]) -> Result<(), Reason> + 'a;

/// A ROS 1 bag.
pub(super) struct Bag {
    bytes: Bytes,
    body: Vec<u8>,
    inflater: Inflater,
    /// Once it is known.
    index: Option<Index>,
}

/// The record at the beginning.
#[derive(Debug, Clone, Copy)]
struct Index {
    /// Place of the connections behind the data; 0 if there are none.
    at: u64,
    /// Counts of connections and chunks.
    records: [u64; 2],
}

impl Bag {
    pub(super) fn new(input: Input) -> Self {
        let bytes = Bytes::new(input);
        Self { bytes, body: Vec::new(), inflater: Inflater::new(), index: None }
    }

    /// Visits the records of connections and messages of a unit; returns the place of the next.
    fn records(&mut self, at: u64, visit: &mut RecordVisitor<'_>) -> NextUnit {
        let damage = |reason: Reason| Fault::damage(at, reason);
        let index = self.index()?.at;
        match index {
            0 if at == self.bytes.length => return Ok(None),
            1.. if at >= index => return Ok(None),
            _ => {}
        }
        let (length, next) = self.record(at)?;
        let (head, data) = self.body.split_at(length);
        let head = Head::new(head).map_err(damage)?;
        // A recorder that was killed leaves a chunk of no length: its records stand behind it.
        if matches!(head.op, CONNECTION | MESSAGE) {
            visit(&head, data).map_err(damage)?;
        } else if head.op == CHUNK && !data.is_empty() {
            let compression = match head.get("compression") {
                Some(b"none") => Some(Compression::None),
                Some(b"lz4") => Some(Compression::Lz4),
                Some(b"bz2") => None,
                _ => return Err(damage("a chunk of an unknown compression".into())),
            };
            let mut unpacked = Vec::new();
            let records = match compression {
                Some(compression) => {
                    self.inflater.inflate(compression, data).map_err(damage)?;
                    self.inflater.out.filled()
                }
                None => {
                    let decoder = bzip2::read::BzDecoder::new(data);
                    let read = decoder.take(MAX_CHUNK).read_to_end(&mut unpacked);
                    read.map_err(|fault| damage(format!("bzip2: {fault}").into()))?;
                    &unpacked
                }
            };
            if head.number("size") != Some(records.len() as u64) {
                return Err(damage("a chunk does not have the size that it states".into()));
            }
            each(records, visit).map_err(damage)?;
        }
        Ok(Some(next))
    }

    /// Reads header and data of a record; returns the length of the header, and the next record.
    fn record(&mut self, at: u64) -> Result<(usize, u64), Fault> {
        let mut length = |bytes: &mut Bytes, place: u64| {
            bytes.read((at, place), 4, &mut self.body)?;
            Ok(u64::from(u32_of(&self.body)))
        };
        let head = length(&mut self.bytes, at)?;
        let data = length(&mut self.bytes, at + 4 + head)?;
        let mut rest = Vec::new();
        self.bytes.read((at, at + 4), head, &mut self.body)?;
        self.bytes.read((at, at + 8 + head), data, &mut rest)?;
        self.body.append(&mut rest);
        Ok((head as usize, at + 8 + head + data))
    }

    /// Reads the record at the beginning, once.
    fn index(&mut self) -> Result<Index, Fault> {
        if let Some(index) = self.index {
            return Ok(index);
        }
        let begin = self.begin();
        let (length, _) = self.record(begin)?;
        let head = Head::new(&self.body[..length]).map_err(|fault| Fault::damage(begin, fault))?;
        let count = |name| head.number(name).filter(|_| head.op == BAG);
        let places = count("index_pos").zip(count("conn_count").zip(count("chunk_count")));
        let no_header = || Fault::damage(begin, "the bag has no header");
        let (at, (connections, chunks)) = places.ok_or_else(no_header)?;
        let index = Index { at, records: [connections, chunks] };
        self.index = Some(index);
        Ok(index)
    }

    /// Topics as the records behind the data say; none where there are none.
    fn summary(&mut self) -> Option<Vec<Topic>> {
        let Index { mut at, records } = self.index().ok().filter(|index| index.at > 0)?;
        let (mut connections, mut found) = (Connections::default(), [0, 0]);
        while at < self.bytes.length {
            let (length, next) = self.record(at).ok()?;
            let (head, data) = self.body.split_at(length);
            let head = Head::new(head).ok()?;
            found[0] += u64::from(head.op == CONNECTION);
            found[1] += u64::from(head.op == CHUNK_INFO);
            connections.add(&head, data);
            at = next;
        }
        // What is left of a cut one may lack the topic of events.
        (found == records).then(|| connections.topics())
    }
}

impl MessageFile for Bag {
    fn kind(&self) -> &'static str {
        "bag of ROS 1"
    }

    fn topics(&mut self) -> (Vec<Topic>, Option<Fault>) {
        if let Some(topics) = self.summary() {
            return (topics, None);
        }
        let mut connections = Connections::default();
        let fault = to_the_end(self.begin(), |at| {
            self.records(at, &mut |head, data| {
                connections.add(head, data);
                Ok(())
            })
        });
        (connections.topics(), fault)
    }

    fn begin(&self) -> u64 {
        MAGIC.len() as u64
    }

    fn unit(&mut self, at: u64, ids: &[u32], take: &mut MessageVisitor<'_>) -> NextUnit {
        self.records(at, &mut |head, data| match head.connection() {
            Some(connection) if head.op == MESSAGE && ids.contains(&connection) => take(data),
            _ => Ok(()),
        })
    }
}

/// The header of a record.
struct Head<'a> {
    fields: Vec<(&'a [u8], &'a [u8])>,
    op: u8,
}

impl<'a> Head<'a> {
    fn new(mut bytes: &'a [u8]) -> Result<Self, Reason> {
        let mut fields = Vec::new();
        while !bytes.is_empty() {
            let field = sized(&mut bytes).ok_or("a header ends within a field")?;
            let sign = field.iter().position(|byte| *byte == b'=');
            let sign = sign.ok_or("a field of a header without a value")?;
            fields.push((&field[..sign], &field[sign + 1..]));
        }
        let mut head = Self { fields, op: 0 };
        head.op = head.get("op").and_then(|op| op.first().copied()).unwrap_or(0);
        Ok(head)
    }

    fn get(&self, name: &str) -> Option<&'a [u8]> {
        self.fields.iter().find(|(field, _)| *field == name.as_bytes()).map(|(_, value)| *value)
    }

    /// A whole number of up to eight bytes.
    fn number(&self, name: &str) -> Option<u64> {
        let value = self.get(name)?;
        let mut bytes = [0; 8];
        bytes.get_mut(..value.len())?.copy_from_slice(value);
        Some(u64::from_le_bytes(bytes))
    }

    fn connection(&self) -> Option<u32> {
        self.number("conn")?.try_into().ok()
    }

    fn text(&self, name: &str) -> String {
        self.get(name).map(String::from_utf8_lossy).unwrap_or_default().into_owned()
    }
}

/// Topics and types of a file by the number of their connection, and how many messages they have.
#[derive(Default)]
struct Connections {
    topics: BTreeMap<u32, (String, String)>,
    counts: BTreeMap<u32, u64>,
}

impl Connections {
    fn add(&mut self, head: &Head<'_>, data: &[u8]) {
        match (head.op, head.connection()) {
            (MESSAGE, Some(connection)) => *self.counts.entry(connection).or_insert(0) += 1,
            (CONNECTION, Some(connection)) => {
                let kind = Head::new(data).map(|fields| fields.text("type")).unwrap_or_default();
                self.topics.insert(connection, (head.text("topic"), kind));
            }
            (CHUNK_INFO, _) => {
                // Counts by connection: an index spares reading the messages.
                let (pairs, _) = data.as_chunks::<8>();
                for pair in pairs {
                    let messages = self.counts.entry(u32_of(pair)).or_insert(0);
                    *messages += u64::from(u32_of(&pair[4..]));
                }
            }
            _ => {}
        }
    }

    fn topics(self) -> Vec<Topic> {
        let mut topics = Vec::new();
        for (id, (name, kind)) in self.topics {
            let messages = self.counts.get(&id).copied().unwrap_or(0);
            let serialisation = Serialisation::Ros1;
            add_topic(&mut topics, Topic { name, kind, serialisation, ids: vec![id], messages });
        }
        topics
    }
}

fn u32_of(bytes: &[u8]) -> u32 {
    bytes.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

/// Takes bytes whose length stands before them.
fn sized<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = bytes.split_off(..4)?;
    bytes.split_off(..u32_of(length) as usize)
}

/// Visits the records of a chunk.
fn each(mut records: &[u8], visit: &mut RecordVisitor<'_>) -> Result<(), Reason> {
    while !records.is_empty() {
        let pair = sized(&mut records).zip(sized(&mut records));
        let (head, data) = pair.ok_or("a chunk ends within a record")?;
        visit(&Head::new(head)?, data)?;
    }
    Ok(())
}
