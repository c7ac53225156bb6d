//! Rows of a dataset, loaded and unpacked one chunk at a time.

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
use hdf5_reader::messages::filter_pipeline::FilterDescription;
use hdf5_reader::messages::layout::{ChunkIndexing, DataLayout};
use hdf5_reader::{Dataset, Hdf5File, dtype_element_size};

use super::bytes::Bytes;
use super::ecf;
use super::filters::Filters;
use crate::Columns;

/// Bytes that are loaded at once of a dataset without chunks.
const PART: usize = 1 << 20;
/// Maximal bytes of a chunk: those of programs for events have some hundred thousand.
const MAX_CHUNK_BYTES: usize = 1 << 28;
/// Maximal count of chunks: with a thousand events each, they hold four thousand million.
const MAX_CHUNKS: u64 = 1 << 22;

/// A fault in a file.
#[derive(Debug)]
pub(super) struct Damage {
    /// Offset in the file.
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
    storage: Storage,
    filters: Filters,
    bytes: Arc<Bytes>,
    /// Offset of HDF5's base address.
    base: u64,
    loaded: LoadedChunk,
}

/// Storage of the rows.
enum Storage {
    Inline(Vec<u8>),
    Contiguous(u64),
    /// In ascending order of their indices.
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
struct LoadedChunk {
    number: Option<u64>,
    /// Offset of its beginning in the file.
    address: u64,
    /// Whole rows that could be loaded.
    rows: u64,
    /// The rows, unless they are `events`.
    bytes: Vec<u8>,
    /// Rows that were packed as events.
    events: Columns,
    is_events: bool,
    /// Reason for missing rows.
    damage: Option<Cow<'static, str>>,
}

impl Table {
    /// The rows of a dataset of one column, or, of a dataset of several, those of the columns that
    /// share their chunks with `column`.
    pub(super) fn new(
        file: &Hdf5File,
        bytes: &Arc<Bytes>,
        dataset: &Dataset,
        column: u64,
    ) -> Result<Self, Error> {
        let (layout, filters) = read_messages(file, dataset)?;
        let element = dtype_element_size(dataset.dtype())?;
        let shape = dataset.shape();
        let columns = shape.get(1).copied().unwrap_or(1);
        let part_rows = |row: usize| (PART / row).max(1) as u64;
        // Without chunks, parts of a size that reading is fast with.
        let (storage, row, chunk_rows) = match layout {
            DataLayout::Compact { data } => {
                let row = row_bytes(columns, element)?;
                (Storage::Inline(data), row, part_rows(row))
            }
            DataLayout::Contiguous { address, .. } => {
                let row = row_bytes(columns, element)?;
                (Storage::Contiguous(address), row, part_rows(row))
            }
            DataLayout::Chunked { address, mut dims, chunk_indexing, .. } => {
                dims.truncate(shape.len());
                let width = dims.get(1).copied().unwrap_or(1).max(1).into();
                let row = row_bytes(width, element)?;
                let chunk_rows = check_chunks(&dims, shape, row)?;
                let index = Index { file, dataset, dims: &dims, element };
                let mut entries = index.entries(address, chunk_indexing.as_ref())?;
                let block = column / width * width;
                // Chunks may divide the columns as well: only those with the wanted column are
                // read.
                entries.retain(|entry| entry.offsets.get(1).is_none_or(|&at| at == block));
                let chunk = |entry: &ChunkEntry| Chunk {
                    number: entry.offsets.first().copied().unwrap_or(0) / chunk_rows,
                    address: entry.address,
                    size: entry.size,
                    skipped: entry.filter_mask,
                };
                let mut chunks: Vec<Chunk> = entries.iter().map(chunk).collect();
                // Trees list chunks in any order; reading searches by number.
                chunks.sort_by_key(|chunk| chunk.number);
                (Storage::Chunks(chunks), row, chunk_rows)
            }
        };
        Ok(Self {
            name: dataset.name().to_owned(),
            rows: shape.first().copied().unwrap_or(1),
            row,
            chunk_rows,
            storage,
            filters: Filters::new(filters, element),
            bytes: Arc::clone(bytes),
            base: file.superblock().base_address,
            loaded: LoadedChunk::default(),
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

    /// Loads the chunk of `row`; returns the count of its rows from there on.
    pub(super) fn load_row(&mut self, row: u64) -> Result<u64, Damage> {
        let number = row / self.chunk_rows;
        if self.loaded.number != Some(number) {
            // No chunk counts as loaded if reading it fails halfway.
            self.loaded.number = None;
            self.load(number)?;
            self.loaded.number = Some(number);
        }
        let rows = (number * self.chunk_rows + self.loaded.rows).saturating_sub(row);
        match &self.loaded.damage {
            Some(reason) if rows == 0 => Err(self.damage(row, reason)),
            _ => Ok(rows),
        }
    }

    /// The bytes of `rows` loaded rows from `row` on; empty for rows that were packed as events.
    pub(super) fn rows(&self, row: u64, rows: u64) -> &[u8] {
        let from = (row % self.chunk_rows) as usize * self.row;
        self.loaded.bytes.get(from..from + rows as usize * self.row).unwrap_or_default()
    }

    /// The loaded events and the index of that of `row`, if they were packed as whole events.
    pub(super) fn events(&self, row: u64) -> Option<(&Columns, usize)> {
        self.loaded.is_events.then_some((&self.loaded.events, (row % self.chunk_rows) as usize))
    }

    /// Offset of the loaded chunk in the file.
    pub(super) fn chunk_byte(&self) -> u64 {
        self.bytes.within(self.loaded.address)
    }

    /// The error for a fault at a loaded row.
    pub(super) fn damage(&self, row: u64, reason: &str) -> Damage {
        let is_plain = self.filters.is_none() && !self.loaded.is_events;
        let within = if is_plain { (row % self.chunk_rows) * self.row as u64 } else { 0 };
        let byte = self.bytes.within(self.loaded.address.saturating_add(within));
        Damage { byte, reason: format!("{}: {reason}", self.name).into() }
    }

    fn load(&mut self, number: u64) -> Result<(), Damage> {
        let (first, loaded) = (number * self.chunk_rows, &mut self.loaded);
        (loaded.is_events, loaded.rows, loaded.damage) = (false, 0, None);
        // Cleared, not dropped: the memory serves the next chunk.
        loaded.bytes.clear();
        // The last chunk may be longer than what is left of the dataset.
        let wanted = self.chunk_rows.min(self.rows - first);
        let (wanted_bytes, whole) =
            (wanted as usize * self.row, self.chunk_rows as usize * self.row);
        let of_file = |byte: u64, reason: Cow<'static, str>| Damage {
            byte: self.bytes.within(byte),
            reason: format!("{}, chunk {number}: {reason}", self.name).into(),
        };
        match &self.storage {
            Storage::Inline(data) => {
                let from = (first as usize).saturating_mul(self.row).min(data.len());
                let to = from.saturating_add(wanted_bytes).min(data.len());
                loaded.address = self.bytes.last();
                loaded.bytes.extend_from_slice(&data[from..to]);
            }
            Storage::Contiguous(address) => {
                let start = first.saturating_mul(self.row as u64);
                loaded.address = self.base.saturating_add(*address).saturating_add(start);
                let read = self.bytes.read(loaded.address, wanted_bytes as u64, &mut loaded.bytes);
                read.map_err(|fault| of_file(loaded.address, fault.to_string().into()))?;
            }
            Storage::Chunks(chunks) => {
                // HDF5 stores no chunk that was never written to.
                let position = chunks.binary_search_by_key(&number, |chunk| chunk.number);
                let Ok(chunk) = position.map(|at| chunks[at]) else {
                    let byte = self.bytes.last();
                    return Err(of_file(byte, "not in the file: its events are missing".into()));
                };
                loaded.address = self.base.saturating_add(chunk.address);
                // Chunks without filters may have no size of their own.
                let is_plain = self.filters.is_none();
                let size = if is_plain || chunk.size == 0 { whole as u64 } else { chunk.size };
                let read = self.bytes.read(loaded.address, size, &mut loaded.bytes);
                read.map_err(|fault| of_file(loaded.address, fault.to_string().into()))?;
                // A packed chunk that is cut cannot be unpacked.
                if !is_plain && (loaded.bytes.len() as u64) < size {
                    let reason =
                        format!("the file ends in it, {} of {size} bytes", loaded.bytes.len());
                    return Err(of_file(loaded.address, reason.into()));
                }
                let undone = self.filters.undo(&mut loaded.bytes, chunk.skipped, whole);
                undone.map_err(|reason| of_file(loaded.address, reason))?;
                if self.filters.is_ecf(chunk.skipped) {
                    loaded.is_events = true;
                    loaded.events.clear();
                    let decoded = ecf::decode(&loaded.bytes, &mut loaded.events);
                    let events = decoded.map_err(|fault| {
                        of_file(loaded.address.saturating_add(fault.at as u64), fault.reason)
                    })?;
                    loaded.rows = events as u64;
                }
            }
        }
        if !loaded.is_events {
            loaded.rows = (loaded.bytes.len() / self.row) as u64;
        }
        if loaded.rows > self.chunk_rows {
            let reason = format!("{} rows, it has room for {}", loaded.rows, self.chunk_rows);
            return Err(of_file(loaded.address, reason.into()));
        }
        // Its first rows can be read before the damage is reported.
        if loaded.rows < wanted {
            let reason = format!("chunk {number} ends after {} of its {wanted} rows", loaded.rows);
            loaded.damage = Some(reason.into());
        }
        // Chunks are padded beyond the last row.
        loaded.rows = loaded.rows.min(wanted);
        Ok(())
    }
}

/// Reads the storage layout and the filters of a dataset from its object header.
fn read_messages(
    file: &Hdf5File,
    dataset: &Dataset,
) -> Result<(DataLayout, Vec<FilterDescription>), Error> {
    let header = file.get_or_parse_header(dataset.address())?;
    let (mut layout, mut filters) = (None, Vec::new());
    for message in &header.messages {
        match message {
            HdfMessage::DataLayout(message) => layout = Some(message.layout.clone()),
            HdfMessage::FilterPipeline(message) => filters = message.filters.clone(),
            HdfMessage::ExternalFiles(_) => {
                let reason = "its data are in another file, which is not read";
                return Err(Error::Other(reason.to_owned()));
            }
            _ => {}
        }
    }
    let layout = layout.ok_or_else(|| Error::InvalidData("no layout".to_owned()))?;
    Ok((layout, filters))
}

/// Bytes of a row of `columns` elements, checked against the limit of a chunk.
fn row_bytes(columns: u64, element: usize) -> Result<usize, Error> {
    let row = usize::try_from(columns).ok().and_then(|n| n.checked_mul(element));
    let fits = row.filter(|row| (1..=MAX_CHUNK_BYTES).contains(row));
    fits.ok_or_else(|| Error::ResourceLimit(format!("rows of {columns} columns")))
}

/// Checks the dimensions of chunks against the limits before anything is allocated; returns the
/// rows of a chunk.
fn check_chunks(dims: &[u32], shape: &[u64], row: usize) -> Result<u64, Error> {
    let [rows, columns] = [0, 1].map(|axis| shape.get(axis).copied().unwrap_or(1));
    let width = dims.get(1).copied().unwrap_or(1).max(1).into();
    let chunk_rows = dims.first().copied().unwrap_or(0);
    if dims.len() != shape.len().max(1) || chunk_rows == 0 {
        return Err(Error::InvalidData(format!("chunks of {dims:?} of {shape:?}")));
    }
    // Sizes are those of an unknown file: they must not decide how much memory is taken.
    if (chunk_rows as usize).saturating_mul(row) > MAX_CHUNK_BYTES {
        return Err(Error::ResourceLimit(format!("chunks of {dims:?}")));
    }
    let blocks = columns.div_ceil(width);
    if rows.div_ceil(chunk_rows.into()).saturating_mul(blocks) > MAX_CHUNKS {
        return Err(Error::ResourceLimit(format!("chunks of {dims:?} of {shape:?}")));
    }
    Ok(chunk_rows.into())
}

/// Index of the chunks of a dataset.
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
        // An address of ones is undefined: no chunk was ever written.
        let is_none = address == u64::MAX >> (64 - 8 * u32::from(offset.clamp(1, 8)));
        if is_none || shape.contains(&0) {
            return Ok(Vec::new());
        }
        // HDF5 1.10 added five ways to list chunks to its first one, a tree.
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
                let max_address = storage.len();
                collect_implicit_chunk_entries(address, shape, dims, element, None, max_address)
            }
            Some(ChunkIndexing::FixedArray { .. }) => collect_fixed_array_chunk_entries_storage(
                storage, address, offset, length, shape, dims, None,
            ),
            Some(ChunkIndexing::ExtensibleArray { .. }) => {
                let max_dims = dataset.max_dims();
                collect_extensible_array_chunk_entries_storage(
                    storage, address, offset, length, shape, max_dims, dims, None,
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
