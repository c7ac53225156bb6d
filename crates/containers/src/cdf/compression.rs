//! Gzip-compressed files and variables.

use std::io::Read;

use flate2::read::GzDecoder;

use crate::cdf::CdfError;
use crate::cdf::record::{Record, kind};

/// Maximal bytes of a decompressed file or variable, against data that expand without end.
pub(crate) const LIMIT: u64 = 1 << 30;

/// The format's code of gzip.
const GZIP: u32 = 5;

/// Checks that the compression record at `at` is of gzip, the only compression that is read.
pub(crate) fn check(file: &[u8], at: u64) -> Result<(), CdfError> {
    let kind = Record::of_kind(file, at, kind::COMPRESSION)?.u32(12)?;
    if kind == GZIP {
        return Ok(());
    }
    let what = match kind {
        1 => "run lengths of zeros".to_owned(),
        2 => "a Huffman code".to_owned(),
        3 => "an adaptive Huffman code".to_owned(),
        _ => format!("compression number {kind}"),
    };
    let instead = "gzip is: NASA's `cdfconvert -compression cdf:gzip.6 FILE NEW` makes it so";
    Err(CdfError::Unsupported { byte: at, what, instead })
}

/// Decompresses `bytes`, which stand at `byte` of the file, to exactly `length` bytes.
pub(crate) fn inflate(bytes: &[u8], length: u64, byte: u64) -> Result<Vec<u8>, CdfError> {
    if length > LIMIT {
        let what = "what is compressed here".to_owned();
        return Err(CdfError::TooLarge { byte, what, limit: LIMIT });
    }
    let mut out = Vec::new();
    // One more, to see whether there is more.
    let read = GzDecoder::new(bytes).take(length + 1).read_to_end(&mut out);
    let reason = match read {
        Err(error) => format!("cannot be decompressed: {error}"),
        Ok(_) if out.len() as u64 == length => return Ok(out),
        Ok(_) if out.len() as u64 > length => {
            format!("more than {length} bytes are compressed here")
        }
        Ok(actual) => format!("{length} bytes should be compressed here, there are {actual}"),
    };
    Err(CdfError::malformed(byte, reason))
}
