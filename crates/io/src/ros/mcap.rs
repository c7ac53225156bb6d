//! MCAP: records of a type, a length and a body; messages stand among them or in compressed chunks.
//!
//! Fields of records are written as in ROS 1: without gaps, little-endian, lengths before texts. The reader is our
//! own: of fifteen types of records it needs five, and the crate `mcap` brings twelve more crates, one of them
//! unmaintained, into every build.
//!
//! # Source
//! <https://mcap.dev/spec>

use std::collections::BTreeMap;

use super::fields::{Fields, Reason, Serialisation};
use super::file::{
    Bytes, Fault, MessageFile, MessageVisitor, NextUnit, Topic, add_topic, to_the_end,
};
use crate::Input;
use crate::aedat4::{Compression, Inflater};

/// How the files begin and end.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Types of records.
pub(super) const HEADER: u8 = 1;
pub(super) const FOOTER: u8 = 2;
pub(super) const SCHEMA: u8 = 3;
pub(super) const CHANNEL: u8 = 4;
pub(super) const MESSAGE: u8 = 5;
pub(super) const CHUNK: u8 = 6;
pub(super) const MESSAGE_INDEX: u8 = 7;
pub(super) const CHUNK_INDEX: u8 = 8;
pub(super) const STATISTICS: u8 = 11;
pub(super) const DATA_END: u8 = 15;
/// Bytes of a record's type and length, and of the end of a file: footer and mark.
const HEAD: u64 = 9;
const END: u64 = HEAD + 20 + MAGIC.len() as u64;
/// Bytes before the content of a message.
const MESSAGE_HEAD: usize = 22;

/// Takes a record.
type RecordVisitor<'a> = dyn FnMut(Record<'_>) -> Result<(), Reason> + 'a;

/// An MCAP file.
pub(super) struct Mcap {
    bytes: Bytes,
    head: Vec<u8>,
    body: Vec<u8>,
    inflater: Inflater,
}

impl Mcap {
    pub(super) fn new(input: Input) -> Self {
        let (head, body) = (Vec::new(), Vec::new());
        Self { bytes: Bytes::new(input), head, body, inflater: Inflater::new() }
    }

    /// Visits the records of schemas, channels and messages of a unit; returns the place of the next.
    fn records(&mut self, at: u64, visit: &mut RecordVisitor<'_>) -> NextUnit {
        let damage = |reason: Reason| Fault::damage(at, reason);
        if at >= self.bytes.length {
            return Err(damage("the file ends before the end of its data".into()));
        }
        self.bytes.read((at, at), HEAD, &mut self.head)?;
        let (kind, length) = (self.head[0], u64_of(&self.head[1..]));
        match kind {
            0 => return Err(damage("no record begins here".into())),
            DATA_END | FOOTER => return Ok(None),
            SCHEMA | CHANNEL | MESSAGE => {
                self.bytes.read((at, at + HEAD), length, &mut self.body)?;
                visit(Record::new(kind, &self.body).map_err(damage)?).map_err(damage)?;
            }
            CHUNK => {
                self.bytes.read((at, at + HEAD), length, &mut self.body)?;
                let chunk = Chunk::new(&self.body).map_err(damage)?;
                let compression = match chunk.compression {
                    "" => Compression::None,
                    "lz4" => Compression::Lz4,
                    "zstd" => Compression::Zstd,
                    other => return Err(damage(format!("a chunk packed by `{other}`").into())),
                };
                // Before a fault in a chunk nothing of it counts: its checksum is that of the whole.
                self.inflater.inflate(compression, chunk.records).map_err(damage)?;
                let records = self.inflater.out.filled();
                if chunk.crc != 0 && chunk.crc != crc32fast::hash(records) {
                    return Err(damage("the checksum of a chunk does not fit".into()));
                }
                each(records, visit).map_err(damage)?;
            }
            // What is passed over has to be there all the same.
            _ if length > self.bytes.length.saturating_sub(at + HEAD) => {
                return Err(damage("the file ends within a record".into()));
            }
            _ => {}
        }
        Ok(Some(at + HEAD + length))
    }

    /// Topics as the summary behind the data says; none where it does not.
    fn summary(&mut self) -> Option<Vec<Topic>> {
        let end = self.bytes.length.checked_sub(END)?;
        self.bytes.read((end, end), END, &mut self.body).ok()?;
        let foot = self.body.strip_suffix(MAGIC)?;
        let (FOOTER, body) = (*foot.first()?, foot.get(HEAD as usize..)?) else { return None };
        let start = u64_of(body);
        // A start of 0 means that the recorder wrote no summary.
        let length = end.checked_sub(start).filter(|_| start > 0)?;
        self.bytes.read((start, start), length, &mut self.body).ok()?;
        let mut index = Index::default();
        each(&self.body, &mut |record| {
            index.add(record);
            Ok(())
        })
        .ok()?;
        index.is_whole().then(|| index.topics())
    }
}

impl MessageFile for Mcap {
    fn kind(&self) -> &'static str {
        "MCAP"
    }

    fn topics(&mut self) -> (Vec<Topic>, Option<Fault>) {
        if let Some(topics) = self.summary() {
            return (topics, None);
        }
        // A recorder that was killed leaves none: the messages themselves are counted.
        let mut index = Index::default();
        let fault = to_the_end(self.begin(), |at| {
            self.records(at, &mut |record| {
                index.add(record);
                Ok(())
            })
        });
        (index.topics(), fault)
    }

    fn begin(&self) -> u64 {
        MAGIC.len() as u64
    }

    fn unit(&mut self, at: u64, ids: &[u32], take: &mut MessageVisitor<'_>) -> NextUnit {
        self.records(at, &mut |record| match record {
            Record::Message { channel, data } if ids.contains(&u32::from(channel)) => take(data),
            _ => Ok(()),
        })
    }
}

