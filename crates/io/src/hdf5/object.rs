//! Object headers of groups and datasets, and the messages in them, as they are written.
//!
//! # Source
//! HDF5 File Format Specification 3.0, IV.A.1.b (object headers) and IV.A.2 (messages).

use hdf5_reader::checksum::jenkins_lookup3 as checksum;

/// The undefined address: nothing is stored.
pub(super) const UNDEFINED: u64 = u64::MAX;

/// Types of messages.
const DATASPACE: u8 = 0x01;
const LINK_INFO: u8 = 0x02;
const DATATYPE: u8 = 0x03;
const FILL_VALUE: u8 = 0x05;
const LINK: u8 = 0x06;
const LAYOUT: u8 = 0x08;
const GROUP_INFO: u8 = 0x0A;
const FILTERS: u8 = 0x0B;
const ATTRIBUTE: u8 = 0x0C;

/// An integer type, little-endian.
#[derive(Debug, Clone, Copy)]
pub(super) struct IntegerType {
    /// Bytes of a value.
    pub(super) bytes: u8,
    /// Whether values have a sign.
    pub(super) is_signed: bool,
}

impl IntegerType {
    fn message(self) -> Vec<u8> {
        // Version 1, class 0: fixed-point. The sign is bit 3 of the class's own.
        let mut message = vec![0x10, u8::from(self.is_signed) << 3, 0, 0, self.bytes, 0, 0, 0];
        // All bits from bit 0 on.
        message.extend_from_slice(&[0, 0, 8 * self.bytes, 0]);
        message
    }
}

/// The messages of an object header.
#[derive(Debug, Default)]
pub(super) struct ObjectHeader(Vec<u8>);

impl ObjectHeader {
    /// The header of a group.
    pub(super) fn group() -> Self {
        let mut header = Self::default();
        // Links are in the header: there is no heap of them, nor an index by their names.
        let no_heap = [&[0, 0][..], &UNDEFINED.to_le_bytes(), &UNDEFINED.to_le_bytes()].concat();
        header.message(LINK_INFO, &no_heap);
        header.message(GROUP_INFO, &[0, 0]);
        header
    }

    /// Adds a member to a group.
    pub(super) fn link(mut self, name: &str, address: u64) -> Self {
        let length = name.len() as u8;
        let link = [&[1, 0, length], name.as_bytes(), &address.to_le_bytes()].concat();
        self.message(LINK, &link);
        self
    }

    /// Adds an attribute of one integer.
    pub(super) fn attribute(mut self, name: &str, value: i64) -> Self {
        let kind = IntegerType { bytes: 8, is_signed: true }.message();
        let scalar = [2, 0, 0, 0];
        let sizes = [name.len() as u16 + 1, kind.len() as u16, scalar.len() as u16];
        let mut message = vec![3, 0];
        message.extend(sizes.iter().flat_map(|size| size.to_le_bytes()));
        // Names are ASCII.
        message.push(0);
        message.extend_from_slice(name.as_bytes());
        message.push(0);
        message.extend_from_slice(&kind);
        message.extend_from_slice(&scalar);
        message.extend_from_slice(&value.to_le_bytes());
        self.message(ATTRIBUTE, &message);
        self
    }

    /// The header of a dataset of one dimension, whose chunks have an index at `address`.
    pub(super) fn dataset(kind: IntegerType, rows: u64, chunk_rows: u32, address: u64) -> Self {
        let mut header = Self::default();
        header.message(DATASPACE, &[&[2, 1, 0, 1][..], &rows.to_le_bytes()].concat());
        header.message(DATATYPE, &kind.message());
        // Chunks are allocated as they come, and filled only if a value for it is set.
        header.message(FILL_VALUE, &[3, 0b1011]);
        // Version 2, one filter, number 3: the checksum of Fletcher, without a flag or a parameter.
        header.message(FILTERS, &[2, 1, 3, 0, 0, 0, 0, 0]);
        // Version 3, chunked, of rows and of the bytes of a value.
        let mut layout = vec![3, 2, 2];
        layout.extend_from_slice(&address.to_le_bytes());
        layout.extend_from_slice(&chunk_rows.to_le_bytes());
        layout.extend_from_slice(&u32::from(kind.bytes).to_le_bytes());
        header.message(LAYOUT, &layout);
        header
    }

    /// The header of a dataset of one signed integer, which stands in it.
    pub(super) fn scalar(value: i64) -> Self {
        let mut header = Self::default();
        // Version 2, no dimensions, a scalar.
        header.message(DATASPACE, &[2, 0, 0, 0]);
        header.message(DATATYPE, &IntegerType { bytes: 8, is_signed: true }.message());
        header.message(FILL_VALUE, &[3, 0b1011]);
        // Version 3, compact: the count of bytes, and these.
        header.message(LAYOUT, &[&[3, 0, 8, 0][..], &value.to_le_bytes()].concat());
        header
    }

    fn message(&mut self, kind: u8, data: &[u8]) {
        self.0.push(kind);
        self.0.extend_from_slice(&(data.len() as u16).to_le_bytes());
        self.0.push(0);
        self.0.extend_from_slice(data);
    }

    /// The bytes of the header.
    pub(super) fn into_bytes(self) -> Vec<u8> {
        // Version 2; the length of the messages takes four bytes.
        let mut bytes = b"OHDR\x02\x02".to_vec();
        bytes.extend_from_slice(&(self.0.len() as u32).to_le_bytes());
        bytes.extend_from_slice(&self.0);
        let sum = checksum(&bytes);
        bytes.extend_from_slice(&sum.to_le_bytes());
        bytes
    }
}

/// Bytes of the superblock.
pub(super) const SUPERBLOCK: usize = 48;

/// The superblock of a file of `length` bytes with the root group at `root`.
pub(super) fn superblock(length: u64, root: u64) -> Vec<u8> {
    let mut bytes = super::SIGNATURE.to_vec();
    // Version 2, offsets and lengths of 8 bytes, no flags.
    bytes.extend_from_slice(&[2, 8, 8, 0]);
    for address in [0, UNDEFINED, length, root] {
        bytes.extend_from_slice(&address.to_le_bytes());
    }
    let sum = checksum(&bytes);
    bytes.extend_from_slice(&sum.to_le_bytes());
    bytes
}
