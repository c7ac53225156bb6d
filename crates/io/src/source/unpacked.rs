//! Recordings that gzip, Zstandard or zip packed as a whole, as archives of data sets have them.

use std::io::{ErrorKind, Read, Seek};

use zip::ZipArchive;
use zrip::DecompressError;

use super::Input;
use crate::IoError;

const GZIP: &[u8] = b"\x1f\x8b";
/// How archives begin, those of NumPy among them.
const ZIP: &[u8] = b"PK\x03\x04";
const ZSTANDARD: &[u8] = b"\x28\xb5\x2f\xfd";
/// Unpacked bytes that are held in memory, at most.
const MAX_BYTES: u64 = 1 << 31;
/// Of which so many of any file, and more only where each of its bytes becomes no more than so many:
/// events do not shrink to less.
const ALWAYS: u64 = 1 << 28;
const MAX_RATIO: u64 = 64;

/// How to mend a packed file that ends early.
pub(crate) const CUT: &str = "it was cut: fetch it again";

/// Bytes to which a file of `length` bytes may unpack in memory: files of a few megabytes unpack to
/// gigabytes of zeros.
pub(crate) fn max_unpacked(length: u64) -> u64 {
    ALWAYS.max(length.saturating_mul(MAX_RATIO))
}

/// The input itself, or what it was packed from, in memory.
///
/// # Errors
/// If it cannot be read, is damaged, or holds more than 2 GiB, or than 256 MiB and 64 times its
/// length.
pub(crate) fn unpacked(mut input: Input) -> Result<Input, IoError> {
    let head = input.head(4)?;
    let limit = max_unpacked(input.length).min(MAX_BYTES);
    let mut bytes = Vec::new();
    if head == ZIP {
        return of_archive(input, limit);
    }
    let damaged = |reason: String| IoError::damaged(&input.path, 0, reason);
    if head.starts_with(GZIP) {
        let unpacked = flate2::read::MultiGzDecoder::new(input.bytes);
        // One more than the limit, to see whether there is more.
        unpacked.take(limit + 1).read_to_end(&mut bytes).map_err(|fault| match fault.kind() {
            ErrorKind::UnexpectedEof => damaged(format!("gzip: {CUT}")),
            _ => damaged(format!("gzip: {fault}")),
        })?;
    } else if head == ZSTANDARD {
        let mut packed = Vec::new();
        input
            .bytes
            .take(MAX_BYTES)
            .read_to_end(&mut packed)
            .map_err(|fault| IoError::file(&input.path, "read", fault))?;
        bytes =
            zrip::decompress_with_limit(&packed, limit as usize).map_err(|fault| match fault {
                DecompressError::InputExhausted => damaged(format!("Zstandard: {CUT}")),
                fault => damaged(format!("Zstandard: {fault}")),
            })?;
    } else {
        return Ok(input);
    }
    if bytes.len() as u64 > limit {
        return Err(damaged(format!("it holds more than {limit} bytes: unpack it first")));
    }
    Ok(Input::memory(input.path, bytes))
}