/// A record, as far as it is read.
enum Record<'a> {
    Schema {
        id: u16,
        name: &'a str,
    },
    Channel {
        id: u16,
        channel: Channel,
    },
    Message {
        channel: u16,
        data: &'a [u8],
    },
    /// Messages of all channels, and of each.
    Statistics {
        messages: u64,
        of_channels: BTreeMap<u16, u64>,
    },
}

struct Channel {
    schema: u16,
    topic: String,
    serialisation: Serialisation,
}

impl<'a> Record<'a> {
    /// A record of a schema, a channel, a message or statistics.
    fn new(kind: u8, body: &'a [u8]) -> Result<Self, Reason> {
        let mut fields = Fields::new(body, Serialisation::Ros1)?;
        if kind == STATISTICS {
            let messages = fields.u64()?;
            // Counts of schemas, channels, attachments, metadata and chunks; first and last time.
            fields.skip(2 + 4 * 4 + 2 * 8)?;
            let counts = fields.bytes()?.as_chunks::<10>().0.iter();
            let of_channels = counts.map(|count| (u16_of(count), u64_of(&count[2..]))).collect();
            return Ok(Self::Statistics { messages, of_channels });
        }
        let id = fields.u16()?;
        Ok(match kind {
            SCHEMA => Self::Schema { id, name: fields.text()? },
            CHANNEL => {
                let (schema, topic) = (fields.u16()?, fields.text()?.to_owned());
                let serialisation = match fields.text()? {
                    "ros1" => Serialisation::Ros1,
                    _ => Serialisation::Cdr,
                };
                Self::Channel { id, channel: Channel { schema, topic, serialisation } }
            }
            _ => {
                fields.skip(MESSAGE_HEAD - size_of::<u16>())?;
                Self::Message { channel: id, data: &body[MESSAGE_HEAD..] }
            }
        })
    }
}

/// A chunk of records.
struct Chunk<'a> {
    crc: u32,
    compression: &'a str,
    records: &'a [u8],
}

impl<'a> Chunk<'a> {
    fn new(body: &'a [u8]) -> Result<Self, Reason> {
        let mut fields = Fields::new(body, Serialisation::Ros1)?;
        // First and last time, and the length of the records when they are unpacked.
        fields.skip(3 * 8)?;
        let (crc, compression, length) = (fields.u32()?, fields.text()?, fields.u64()?);
        let rest = &body[body.len() - fields.left()..];
        let records = usize::try_from(length).ok().and_then(|length| rest.get(..length));
        let records = records.ok_or("a chunk ends within its records")?;
        Ok(Self { crc, compression, records })
    }
}

/// Schemas and channels of a file, and how many messages channels have.
#[derive(Default)]
struct Index {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    counts: BTreeMap<u16, u64>,
    /// Whether counts are stated.
    has_counts: bool,
}

impl Index {
    fn add(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { id, name } => drop(self.schemas.insert(id, name.to_owned())),
            Record::Channel { id, channel } => drop(self.channels.insert(id, channel)),
            Record::Message { channel, .. } => *self.counts.entry(channel).or_insert(0) += 1,
            Record::Statistics { messages, of_channels } => {
                // Counts that do not add up to the total are not trusted.
                let sum = of_channels.values().try_fold(0_u64, |sum, n| sum.checked_add(*n));
                self.has_counts = sum == Some(messages);
                self.counts = of_channels;
            }
        }
    }

    /// Whether counts are stated, and what they are of is known: a summary may leave schemas and channels
    /// out.
    fn is_whole(&self) -> bool {
        let is_known = |id| {
            let channel: Option<&Channel> = self.channels.get(id);
            // A channel of schema 0 has none.
            channel.is_some_and(|c| c.schema == 0 || self.schemas.contains_key(&c.schema))
        };
        self.has_counts && self.counts.keys().all(is_known)
    }

    fn topics(self) -> Vec<Topic> {
        let mut topics = Vec::new();
        for (id, channel) in self.channels {
            let topic = Topic {
                name: channel.topic,
                kind: self.schemas.get(&channel.schema).cloned().unwrap_or_default(),
                serialisation: channel.serialisation,
                ids: vec![id.into()],
                messages: self.counts.get(&id).copied().unwrap_or(0),
            };
            add_topic(&mut topics, topic);
        }
        topics
    }
}

fn u64_of(bytes: &[u8]) -> u64 {
    bytes.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes))
}

fn u16_of(bytes: &[u8]) -> u16 {
    bytes.first_chunk().map_or(0, |bytes| u16::from_le_bytes(*bytes))
}

/// Visits records that follow each other.
fn each(mut records: &[u8], visit: &mut RecordVisitor<'_>) -> Result<(), Reason> {
    while let Some((kind, rest)) = records.split_first() {
        let length = usize::try_from(u64_of(rest)).unwrap_or(usize::MAX);
        let behind = rest.get(size_of::<u64>()..);
        let body = behind.and_then(|rest| rest.split_at_checked(length));
        let (body, behind) = body.ok_or("a chunk ends within a record")?;
        if matches!(*kind, SCHEMA | CHANNEL | MESSAGE | STATISTICS) {
            visit(Record::new(*kind, body)?)?;
        }
        records = behind;
    }
    Ok(())
}
