//! MCAP: records of a type, a length and a body; messages stand among them or in compressed chunks.
//!
//! Records are parsed by the crate `mcap`. Their framing is read here: damage has its place, what is
//! not needed is not read, and chunks are decompressed in Rust.
//!
//! # Source
//! <https://mcap.dev/spec>

use std::collections::BTreeMap;

use mcap::parse_record;
use mcap::records::{Record, op};

use super::fields::{Reason, Serialisation};
use super::file::{Bytes, Fault, MessageFile, Take, Topic, add_topic};
use crate::Input;
use crate::aedat4::{Compression, Inflater};

/// Bytes of a record's type and length, and of the end of a file: footer and mark.
const HEAD: u64 = 9;
const END: u64 = HEAD + 20 + mcap::MAGIC.len() as u64;

/// Takes a record.
type Visit<'a> = dyn FnMut(Record<'_>) -> Result<(), Reason> + 'a;

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
    fn records(&mut self, at: u64, visit: &mut Visit<'_>) -> Result<Option<u64>, Fault> {
        let damage = |reason: Reason| Fault::damage(at, reason);
        if at >= self.bytes.length {
            return Err(damage("the file ends before the end of its data".into()));
        }
        self.bytes.read((at, at), HEAD, &mut self.head)?;
        let (kind, length) = (self.head[0], u64_of(&self.head[1..]));
        match kind {
            0 => return Err(damage("no record begins here".into())),
            op::DATA_END | op::FOOTER => return Ok(None),
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK => {
                self.bytes.read((at, at + HEAD), length, &mut self.body)?;
                let record = parse(kind, &self.body).map_err(damage)?;
                let Record::Chunk { header, data } = record else {
                    visit(record).map_err(damage)?;
                    return Ok(Some(at + HEAD + length));
                };
                let compression = match header.compression.as_str() {
                    "" => Compression::None,
                    "lz4" => Compression::Lz4,
                    "zstd" => Compression::Zstd,
                    other => return Err(damage(format!("a chunk packed by `{other}`").into())),
                };
                // Before a fault in a chunk nothing of it counts: its checksum is that of the whole.
                self.inflater.inflate(compression, &data).map_err(damage)?;
                let records = self.inflater.out.filled();
                let crc = header.uncompressed_crc;
                if crc != 0 && crc != crc32fast::hash(records) {
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
        let foot = self.body.strip_suffix(mcap::MAGIC)?;
        let (op::FOOTER, body) = (*foot.first()?, foot.get(HEAD as usize..)?) else { return None };
        let start = u64_of(body);
        let length = end.checked_sub(start).filter(|_| start > 0)?;
        self.bytes.read((start, start), length, &mut self.body).ok()?;
        let mut index = Index::default();
        each(&self.body, &mut |record| {
            index.add(record);
            Ok(())
        })
        .ok()?;
        index.has_counts.then(|| index.topics())
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
        let (mut index, mut at) = (Index::default(), self.begin());
        let fault = loop {
            let read = self.records(at, &mut |record| {
                index.add(record);
                Ok(())
            });
            match read {
                Ok(Some(next)) => at = next,
                Ok(None) => break None,
                Err(fault) => break Some(fault),
            }
        };
        (index.topics(), fault)
    }

    fn begin(&self) -> u64 {
        mcap::MAGIC.len() as u64
    }

    fn unit(&mut self, at: u64, ids: &[u32], take: &mut Take<'_>) -> Result<Option<u64>, Fault> {
        self.records(at, &mut |record| match record {
            Record::Message { header, data } if ids.contains(&u32::from(header.channel_id)) => {
                take(&data)
            }
            _ => Ok(()),
        })
    }
}

/// Schemas and channels of a file, and how many messages channels have.
#[derive(Default)]
struct Index {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, mcap::records::Channel>,
    counts: BTreeMap<u16, u64>,
    /// Whether counts are stated.
    has_counts: bool,
}

impl Index {
    fn add(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, .. } => drop(self.schemas.insert(header.id, header.name)),
            Record::Channel(channel) => drop(self.channels.insert(channel.id, channel)),
            Record::Message { header, .. } => {
                *self.counts.entry(header.channel_id).or_insert(0) += 1;
            }
            Record::Statistics(statistics) => {
                self.counts = statistics.channel_message_counts;
                self.has_counts = self.counts.values().sum::<u64>() == statistics.message_count;
            }
            _ => {}
        }
    }

    fn topics(self) -> Vec<Topic> {
        let mut topics = Vec::new();
        for (id, channel) in self.channels {
            let topic = Topic {
                name: channel.topic,
                kind: self.schemas.get(&channel.schema_id).cloned().unwrap_or_default(),
                serialisation: match channel.message_encoding.as_str() {
                    "ros1" => Serialisation::Ros1,
                    _ => Serialisation::Cdr,
                },
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

fn parse(kind: u8, body: &[u8]) -> Result<Record<'_>, Reason> {
    parse_record(kind, body).map_err(|fault| format!("a record of type {kind}: {fault}").into())
}

/// Visits records that follow each other.
fn each(mut records: &[u8], visit: &mut Visit<'_>) -> Result<(), Reason> {
    while let Some((kind, rest)) = records.split_first() {
        let length = usize::try_from(u64_of(rest)).unwrap_or(usize::MAX);
        let behind = rest.get(size_of::<u64>()..);
        let body = behind.and_then(|rest| rest.split_at_checked(length));
        let (body, behind) = body.ok_or("a chunk ends within a record")?;
        if matches!(*kind, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::STATISTICS) {
            visit(parse(*kind, body)?)?;
        }
        records = behind;
    }
    Ok(())
}
