//! Files: the descriptor records, and the variables.

use crate::cdf::compression::{self, LIMIT};
use crate::cdf::kind::{number_of_type, order_of_encoding};
use crate::cdf::record::{Record, kind};
use crate::cdf::{CdfArray, CdfError, values};
use crate::number::ByteOrder;

const MAGIC: &[u8] = &[0xcd, 0xf3, 0x00, 0x01];
const MAGIC_2: [&[u8]; 2] = [&[0xcd, 0xf2, 0x60, 0x02], &[0x00, 0x00, 0xff, 0xff]];
const PLAIN: &[u8] = &[0x00, 0x00, 0xff, 0xff];
const COMPRESSED: &[u8] = &[0xcc, 0xcc, 0x00, 0x01];
/// Offset of the first record.
const FIRST: u64 = 8;
/// Bytes of a name.
const NAME_BYTES: usize = 256;
/// Maximal count of dimensions; no program writes more.
const MAX_DIMENSIONS: u32 = 32;

/// A CDF file of version 3 in memory, decompressed.
#[derive(Debug)]
pub struct CdfFile {
    pub(crate) bytes: Vec<u8>,
    pub(crate) order: ByteOrder,
    /// Whether records are in row-major order.
    pub(crate) is_row_major: bool,
    variables: Vec<Variable>,
}

/// Descriptor of a variable.
#[derive(Debug)]
pub(crate) struct Variable {
    pub(crate) name: String,
    /// Offset of the descriptor record.
    pub(crate) at: u64,
    /// The format's code of the data type.
    data_type: u32,
    /// Elements of a value; more than one for text only.
    elements: u32,
    /// Dimensions of a record.
    pub(crate) sizes: Vec<u32>,
    /// Values of a record.
    pub(crate) values_per_record: u64,
    /// Count of records.
    pub(crate) records: u64,
    /// Offset of the index of the records.
    pub(crate) index: Option<u64>,
    /// Offset of the compression record.
    pub(crate) compression: Option<u64>,
}

impl CdfFile {
    /// Parses the bytes of a file; values are decoded on request.
    ///
    /// # Errors
    /// If a byte violates the format, or the file uses a feature that is not read.
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
        let order = order_of_encoding(description.u32(28)?, FIRST + 28)?;
        let flags = description.u32(32)?;
        // A bit of the flags: one file for everything.
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
            let mut next = global.offset(head)?;
            while let Some(at) = next {
                let record = Record::of_kind(&bytes, at, kind)?;
                variables.push(variable(record, global)?);
                // A linked list that leads back to itself never ends.
                if variables.len() * 300 > bytes.len() {
                    return Err(CdfError::malformed(at, "more variables than there is room for"));
                }
                next = record.offset(12)?;
            }
        }
        Ok(Self { order, is_row_major: flags & 1 == 1, variables, bytes })
    }

    /// Names of the variables, in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|variable| variable.name.as_str())
    }

    /// Decodes the values of a variable.
    ///
    /// # Errors
    /// If there is no such variable, it is not numeric, or records are missing.
    pub fn values(&self, name: &str) -> Result<CdfArray, CdfError> {
        let variable = self.variables.iter().find(|variable| variable.name == name);
        let Some(variable) = variable else {
            let known: Vec<String> = self.names().map(|name| format!("`{name}`")).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(CdfError::NoVariable { name: name.to_owned(), known });
        };
        let kind = number_of_type(variable.data_type, variable.at + 20)?;
        if variable.elements != 1 {
            let reason = format!("values of {} elements each, they have one", variable.elements);
            return Err(CdfError::malformed(variable.at + 64, reason));
        }
        values::decode(self, variable, kind)
    }
}

/// Decompresses a file that is compressed as a whole.
fn inflated(bytes: &[u8]) -> Result<Vec<u8>, CdfError> {
    let record = Record::of_kind(bytes, FIRST, kind::COMPRESSED_FILE)?;
    compression::check(bytes, record.u64(12)?)?;
    let rest = compression::inflate(record.rest(32)?, record.u64(20)?, FIRST + 32)?;
    Ok([MAGIC, PLAIN, &rest].concat())
}

fn variable(record: Record<'_>, global: Record<'_>) -> Result<Variable, CdfError> {
    let flags = record.u32(44)?;
    let name = record.bytes(84, NAME_BYTES)?;
    let name = name.split(|&byte| byte == 0).next().unwrap_or_default();
    let name = String::from_utf8_lossy(name).trim_end().to_owned();
    let after = 84 + NAME_BYTES;
    // Sizes are the variable's own, or those of all variables of the older kind.
    let (count, sizes, first, varies) = if record.kind == kind::Z_VARIABLE {
        let count = record.u32(after)?;
        (count, record, after + 4, after + 4 + 4 * count.min(MAX_DIMENSIONS) as usize)
    } else {
        (global.u32(56)?, global, 84, after)
    };
    if count > MAX_DIMENSIONS {
        let reason = format!("`{name}` has {count} dimensions, {MAX_DIMENSIONS} are the most");
        return Err(CdfError::malformed(record.at, reason));
    }
    let mut dimensions = Vec::new();
    for dimension in 0..count as usize {
        // A dimension without variance is stored once.
        let is_varying = record.u32(varies + 4 * dimension)? != 0;
        dimensions.push(if is_varying { sizes.u32(first + 4 * dimension)? } else { 1 });
    }
    // The index of the last record, -1 without any. A variable without record variance has one
    // record.
    let last = record.u32(24)?.cast_signed();
    let records = u64::try_from(i64::from(last) + 1).unwrap_or(0);
    let records = if flags & 1 == 0 { records.min(1) } else { records };
    let values_per_record =
        dimensions.iter().try_fold(1_u64, |all, &size| all.checked_mul(size.into()));
    let value_count = values_per_record
        .and_then(|values_per_record| values_per_record.checked_mul(records.max(1)));
    let Some((values_per_record, _)) =
        values_per_record.zip(value_count.filter(|count| *count <= LIMIT / 8))
    else {
        let what = format!("`{name}`");
        return Err(CdfError::TooLarge { byte: record.at, what, limit: LIMIT });
    };
    Ok(Variable {
        name,
        at: record.at,
        data_type: record.u32(20)?,
        elements: record.u32(64)?,
        sizes: dimensions,
        values_per_record,
        records,
        index: record.offset(28)?,
        compression: if flags & 4 == 0 { None } else { record.offset(72)? },
    })
}
