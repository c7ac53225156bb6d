//! Streams of a network: what anybody may send.

use std::io::Read;

use evpose_io::aedat4::Aedat4Stream;
use evpose_io::framed::FramedReader;
use evpose_io::{Columns, IoError};

use crate::check;

/// No batch is longer: 256 MiB of 16 bytes each, which a packet may hold.
const LONGEST_BATCH: usize = 1 << 24;

/// Gives bytes a few at a time, as a network does.
struct Wire<'a>(&'a [u8]);

impl Read for Wire<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let count = out.len().min(61);
        (&mut self.0).take(count as u64).read(out)
    }
}

/// Reads `bytes` as a framed stream, and as one of AEDAT 4.0.
///
/// # Panics
/// If a stream has no end, or a fault lies behind it.
pub fn streams(bytes: &[u8]) {
    match FramedReader::open("fuzz", Wire(bytes)) {
        Ok(mut reader) => to_the_end(bytes.len(), |columns| reader.next(columns)),
        Err(error) => check(&error, bytes.len()),
    }
    match Aedat4Stream::open("fuzz", Wire(bytes), 0) {
        Ok(mut reader) => to_the_end(bytes.len(), |columns| reader.next(columns)),
        Err(error) => check(&error, bytes.len()),
    }
}

fn to_the_end(length: usize, mut next: impl FnMut(&mut Columns) -> Result<bool, IoError>) {
    let mut columns = Columns::new();
    // Every call takes at least a byte, or is the last.
    for _ in 0..=length + 1 {
        columns.clear();
        match next(&mut columns) {
            Ok(true) => assert!(!columns.is_empty() && columns.len() <= LONGEST_BATCH),
            Ok(false) => return,
            Err(error) => return check(&error, length),
        }
    }
    panic!("a stream without an end");
}
