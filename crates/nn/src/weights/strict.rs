//! Strict loading: every tensor of the network from the file, and none left over.

use std::collections::BTreeMap;
use std::path::Path;

use burn::module::Module;
use burn::tensor::TensorData;

use crate::NnError;
use crate::error::Mismatch;
use crate::parameters::{Slot, fill_with_data, slots};

/// A tensor that a weight file lacks, or the message of a reader of its container.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct TensorError(String);

impl TensorError {
    #[allow(clippy::needless_pass_by_value, reason = "errors come by value")]
    pub(super) fn of(reason: impl ToString) -> Self {
        Self(reason.to_string())
    }
}

impl From<&str> for TensorError {
    fn from(reason: &str) -> Self {
        Self::of(reason)
    }
}

/// A tensor of a file, its values not yet read.
pub(super) struct Stored {
    /// Its shape in the file.
    pub(super) shape: Vec<usize>,
    /// Reads its values, `f32` in row-major order; the error is the reason.
    pub(super) read: Box<dyn FnOnce() -> Result<TensorData, TensorError>>,
}

impl Stored {
    /// A tensor whose values `read` brings into memory.
    pub(super) fn new(
        shape: Vec<usize>,
        read: impl FnOnce() -> Result<Vec<f32>, TensorError> + 'static,
    ) -> Self {
        let read = move || {
            let values = read()?;
            let count = values.len();
            Ok(TensorData::new(values, [count]))
        };
        Self { shape, read: Box::new(read) }
    }
}

/// Names, shapes and order of a network's tensors in a file format. The defaults are our own.
pub(super) trait Layout {
    /// The name of a tensor.
    fn name(&self, slot: &Slot) -> String {
        slot.path.clone()
    }

    /// The shape of a tensor.
    fn shape(&self, slot: &Slot) -> Vec<usize> {
        slot.shape.clone()
    }

    /// The values of a tensor in the order of the network, where the file has another.
    fn reordered(&self, _slot: &Slot, _values: &[f32]) -> Option<Vec<f32>> {
        None
    }
}

/// Gives every tensor of `network` its values in `file`.
///
/// # Errors
/// [`NnError::Mismatch`] if the tensors are not the network's, [`NnError::Unreadable`] if one
/// cannot be read.
pub(super) fn fill_strictly<M: Module>(
    network: M,
    layout: &impl Layout,
    mut file: BTreeMap<String, Stored>,
    path: &Path,
    format: &'static str,
) -> Result<M, NnError> {
    // All differences are collected before any tensor is read: one error names them all.
    let mut mismatch = Mismatch::default();
    let mut matched = Vec::new();
    for slot in slots(&network) {
        let (name, shape) = (layout.name(&slot), layout.shape(&slot));
        match file.remove(&name) {
            None => mismatch.missing.push(name),
            Some(stored) if stored.shape != shape => {
                mismatch.reshaped.push((name, shape, stored.shape));
            }
            Some(stored) => matched.push((slot, name, stored)),
        }
    }
    // No tensor of the network has these names.
    mismatch.unexpected = file.into_keys().collect();
    // In order, so that messages do not depend on the network's traversal.
    mismatch.missing.sort();
    mismatch.reshaped.sort();
    if !mismatch.is_empty() {
        return Err(NnError::Mismatch { path: path.to_owned(), mismatch });
    }

    let mut values = BTreeMap::new();
    for (slot, name, stored) in matched {
        let count: usize = slot.shape.iter().product();
        let read = (stored.read)().and_then(|data| {
            let length = data.num_elements();
            // Checked again: the shape is what the file says, the values are what it has.
            if length != count {
                return Err(TensorError(format!("{length} values for {count}")));
            }
            let values =
                data.as_slice::<f32>().map_err(|error| TensorError(format!("{error:?}")))?;
            // PyTorch stores linear weights transposed, Keras kernels with their channels last.
            Ok(match layout.reordered(&slot, values) {
                Some(values) => TensorData::new(values, slot.shape.clone()),
                // In the network's order already: moved, not copied.
                None => data,
            })
        });
        let read = read.map_err(|reason| NnError::Unreadable {
            path: path.to_owned(),
            format,
            reason: format!("{name}: {reason}"),
        })?;
        values.insert(slot.path, read);
    }
    let value = |slot: &Slot| {
        let value = values.remove(&slot.path);
        value.unwrap_or_else(|| unreachable!("every slot was matched and counted"))
    };
    Ok(fill_with_data(network, value))
}
