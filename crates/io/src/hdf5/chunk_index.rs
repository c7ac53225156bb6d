//! The index of a dataset's chunks as it is written: a B-tree of version 1.
//!
//! # Source
//! HDF5 File Format Specification 3.0, III.A.1.

use super::object::UNDEFINED;

/// Chunks of a leaf, and nodes of an inner node: twice the default K.
const MAX_ENTRIES: usize = 64;
/// Bytes of a key: size, filters that are skipped, offsets of the row and of the byte of a value.
const KEY: usize = 24;
/// Bytes of a node, which has room for all entries.
const NODE: usize = 24 + MAX_ENTRIES * (KEY + 8) + KEY;

/// A chunk, or a node of the level below.
#[derive(Clone, Copy)]
struct Entry {
    first_row: u64,
    address: u64,
}

/// Chunks of equal size, one behind the other from row 0 on.
pub(super) struct ChunkIndex {
    pub(super) chunk_rows: u64,
    pub(super) chunk_bytes: u32,
    pub(super) addresses: Vec<u64>,
}

impl ChunkIndex {
    /// The nodes, to be written at `begin`, and the address of the root.
    pub(super) fn nodes(&self, begin: u64) -> (Vec<u8>, u64) {
        let mut bytes = Vec::new();
        let end_row = self.chunk_rows * self.addresses.len() as u64;
        let chunk = |(k, &address): (usize, &u64)| {
            let first_row = k as u64 * self.chunk_rows;
            Entry { first_row, address }
        };
        let mut entries: Vec<Entry> = self.addresses.iter().enumerate().map(chunk).collect();
        if entries.is_empty() {
            return (bytes, UNDEFINED);
        }
        // From the leaves up, as many levels as it takes: parents need the addresses of their
        // children.
        let mut level = 0;
        loop {
            let first = begin + bytes.len() as u64;
            let nodes: Vec<&[Entry]> = entries.chunks(MAX_ENTRIES).collect();
            let mut above = Vec::with_capacity(nodes.len());
            for (k, node) in nodes.iter().enumerate() {
                let address = |k: usize| first + (k * NODE) as u64;
                let left = k.checked_sub(1).map_or(UNDEFINED, address);
                let right = if k + 1 < nodes.len() { address(k + 1) } else { UNDEFINED };
                let next_row = nodes.get(k + 1).map_or(end_row, |next| next[0].first_row);
                self.node(level, node, [left, right], next_row, &mut bytes);
                above.push(Entry { first_row: node[0].first_row, address: address(k) });
            }
            match above.as_slice() {
                [root] => return (bytes, root.address),
                _ => (entries, level) = (above, level + 1),
            }
        }
    }

    fn node(
        &self,
        level: u8,
        entries: &[Entry],
        siblings: [u64; 2],
        next_row: u64,
        bytes: &mut Vec<u8>,
    ) {
        let end = bytes.len() + NODE;
        // Nodes of type 1 are of chunks.
        bytes.extend_from_slice(&[b'T', b'R', b'E', b'E', 1, level]);
        bytes.extend_from_slice(&(entries.len() as u16).to_le_bytes());
        bytes.extend(siblings.iter().flat_map(|address| address.to_le_bytes()));
        for entry in entries {
            self.key(entry.first_row, bytes);
            bytes.extend_from_slice(&entry.address.to_le_bytes());
        }
        self.key(next_row, bytes);
        bytes.resize(end, 0);
    }

    fn key(&self, row: u64, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.chunk_bytes.to_le_bytes());
        bytes.extend_from_slice(&[0; 4]);
        bytes.extend_from_slice(&row.to_le_bytes());
        bytes.extend_from_slice(&[0; 8]);
    }
}
