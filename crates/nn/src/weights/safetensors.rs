//! Networks as safetensors files under their names in PyTorch, whose state dictionary they become.
//!
//! # Source
//! <https://huggingface.co/docs/safetensors>: the length of the header in eight bytes, the header
//! in JSON padded with spaces, the values; all little-endian.

use std::path::Path;

use evpose_core::atomic_write;

use crate::parameters::read;
use crate::{MoveEnet, NnError};

/// Bytes to whose multiples headers are padded, so that values are aligned.
const ALIGNMENT: usize = 8;

/// Writes `network` to `path`, whole or not at all. What PyTorch calls `num_batches_tracked` is
/// left out: `load_state_dict` takes it for zero.
///
/// # Errors
/// [`NnError::Io`] if the file cannot be written.
pub fn save_safetensors(path: &Path, network: &MoveEnet) -> Result<(), NnError> {
    let (mut entries, mut data) = (Vec::new(), Vec::new());
    for (slot, values) in read(network) {
        let begin = data.len();
        data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        // Names are of letters, digits, dots and underscores; shapes print as JSON.
        entries.push(format!(
            r#""{}":{{"dtype":"F32","shape":{:?},"data_offsets":[{begin},{}]}}"#,
            network.pytorch_name(&slot),
            slot.shape,
            data.len()
        ));
    }
    let mut header = format!("{{{}}}", entries.join(","));
    let padded = header.len().next_multiple_of(ALIGNMENT);
    header.extend(std::iter::repeat_n(' ', padded - header.len()));
    let length = (header.len() as u64).to_le_bytes();
    let bytes = [&length, header.as_bytes(), &data].concat();
    atomic_write(path, &bytes).map_err(|source| NnError::Io { path: path.to_owned(), source })
}
