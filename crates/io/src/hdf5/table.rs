//! Rows of a dataset, a chunk at a time, each read and unpacked where it stands in the file.

use std::borrow::Cow;
use std::sync::Arc;

use hdf5_reader::btree_v1::{BTreeV1Key, collect_btree_v1_leaves_storage};
use hdf5_reader::chunk_index::{
    ChunkEntry, collect_implicit_chunk_entries, collect_v2_chunk_entries_storage,
    single_chunk_entry,
};
use hdf5_reader::error::Error;
use hdf5_reader::extensible_array::collect_extensible_array_chunk_entries_storage;
use hdf5_reader::fixed_array::collect_fixed_array_chunk_entries_storage;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::messages::layout::{ChunkIndexing, DataLayout};
use hdf5_reader::{Dataset, Hdf5File, dtype_element_size};

use super::bytes::Bytes;
use super::ecf;
use super::filters::Filters;
use crate::Columns;

/// Bytes of a part of a dataset that has no chunks of its own.
const PART: usize = 1 << 20;
/// The most bytes of a chunk: those of programs for events have some hundred thousand.
const MOST: usize = 1 << 28;
/// The most chunks: of a thousand events, they hold four thousand million.
const MOST_CHUNKS: u64 = 1 << 22;

/// What is wrong in a file, and where.
#[derive(Debug)]
pub(super) struct Damage {
    /// From the beginning of the file.
    pub(super) byte: u64,
    pub(super) reason: Cow<'static, str>,
}

/// A dataset of rows, or those columns of one that share their chunks.
pub(super) struct Table {
    /// Its path in the file.
    pub(super) name: String,
    pub(super) rows: u64,
    /// Bytes of a row of a chunk.
    pub(super) row: usize,
    chunk_rows: u64,
    place: Place,
    filters: Filters,
    bytes: Arc<Bytes>,
    /// What HDF5's addresses are counted from.
    base: u64,
    held: Held,
}

/// Where the rows are.
enum Place {
    Inline(Vec<u8>),
    Contiguous(u64),
    /// Ascending by number.
    Chunks(Vec<Chunk>),
}

/// A chunk in the file.
#[derive(Debug, Clone, Copy)]
struct Chunk {
    number: u64,
    address: u64,
    size: u64,
    /// Filters that it skips, the first in the lowest bit.
    skipped: u32,
}

/// The chunk that was read last.
#[derive(Default)]
struct Held {
    number: Option<u64>,
    /// Where it begins in the file.
    address: u64,
    /// Whole rows of it that are there.
    rows: u64,
    /// The rows, unless they are `events`.
    bytes: Vec<u8>,
    /// Rows that were packed as events.
    events: Columns,
    is_events: bool,
    /// What cost the rows that are missing.
    damage: Option<Cow<'static, str>>,
}

impl Table {
    /// The rows of a dataset of one column, or those of the columns of one of several that stand in a
    /// chunk with column `column`.
    pub(super) fn new(
        file: &Hdf5File,
        bytes: &Arc<Bytes>,
        dataset: &Dataset,
        column: u64,
    ) -> Result<Self, Error> {
        let header = file.get_or_parse_header(dataset.address())?;
        let (mut layout, mut filters) = (None, Vec::new());
        for message in &header.messages {
            match message {
                HdfMessage::DataLayout(found) => layout = Some(found.layout.clone()),
                HdfMessage::FilterPipeline(found) => filters = found.filters.clone(),
                HdfMessage::ExternalFiles(_) => {
                    let reason = "its data are in another file, which is not read";
                    return Err(Error::Other(reason.to_owned()));
                }
                _ => {}
            }
        }
        let layout = layout.ok_or_else(|| Error::InvalidData("no layout".to_owned()))?;
        let element = dtype_element_size(dataset.dtype())?;
        let shape = dataset.shape();
        let rows = shape.first().copied().unwrap_or(1);
        let columns = shape.get(1).copied().unwrap_or(1);
        let bytes_of = |columns: u64| {
            let row = usize::try_from(columns).ok().and_then(|n| n.checked_mul(element));
            let fits = row.filter(|row| (1..=MOST).contains(row));
            fits.ok_or_else(|| Error::ResourceLimit(format!("rows of {columns} columns")))
        };
        let part_rows = |row: usize| (PART / row).max(1) as u64;
        let (place, row, chunk_rows) = match layout {
            DataLayout::Compact { data } => {
                let row = bytes_of(columns)?;
                (Place::Inline(data), row, part_rows(row))
            }
            DataLayout::Contiguous { address, .. } => {
                let row = bytes_of(columns)?;
                (Place::Contiguous(address), row, part_rows(row))
            }
            DataLayout::Chunked { address, mut dims, chunk_indexing, .. } => {
                dims.truncate(shape.len());
                let width = dims.get(1).copied().unwrap_or(1).max(1).into();
                let row = bytes_of(width)?;
                let chunk_rows = dims.first().copied().unwrap_or(0);
                if dims.len() != shape.len().max(1) || chunk_rows == 0 {
                    return Err(Error::InvalidData(format!("chunks of {dims:?} of {shape:?}")));
                }
                if (chunk_rows as usize).saturating_mul(row) > MOST {
                    return Err(Error::ResourceLimit(format!("chunks of {dims:?}")));
                }
                let blocks = columns.div_ceil(width);
                if rows.div_ceil(chunk_rows.into()).saturating_mul(blocks) > MOST_CHUNKS {
                    return Err(Error::ResourceLimit(format!("chunks of {dims:?} of {shape:?}")));
                }
                let index = Index { file, dataset, dims: &dims, element };
                let mut entries = index.entries(address, chunk_indexing.as_ref())?;
                let block = column / width * width;
                entries.retain(|entry| entry.offsets.get(1).is_none_or(|&at| at == block));
                let chunk = |entry: &ChunkEntry| Chunk {
                    number: entry.offsets.first().copied().unwrap_or(0) / u64::from(chunk_rows),
                    address: entry.address,
                    size: entry.size,
                    skipped: entry.filter_mask,
                };
                let mut chunks: Vec<Chunk> = entries.iter().map(chunk).collect();
                chunks.sort_by_key(|chunk| chunk.number);
                (Place::Chunks(chunks), row, chunk_rows.into())
            }
        };
        Ok(Self {
            name: dataset.name().to_owned(),
            rows,
            row,
            chunk_rows,
            place,
            filters: Filters::new(filters, element),
            bytes: Arc::clone(bytes),
            base: file.superblock().base_address,
            held: Held::default(),
        })
    }

