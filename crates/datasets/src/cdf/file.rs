//! The file: what it says of itself, and its variables.

use std::path::Path;

use super::compression::{self, LIMIT};
use super::kind::{ByteOrder, NumberKind};
use super::record::{Record, kind};
use super::{CdfArray, CdfError, values};
use crate::DatasetError;

const MAGIC: &[u8] = &[0xcd, 0xf3, 0x00, 0x01];
const MAGIC_2: [&[u8]; 2] = [&[0xcd, 0xf2, 0x60, 0x02], &[0x00, 0x00, 0xff, 0xff]];
const PLAIN: &[u8] = &[0x00, 0x00, 0xff, 0xff];
const COMPRESSED: &[u8] = &[0xcc, 0xcc, 0x00, 0x01];
/// Where the first record is.
const FIRST: u64 = 8;
/// Bytes of a name.
const NAME: usize = 256;
/// More dimensions than any program writes.
const MOST_DIMENSIONS: u32 = 32;

/// A CDF file of version 3 in memory, decompressed.
#[derive(Debug)]
pub struct CdfFile {
    pub(super) bytes: Vec<u8>,
    pub(super) order: ByteOrder,
    /// Whether the last dimension of a record is the one that runs first.
    pub(super) is_row_major: bool,
    variables: Vec<Variable>,
}

/// What a file says of a variable.
#[derive(Debug)]
pub(super) struct Variable {
    pub(super) name: String,
    /// Where that is.
    pub(super) at: u64,
    /// The type, as the format counts them.
    data_type: u32,
    /// How many elements a value has; those of text are letters.
    elements: u32,
    /// Sizes of a record.
    pub(super) sizes: Vec<u32>,
    /// Numbers of a record.
    pub(super) of_each: u64,
    /// How many records there are.
    pub(super) records: u64,
    /// Where it says where the records are.
    pub(super) index: Option<u64>,
    /// Where it says how they are compressed.
    pub(super) compression: Option<u64>,
}

impl CdfFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, or is no such file.
    pub fn open(path: &Path) -> Result<Self, DatasetError> {
        let failed = |source| DatasetError::Io { path: path.to_owned(), action: "read it", source };
        let bytes = std::fs::read(path).map_err(failed)?;
        Self::parse(bytes).map_err(DatasetError::cdf(path))
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// If they are no such file, with the byte.
    pub fn parse(bytes: Vec<u8>) -> Result<Self, CdfError> {
        if MAGIC_2.iter().any(|magic| bytes.starts_with(magic)) {
            return Err(CdfError::Version2);
        }
        let rest = bytes.strip_prefix(MAGIC).ok_or(CdfError::NotCdf)?;
        let bytes = if rest.starts_with(COMPRESSED) {
            inflated(&bytes)?
        } else if rest.starts_with(PLAIN) {
            bytes
        } else {
            return Err(CdfError::NotCdf);
        };
        let description = Record::of_kind(&bytes, FIRST, kind::DESCRIPTION)?;
        let order = ByteOrder::of_encoding(description.u32(28)?, FIRST + 28)?;
        let flags = description.u32(32)?;
        if flags & 2 == 0 {
            return Err(CdfError::Unsupported {
                byte: FIRST + 32,
                what: "a file whose variables are in files of their own".to_owned(),
                instead: "single files are",
            });
        }
        let global = Record::of_kind(&bytes, description.u64(12)?, kind::GLOBAL)?;
        let mut variables = Vec::new();
        for (head, kind) in [(12, kind::R_VARIABLE), (20, kind::Z_VARIABLE)] {
            let mut next = global.place(head)?;
            while let Some(at) = next {
                let record = Record::of_kind(&bytes, at, kind)?;
                variables.push(variable(record, global)?);
                // A chain that leads back never ends.
                if variables.len() * 300 > bytes.len() {
                    return Err(CdfError::malformed(at, "more variables than there is room for"));
                }
                next = record.place(12)?;
            }
        }
        Ok(Self { order, is_row_major: flags & 1 == 1, variables, bytes })
    }

    /// Names of the variables, in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|variable| variable.name.as_str())
    }

    /// The numbers of a variable.
    ///
    /// # Errors
    /// If there is no such variable, it holds no numbers, or its records are not all there.
    pub fn numbers(&self, name: &str) -> Result<CdfArray, CdfError> {
        let found = self.variables.iter().find(|variable| variable.name == name);
        let Some(variable) = found else {
            let known: Vec<String> = self.names().map(|name| format!("`{name}`")).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(CdfError::NoVariable { name: name.to_owned(), known });
        };
        let kind = NumberKind::of_type(variable.data_type, variable.at + 20)?;
        if variable.elements != 1 {
            let reason = format!("numbers of {} elements each, they have one", variable.elements);
            return Err(CdfError::malformed(variable.at + 64, reason));
        }
        values::numbers(self, variable, kind)
    }
}

/// The plain file that a compressed one holds.
fn inflated(bytes: &[u8]) -> Result<Vec<u8>, CdfError> {
    let record = Record::of_kind(bytes, FIRST, kind::COMPRESSED_FILE)?;
    compression::check(bytes, record.u64(12)?)?;
    let rest = compression::inflate(record.rest(32)?, record.u64(20)?, FIRST + 32)?;
    Ok([MAGIC, PLAIN, &rest].concat())
}

fn variable(record: Record<'_>, global: Record<'_>) -> Result<Variable, CdfError> {
    let flags = record.u32(44)?;
    let name = record.bytes(84, NAME)?;
    let name = name.split(|&byte| byte == 0).next().unwrap_or_default();
    let name = String::from_utf8_lossy(name).trim_end().to_owned();
    let after = 84 + NAME;
    // Sizes are the variable's own, or those of all variables of the older kind.
    let (count, sizes, first, varies) = if record.kind == kind::Z_VARIABLE {
        let count = record.u32(after)?;
        (count, record, after + 4, after + 4 + 4 * count.min(MOST_DIMENSIONS) as usize)
    } else {
        (global.u32(56)?, global, 84, after)
    };
    if count > MOST_DIMENSIONS {
        let reason = format!("`{name}` has {count} dimensions, {MOST_DIMENSIONS} are the most");
        return Err(CdfError::malformed(record.at, reason));
    }
    let mut found = Vec::new();
    for dimension in 0..count as usize {
        // One along which nothing varies is stored once.
        let is_varying = record.u32(varies + 4 * dimension)? != 0;
        found.push(if is_varying { sizes.u32(first + 4 * dimension)? } else { 1 });
    }
    // The last record by its number, -1 where there is none. Records that do not vary are one.
    let last = record.u32(24)?.cast_signed();
    let records = u64::try_from(i64::from(last) + 1).unwrap_or(0);
    let records = if flags & 1 == 0 { records.min(1) } else { records };
    let of_each = found.iter().try_fold(1_u64, |all, &size| all.checked_mul(size.into()));
    let numbers = of_each.and_then(|of_each| of_each.checked_mul(records.max(1)));
    let Some((of_each, _)) = of_each.zip(numbers.filter(|numbers| *numbers <= LIMIT / 8)) else {
        let what = format!("`{name}`");
        return Err(CdfError::TooLarge { byte: record.at, what, limit: LIMIT });
    };
    Ok(Variable {
        name,
        at: record.at,
        data_type: record.u32(20)?,
        elements: record.u32(64)?,
        sizes: found,
        of_each,
        records,
        index: record.place(28)?,
        compression: if flags & 4 == 0 { None } else { record.place(72)? },
    })
}
