//! Tensors as a pickle describes them: a shape and strides over a storage.

use std::collections::BTreeMap;

use burn::tensor::{Bytes, DType, TensorData};
use evpose_containers::pickle::{Id, Pickle, PickleValue};

use super::container::Container;
use crate::weights::strict::TensorError;

/// The storage classes of `torch`: bytes of an element, and its type where a weight can have it.
const STORAGES: [(&str, usize, Option<DType>); 12] = [
    ("FloatStorage", 4, Some(DType::F32)),
    ("DoubleStorage", 8, Some(DType::F64)),
    ("HalfStorage", 2, Some(DType::F16)),
    ("BFloat16Storage", 2, Some(DType::BF16)),
    ("LongStorage", 8, None),
    ("IntStorage", 4, None),
    ("ShortStorage", 2, None),
    ("CharStorage", 1, None),
    ("ByteStorage", 1, None),
    ("BoolStorage", 1, None),
    ("ComplexFloatStorage", 8, None),
    ("ComplexDoubleStorage", 16, None),
];

/// A tensor: a view of a storage.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct View {
    /// Its storage's name in the container.
    storage: String,
    size: usize,
    dtype: Option<DType>,
    /// In elements, as the strides.
    offset: usize,
    pub(super) shape: Vec<usize>,
    strides: Vec<usize>,
}

impl View {
    /// The tensor or parameter at `id`, if it is one.
    ///
    /// # Model
    /// `torch._utils._rebuild_tensor_v2(storage, offset, shape, strides, ...)`, for a parameter
    /// inside `torch._utils._rebuild_parameter(tensor, ...)`.
    pub(super) fn from_pickle(pickle: &Pickle, id: Id) -> Option<Self> {
        let (function, arguments) = call(pickle, id)?;
        // A parameter wraps a tensor; state dicts hold either.
        let (function, arguments) = match (function, arguments) {
            ("_rebuild_parameter", &[tensor, ..]) => call(pickle, tensor)?,
            other => other,
        };
        // Other functions rebuild what is no tensor of weights.
        let ("_rebuild_tensor_v2", &[storage, offset, shape, strides, ..]) = (function, arguments)
        else {
            return None;
        };
        let (storage, size, dtype) = storage_of(pickle, pickle.node(storage))?;
        let (offset, shape) = (pickle.size(offset)?, pickle.sizes(shape)?);
        let strides = pickle.sizes(strides)?;
        // A stride for each side, or the pickle is damaged.
        (shape.len() == strides.len()).then(|| Self {
            storage: storage.to_owned(),
            size,
            dtype,
            offset,
            shape,
            strides,
        })
    }

    /// Its values in row-major order.
    ///
    /// # Errors
    /// If they are no floats, or lie outside of their storage.
    pub(super) fn values(&self, container: &Container) -> Result<Vec<f32>, TensorError> {
        let dtype = self.dtype.ok_or("its values are no floats")?;
        let storage = container.storage(&self.storage);
        let missing = || TensorError::of(format!("storage {} is missing", self.storage));
        let storage = storage.ok_or_else(missing)?;
        // Nearly all weights are contiguous: one copy does instead of one for each element.
        let bytes = if self.is_contiguous() { self.slice(storage) } else { self.gather(storage) };
        let outside = || TensorError::of(format!("it lies outside of storage {}", self.storage));
        let bytes = bytes.ok_or_else(outside)?;
        let data = TensorData::from_bytes(Bytes::from_bytes_vec(bytes), self.shape.clone(), dtype);
        Ok(data.iter::<f32>().collect())
    }

    fn count(&self) -> Option<usize> {
        self.shape.iter().try_fold(1usize, |count, &length| count.checked_mul(length))
    }

    fn is_contiguous(&self) -> bool {
        let mut expected = Some(1usize);
        self.shape.iter().zip(&self.strides).rev().all(|(&length, &stride)| {
            let here = length <= 1 || expected == Some(stride);
            expected = expected.and_then(|stride| stride.checked_mul(length));
            here
        })
    }

    fn slice(&self, storage: &[u8]) -> Option<Vec<u8>> {
        let start = self.offset.checked_mul(self.size)?;
        let length = self.count()?.checked_mul(self.size)?;
        Some(storage.get(start..)?.get(..length)?.to_vec())
    }

    fn gather(&self, storage: &[u8]) -> Option<Vec<u8>> {
        let mut gathered = Vec::new();
        let mut position = vec![0; self.shape.len()];
        for _ in 0..self.count()? {
            // Element by element, since strides may be of any order, as of a transposed tensor.
            let mut index = self.offset;
            for (&at, &stride) in position.iter().zip(&self.strides) {
                index = index.checked_add(stride.checked_mul(at)?)?;
            }
            let start = index.checked_mul(self.size)?;
            gathered.extend_from_slice(storage.get(start..)?.get(..self.size)?);
            // The last index runs fastest: row-major order.
            for (at, &length) in position.iter_mut().zip(&self.shape).rev() {
                *at = (*at + 1) % length;
                if *at != 0 {
                    break;
                }
            }
        }
        Some(gathered)
    }
}

/// Bytes of an element for every storage that a pickle mentions.
pub(super) fn element_sizes(pickle: &Pickle) -> BTreeMap<&str, usize> {
    let storages = pickle.nodes().iter().filter_map(|node| storage_of(pickle, node));
    storages.map(|(key, size, _)| (key, size)).collect()
}

/// The function of `torch._utils` that is called at `id`, and its arguments.
fn call(pickle: &Pickle, id: Id) -> Option<(&str, &[Id])> {
    let (module, name, arguments) = pickle.call(id)?;
    (module == "torch._utils").then_some((name, arguments))
}

/// The key and element of a persistent id `("storage", class, key, device, length, ...)`.
fn storage_of<'a>(
    pickle: &'a Pickle,
    node: &PickleValue,
) -> Option<(&'a str, usize, Option<DType>)> {
    let PickleValue::Persistent(id) = node else { return None };
    let &[_, class, key, ..] = pickle.sequence(*id)? else { return None };
    let PickleValue::Global { name: class, .. } = pickle.node(class) else { return None };
    let (_, size, dtype) = STORAGES.into_iter().find(|(name, ..)| name == class)?;
    Some((pickle.text(key)?, size, dtype))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(shape: &[usize], strides: &[usize], offset: usize) -> View {
        View {
            storage: "0".to_owned(),
            size: 1,
            dtype: None,
            offset,
            shape: shape.to_vec(),
            strides: strides.to_vec(),
        }
    }

    #[test]
    fn a_transposed_view_is_gathered_row_by_row() {
        let storage = [0, 1, 2, 3, 4, 5, 6];
        let transposed = view(&[3, 2], &[1, 3], 1);
        assert!(!transposed.is_contiguous());
        assert_eq!(transposed.gather(&storage).unwrap(), [1, 4, 2, 5, 3, 6]);
        let plain = view(&[2, 3], &[3, 1], 1);
        assert!(plain.is_contiguous());
        assert_eq!(plain.slice(&storage), plain.gather(&storage));
    }

    #[test]
    fn views_beyond_their_storage_are_refused() {
        let storage = [0; 6];
        assert_eq!(view(&[7], &[1], 0).slice(&storage), None);
        assert_eq!(view(&[2, 2], &[1, 5], 0).gather(&storage), None);
        assert_eq!(view(&[usize::MAX, 2], &[2, 1], 0).slice(&storage), None);
        assert_eq!(view(&[2], &[usize::MAX], 2).gather(&storage), None);
    }
}
