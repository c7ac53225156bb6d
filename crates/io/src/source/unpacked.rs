//! Recordings that gzip or Zstandard packed as a whole, as archives of data sets have them.

use std::io::Read;

use super::Input;
use crate::IoError;

const GZIP: &[u8] = b"\x1f\x8b";
const ZSTANDARD: &[u8] = b"\x28\xb5\x2f\xfd";
/// Unpacked bytes that are held in memory, at most.
const MAX_BYTES: u64 = 1 << 31;

/// The input itself, or what it was packed from, in memory.
///
/// # Errors
/// If it cannot be read, is damaged, or holds more than 2 GiB.
pub(crate) fn unpacked(mut input: Input) -> Result<Input, IoError> {
    let head = input.head(4)?;
    let mut bytes = Vec::new();
    let damaged = |reason: String| IoError::Damaged {
        path: input.path.clone(),
        byte: 0,
        reason: reason.into(),
        events: 0,
    };
    if head.starts_with(GZIP) {
        let unpacked = flate2::read::MultiGzDecoder::new(input.bytes);
        unpacked
            .take(MAX_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(|fault| damaged(format!("gzip: {fault}")))?;
    } else if head == ZSTANDARD {
        let mut packed = Vec::new();
        input
            .bytes
            .take(MAX_BYTES)
            .read_to_end(&mut packed)
            .map_err(|fault| IoError::file(&input.path, "read", fault))?;
        bytes = zrip::decompress_with_limit(&packed, MAX_BYTES as usize)
            .map_err(|fault| damaged(format!("Zstandard: {fault}")))?;
    } else {
        return Ok(input);
    }
    if bytes.len() as u64 > MAX_BYTES {
        return Err(damaged("it holds more than 2 GiB: unpack it first".to_owned()));
    }
    Ok(Input::memory(input.path, bytes))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use std::io::Write as _;

    use super::*;
    use crate::{OpenOptions, read_as};

    #[test]
    fn packed_recordings_are_read_and_cut_ones_refused() {
        let text = "346 260\n5 96 133 0\n9 97 12 1\n";
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gzip.write_all(text.as_bytes()).unwrap();
        let packed = [gzip.finish().unwrap(), zrip::compress(text.as_bytes(), 3).unwrap()];
        for packed in packed {
            let open = |bytes: &[u8]| {
                read_as(Input::memory("events.txt.gz", bytes.to_vec()), &OpenOptions::default())
            };
            assert_eq!(open(&packed).unwrap().stream.len(), 2);
            let cut = open(&packed[..packed.len() - 3]).unwrap_err().to_string();
            assert!(cut.contains("gzip") || cut.contains("Zstandard"), "{cut}");
        }
    }
}