    /// Names of the filters.
    pub(super) fn filters(&self) -> String {
        self.filters.names()
    }

    /// Rows of a chunk.
    pub(super) fn chunk_rows(&self) -> u64 {
        self.chunk_rows
    }

    /// Holds the chunk of `row`, and says how many rows it has from there on.
    pub(super) fn hold(&mut self, row: u64) -> Result<u64, Damage> {
        let number = row / self.chunk_rows;
        if self.held.number != Some(number) {
            self.held.number = None;
            self.load(number)?;
            self.held.number = Some(number);
        }
        let rows = (number * self.chunk_rows + self.held.rows).saturating_sub(row);
        match &self.held.damage {
            Some(reason) if rows == 0 => Err(self.damage(row, reason)),
            _ => Ok(rows),
        }
    }

    /// The bytes of `rows` rows from `row` on, which are held; none of rows that were packed as events.
    pub(super) fn rows(&self, row: u64, rows: u64) -> &[u8] {
        let from = (row % self.chunk_rows) as usize * self.row;
        self.held.bytes.get(from..from + rows as usize * self.row).unwrap_or_default()
    }

    /// The held events, and which of them is that of `row`, if they were packed as such.
    pub(super) fn events(&self, row: u64) -> Option<(&Columns, usize)> {
        self.held.is_events.then_some((&self.held.events, (row % self.chunk_rows) as usize))
    }

    /// Where the chunk that was read last begins in the file.
    pub(super) fn place(&self) -> u64 {
        self.bytes.within(self.held.address)
    }

    /// Damage at a row that is held.
    pub(super) fn damage(&self, row: u64, reason: &str) -> Damage {
        let is_plain = self.filters.is_none() && !self.held.is_events;
        let within = if is_plain { (row % self.chunk_rows) * self.row as u64 } else { 0 };
        let byte = self.bytes.within(self.held.address.saturating_add(within));
        Damage { byte, reason: format!("{}: {reason}", self.name).into() }
    }

