//! Decoders of others, as crates.

use std::fs;
use std::hint::black_box;
use std::path::Path;

use anyhow::{Error, Result};
use evt3::{ColumnarEventSink, Evt3Decoder};

use crate::peer_bench::{Case, Run};

/// `case` with who else reads its file.
pub(super) fn beside(case: Case, path: &Path) -> Result<Case> {
    let ending = path.extension().unwrap_or_default();
    if ending == "evt3" || ending == "evt3-scalar" {
        Ok(case.with_peer("crate evt3, columns, from memory", evt3(path)?))
    } else {
        Ok(case)
    }
}

/// Without the time of reading the file, which it does not do in blocks.
fn evt3(path: &Path) -> Result<Run> {
    let file = fs::read(path)?;
    let end = b"% end\n";
    let header = file.windows(end.len()).position(|bytes| bytes == end);
    let words = header.ok_or_else(|| Error::msg("a header"))? + end.len();
    let mut sink = ColumnarEventSink::default();
    Ok(Box::new(move || {
        sink.cd.clear();
        sink.triggers.clear();
        Evt3Decoder::new().decode_bytes_into(&file[words..], &mut sink);
        black_box(&sink);
        Ok(())
    }))
}
