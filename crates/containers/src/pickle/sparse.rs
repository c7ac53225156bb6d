//! Sparse matrices of scipy, out of a pickle.
//!
//! # Model
//! Compressed columns (`csc`): entries `indptr[c]..indptr[c + 1]` of `indices` (rows) and `data`
//! are those of column `c`; compressed rows (`csr`) likewise with rows and columns exchanged; `coo`
//! lists `row`, `col` and `data`.
//!
//! # Source
//! scipy's `sparse/_compressed.py` and `_coo.py`; attributes are the same since version 0.7.

use crate::pickle::array::{Array, ArrayError, describe, index};
use crate::pickle::{Id, Pickle};

/// A matrix of which most entries are zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Sparse {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Row, column and value; entries at the same place add up.
    pub entries: Vec<(usize, usize, f64)>,
}

impl Sparse {
    /// The matrix at `id`; none if it is something else.
    ///
    /// # Errors
    /// If it is a sparse matrix that is damaged or of a kind that is not read.
    pub fn read(pickle: &Pickle, id: Id) -> Option<Result<Self, ArrayError>> {
        let (module, name) = pickle.class(id)?;
        if !module.starts_with("scipy.sparse") {
            return None;
        }
        let kind = name.trim_end_matches("_matrix").trim_end_matches("_array");
        Some(match kind {
            "csc" => Self::compressed(pickle, id, true),
            "csr" => Self::compressed(pickle, id, false),
            "coo" => Self::listed(pickle, id),
            _ => Err(ArrayError::Other(describe(pickle, id))),
        })
    }

    fn compressed(pickle: &Pickle, id: Id, by_columns: bool) -> Result<Self, ArrayError> {
        let shape = shape(pickle, id)?;
        let [lines, across] = if by_columns { [shape[1], shape[0]] } else { shape };
        let starts = array_values(pickle, id, "indptr")?;
        let (indices, data) =
            (array_values(pickle, id, "indices")?, array_values(pickle, id, "data")?);
        if starts.len() != lines.saturating_add(1) || starts.first() != Some(&0.0) {
            return Err(ArrayError::Damaged("`indptr` is not of its shape"));
        }
        let mut entries = Vec::new();
        for (line, pair) in starts.windows(2).enumerate() {
            let (start, end) = (pair[0] as usize, pair[1] as usize);
            // Casts saturate: starts that descend or have a fraction are refused by themselves.
            let is_range = pair[0] <= pair[1] && pair[1].fract() == 0.0;
            let part =
                if is_range { indices.get(start..end).zip(data.get(start..end)) } else { None };
            let (indices, data) = part.ok_or(ArrayError::Damaged("`indptr` is out of order"))?;
            for (&index, &value) in indices.iter().zip(data) {
                let index = place(index, across)?;
                entries.push(if by_columns { (index, line, value) } else { (line, index, value) });
            }
        }
        Ok(Self { shape, entries })
    }

    fn listed(pickle: &Pickle, id: Id) -> Result<Self, ArrayError> {
        let shape = shape(pickle, id)?;
        let (rows, columns) = (array_values(pickle, id, "row")?, array_values(pickle, id, "col")?);
        Self::from_triplets(shape, &rows, &columns, &array_values(pickle, id, "data")?)
    }

    /// The matrix of these entries.
    ///
    /// # Errors
    /// If there are not as many of each, or one lies outside.
    pub fn from_triplets(
        shape: [usize; 2],
        rows: &[f64],
        columns: &[f64],
        values: &[f64],
    ) -> Result<Self, ArrayError> {
        if rows.len() != values.len() || columns.len() != values.len() {
            return Err(ArrayError::Damaged("not as many rows and columns as values"));
        }
        let places = rows.iter().zip(columns);
        let entries = places.zip(values).map(|((&row, &column), &value)| {
            Ok((place(row, shape[0])?, place(column, shape[1])?, value))
        });
        Ok(Self { shape, entries: entries.collect::<Result<_, ArrayError>>()? })
    }
}

fn shape(pickle: &Pickle, id: Id) -> Result<[usize; 2], ArrayError> {
    let shape = pickle.attribute(id, "_shape").or_else(|| pickle.attribute(id, "shape"));
    let shape = shape.and_then(|shape| pickle.sizes(shape));
    shape.and_then(|s| s.try_into().ok()).ok_or(ArrayError::Damaged("a matrix without a shape"))
}

fn array_values(pickle: &Pickle, id: Id, name: &'static str) -> Result<Vec<f64>, ArrayError> {
    let id = pickle.attribute(id, name);
    let id = id.ok_or(ArrayError::Damaged("a sparse matrix without indptr, indices or data"))?;
    Ok(Array::plain(pickle, id)?.values)
}

fn place(value: f64, limit: usize) -> Result<usize, ArrayError> {
    index(value, limit, "an index beyond its matrix")
}