/// The one file of an archive, or the archive itself if it is one of arrays.
fn of_archive(mut input: Input, limit: u64) -> Result<Input, IoError> {
    let mut bytes = Vec::new();
    // Whatever cannot be opened is left to the reader of arrays, which says why.
    if let Ok(mut archive) = ZipArchive::new(&mut input.bytes) {
        // Folders, and what macOS and others put beside the files, are none.
        let is_file = |name: &String| {
            let is_hidden =
                |part: &str| part == "__MACOSX" || (part.starts_with('.') && part != ".");
            !name.ends_with('/') && !name.split('/').any(is_hidden)
        };
        let names = archive.file_names_raw().map(|name| String::from_utf8_lossy(name).into_owned());
        let names: Vec<String> = names.filter(is_file).collect();
        let is_of_arrays = names.iter().any(|name| name.ends_with(".npy"));
        let stream = |reason| IoError::Stream { path: input.path.clone(), reason };
        // A broken list may name a place that no file of this length has.
        let damaged = |byte: u64, reason: String| {
            IoError::damaged(&input.path, byte.min(input.length), reason)
        };
        match names.as_slice() {
            [only] if !is_of_arrays => {
                let entry =
                    archive.by_name(only).map_err(|fault| damaged(0, format!("zip: {fault}")))?;
                let byte = entry.data_start().unwrap_or(0);
                let read = entry.take(limit + 1).read_to_end(&mut bytes);
                read.map_err(|fault| damaged(byte, format!("zip: {only}: {fault}")))?;
                if bytes.len() as u64 > limit {
                    let reason = format!("{only} holds more than {limit} bytes: unpack it first");
                    return Err(stream(reason));
                }
                return Ok(Input::memory(input.path, bytes));
            }
            [_, _, ..] if !is_of_arrays => {
                let names = names.join(", ");
                return Err(stream(format!(
                    "a zip of several files ({names}): unpack one of them"
                )));
            }
            _ => {}
        }
    }
    let rewound = input.bytes.rewind();
    rewound.map_err(|fault| IoError::file(&input.path, "read", fault))?;
    Ok(input)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;
    use crate::{OpenOptions, read_as};

    #[test]
    fn a_damaged_zip_is_damage_with_its_byte() {
        let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let options = zip::write::SimpleFileOptions::default();
        zip.start_file("events.txt", options).unwrap();
        let lines = (0..400).map(|k| format!("{} {} 7 1\n", 90 * k, k * k % 300));
        zip.write_all(("346 260\n".to_owned() + &lines.collect::<String>()).as_bytes()).unwrap();
        let bytes = zip.finish().unwrap().into_inner();
        // 30 bytes and the name are before the data. Of these, then of the header, a bit is changed.
        let begin = 30 + "events.txt".len();
        for (at, byte) in [(begin + 50, begin as u64), (2, 0)] {
            let mut changed = bytes.clone();
            changed[at] ^= 0x10;
            let input = Input::memory("events.zip", changed);
            let damage = of_archive(input, ALWAYS).map(|_| ()).unwrap_err();
            assert!(damage.is_damage() && damage.byte() == Some(byte), "{damage}");
            assert!(damage.to_string().starts_with("events.zip: byte "), "{damage}");
        }
    }

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
            for length in [packed.len() / 2, packed.len() - 3] {
                let cut = open(&packed[..length]).unwrap_err().to_string();
                assert!(
                    cut.contains("gzip: it was cut") || cut.contains("Zstandard: it was cut"),
                    "{cut}"
                );
            }
        }
        let zipped = |names: &[&str]| {
            let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
            for name in names {
                zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
                zip.write_all(text.as_bytes()).unwrap();
            }
            zip.finish().unwrap().into_inner()
        };
        let read = |bytes| read_as(Input::memory("events.zip", bytes), &OpenOptions::default());
        let zip = |names: &[&str]| read(zipped(names));
        let mut cut = zipped(&["events.txt"]);
        cut.truncate(cut.len() - 30);
        let cut = read(cut).unwrap_err().to_string();
        assert!(cut.contains("it was cut: fetch it again"), "{cut}");
        let one = zip(&["a/", "a/events.txt", "__MACOSX/a/._events.txt", ".DS_Store"]).unwrap();
        assert_eq!((one.format, one.stream.len()), ("text", 2));
        let error = zip(&["a.txt", "b.txt"]).unwrap_err().to_string();
        assert!(error.contains("several files (a.txt, b.txt)"), "{error}");
        let mut bomb = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::copy(&mut std::io::repeat(b' ').take(ALWAYS + 9), &mut bomb).unwrap();
        let bomb = Input::memory("events.txt.gz", bomb.finish().unwrap());
        let error = read_as(bomb, &OpenOptions::default()).unwrap_err().to_string();
        assert!(error.contains("268435456 bytes: unpack it first"), "{error}");
    }
}
