//! Constants of chumpy, the library with which the published body models were fitted.
//!
//! # Model
//! `chumpy.ch.Ch` holds an array `x`. `chumpy.reordering.Select` takes the entries `idxs` of the
//! flattened constant `a`, in the shape `preferred_shape` if it has one.
//!
//! # Source
//! chumpy 0.70, `ch.py` and `reordering.py`.

use crate::pickle::array::{Array, ArrayError, describe, index};
use crate::pickle::{Id, Pickle};

const BEYOND: &str = "an index beyond its array";
/// Maximal depth of nested selections. Files have one; more may be a loop.
const MAX_LEVELS: usize = 8;

/// Reads an array, whether it is a constant or not.
pub(crate) fn read(pickle: &Pickle, id: Id) -> Result<Array, ArrayError> {
    read_level(pickle, id, 0)
}

fn read_level(pickle: &Pickle, id: Id, level: usize) -> Result<Array, ArrayError> {
    if level > MAX_LEVELS {
        return Err(ArrayError::Damaged("selections inside of each other without an end"));
    }
    let Some((module, name)) = pickle.class(id) else { return Array::plain(pickle, id) };
    if module != "chumpy" && !module.starts_with("chumpy.") {
        return Array::plain(pickle, id);
    }
    let attribute = |name| pickle.attribute(id, name);
    match name {
        "Ch" => {
            let content = attribute("x").ok_or(ArrayError::Damaged("a constant without `x`"))?;
            read_level(pickle, content, level + 1)
        }
        "Select" => {
            let source = attribute("a").ok_or(ArrayError::Damaged("a selection without `a`"))?;
            let indices =
                attribute("idxs").ok_or(ArrayError::Damaged("a selection without `idxs`"))?;
            let source = read_level(pickle, source, level + 1)?;
            let shape = match attribute("preferred_shape") {
                None => None,
                Some(shape) => Some(shape_of(pickle, shape)?),
            };
            select(&source, Array::plain(pickle, indices)?, shape)
        }
        _ => Err(ArrayError::Other(describe(pickle, id))),
    }
}

/// A shape, written as a tuple, as an array or as one number.
fn shape_of(pickle: &Pickle, id: Id) -> Result<Vec<usize>, ArrayError> {
    if let Some(shape) = pickle.sizes(id) {
        return Ok(shape);
    }
    let shape = Array::plain(pickle, id)?;
    shape.values.iter().map(|&length| index(length, u32::MAX as usize, BEYOND)).collect()
}

fn select(source: &Array, indices: Array, shape: Option<Vec<usize>>) -> Result<Array, ArrayError> {
    let values: Vec<f64> = indices
        .values
        .iter()
        .map(|&at| Ok(source.values[index(at, source.values.len(), BEYOND)?]))
        .collect::<Result<_, ArrayError>>()?;
    let shape = shape.unwrap_or(indices.shape);
    let count = shape.iter().try_fold(1usize, |count, &length| count.checked_mul(length));
    if count != Some(values.len()) {
        return Err(ArrayError::Damaged("a selection of another size than its shape"));
    }
    Ok(Array { shape, values })
}