    fn load(&mut self, number: u64) -> Result<(), Damage> {
        let (first, held) = (number * self.chunk_rows, &mut self.held);
        (held.is_events, held.rows, held.damage) = (false, 0, None);
        held.bytes.clear();
        let wanted = self.chunk_rows.min(self.rows - first);
        let (wanted_bytes, whole) =
            (wanted as usize * self.row, self.chunk_rows as usize * self.row);
        let of_file = |byte: u64, reason: Cow<'static, str>| Damage {
            byte: self.bytes.within(byte),
            reason: format!("{}, chunk {number}: {reason}", self.name).into(),
        };
        match &self.place {
            Place::Inline(data) => {
                let from = (first as usize).saturating_mul(self.row).min(data.len());
                let to = from.saturating_add(wanted_bytes).min(data.len());
                held.address = self.bytes.last();
                held.bytes.extend_from_slice(&data[from..to]);
            }
            Place::Contiguous(address) => {
                let start = first.saturating_mul(self.row as u64);
                held.address = self.base.saturating_add(*address).saturating_add(start);
                let read = self.bytes.read(held.address, wanted_bytes as u64, &mut held.bytes);
                read.map_err(|fault| of_file(held.address, fault.to_string().into()))?;
            }
            Place::Chunks(chunks) => {
                let found = chunks.binary_search_by_key(&number, |chunk| chunk.number);
                let Ok(chunk) = found.map(|at| chunks[at]) else {
                    let byte = self.bytes.last();
                    return Err(of_file(byte, "not in the file: its events are missing".into()));
                };
                held.address = self.base.saturating_add(chunk.address);
                // Chunks without filters may have no size of their own.
                let is_plain = self.filters.is_none();
                let size = if is_plain || chunk.size == 0 { whole as u64 } else { chunk.size };
                let read = self.bytes.read(held.address, size, &mut held.bytes);
                read.map_err(|fault| of_file(held.address, fault.to_string().into()))?;
                if !is_plain && (held.bytes.len() as u64) < size {
                    let reason =
                        format!("the file ends in it, {} of {size} bytes", held.bytes.len());
                    return Err(of_file(held.address, reason.into()));
                }
                let undone = self.filters.undo(&mut held.bytes, chunk.skipped, whole);
                undone.map_err(|reason| of_file(held.address, reason))?;
                if self.filters.is_ecf(chunk.skipped) {
                    held.is_events = true;
                    held.events.clear();
                    let decoded = ecf::decode(&held.bytes, &mut held.events);
                    let events = decoded.map_err(|fault| {
                        of_file(held.address.saturating_add(fault.at as u64), fault.reason)
                    })?;
                    held.rows = events as u64;
                }
            }
        }
        if !held.is_events {
            held.rows = (held.bytes.len() / self.row) as u64;
        }
        if held.rows > self.chunk_rows {
            let reason = format!("{} rows, it has room for {}", held.rows, self.chunk_rows);
            return Err(of_file(held.address, reason.into()));
        }
        if held.rows < wanted {
            let reason = format!("chunk {number} ends after {} of its {wanted} rows", held.rows);
            held.damage = Some(reason.into());
        }
        // What chunks hold beyond the last row is no data.
        held.rows = held.rows.min(wanted);
        Ok(())
    }
}

/// What lists the chunks of a dataset.
struct Index<'a> {
    file: &'a Hdf5File,
    dataset: &'a Dataset,
    dims: &'a [u32],
    element: usize,
}

impl Index<'_> {
    fn entries(
        &self,
        address: u64,
        indexing: Option<&ChunkIndexing>,
    ) -> Result<Vec<ChunkEntry>, Error> {
        let Self { file, dataset, dims, element } = *self;
        let (storage, superblock) = (file.storage(), file.superblock());
        let (offset, length) = (superblock.offset_size, superblock.length_size);
        let shape = dataset.shape();
        let is_none = address == u64::MAX >> (64 - 8 * u32::from(offset.clamp(1, 8)));
        if is_none || shape.contains(&0) {
            return Ok(Vec::new());
        }
        match indexing {
            None => {
                let rank = Some(shape.len() as u32);
                let leaves = collect_btree_v1_leaves_storage(
                    storage, address, offset, length, rank, dims, None,
                )?;
                leaves.into_iter().map(|(key, address)| of_leaf(key, address, shape)).collect()
            }
            Some(ChunkIndexing::SingleChunk { filtered_size, filters }) => {
                Ok(vec![single_chunk_entry(address, *filtered_size, *filters, shape.len())])
            }
            Some(ChunkIndexing::BTreeV2) => {
                let rank = shape.len() as u32;
                collect_v2_chunk_entries_storage(storage, address, offset, length, rank, dims, None)
            }
            Some(ChunkIndexing::Implicit) => {
                let most = storage.len();
                collect_implicit_chunk_entries(address, shape, dims, element, None, most)
            }
            Some(ChunkIndexing::FixedArray { .. }) => collect_fixed_array_chunk_entries_storage(
                storage, address, offset, length, shape, dims, None,
            ),
            Some(ChunkIndexing::ExtensibleArray { .. }) => {
                let most = dataset.max_dims();
                collect_extensible_array_chunk_entries_storage(
                    storage, address, offset, length, shape, most, dims, None,
                )
            }
        }
    }
}

fn of_leaf(key: BTreeV1Key, address: u64, shape: &[u64]) -> Result<ChunkEntry, Error> {
    let BTreeV1Key::RawData { chunk_size, filter_mask, mut offsets } = key else {
        return Err(Error::InvalidData("an index of chunks that lists other things".to_owned()));
    };
    offsets.truncate(shape.len());
    Ok(ChunkEntry { address, size: chunk_size.into(), filter_mask, offsets })
}
