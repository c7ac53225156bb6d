//! Numeric arrays of a pickle.
//!
//! # Source
//! `numpy/core/src/multiarray/methods.c`, `array_reduce` and `array_setstate`; `descriptor.c`,
//! `arraydescr_reduce`.

use std::borrow::Cow;

use crate::number::row_major;
use crate::pickle::{Element, Id, Pickle, PickleValue};

/// Dimensions that numpy itself allows.
const MAX_DIMENSIONS: usize = 32;

/// A numeric array in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Length along every axis; empty for a scalar.
    pub shape: Vec<usize>,
    /// Values, the last axis fastest. Integers beyond 2^53 are rounded.
    pub values: Vec<f64>,
}

/// Error of a value that is not a numeric array.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ArrayError {
    /// Another value.
    #[error("{0} instead of a numeric array")]
    Other(String),
    /// Elements that are Python objects.
    #[error("an array of Python objects instead of numeric values; store it as f4 or f8")]
    Objects,
    /// Elements of an unknown type.
    #[error("values of the unknown type `{0}`; store it as f4, f8 or integers of up to 8 bytes")]
    Type(String),
    /// Content of another length than the shape.
    #[error("its shape {shape:?} takes {expected} bytes, {actual} are there")]
    Length {
        /// Lengths along its axes.
        shape: Vec<usize>,
        /// Bytes of an array of this shape, as text because it may exceed every integer.
        expected: String,
        /// Bytes of the content.
        actual: usize,
    },
    /// A description that neither numpy nor scipy nor chumpy writes.
    #[error("its description is damaged: {0}")]
    Damaged(&'static str),
}

impl Array {
    /// Decodes `bytes` as an array of this shape.
    ///
    /// # Errors
    /// [`ArrayError::Length`] unless there are exactly as many as the shape says.
    pub fn from_bytes(
        shape: Vec<usize>,
        element: Element,
        is_column_major: bool,
        bytes: &[u8],
    ) -> Result<Self, ArrayError> {
        if shape.len() > MAX_DIMENSIONS {
            return Err(ArrayError::Damaged("more than 32 dimensions"));
        }
        // The product of the sizes of a damaged file may overflow.
        let count = shape.iter().try_fold(1usize, |count, &length| count.checked_mul(length));
        let expected = count.and_then(|count| count.checked_mul(element.size()));
        if expected != Some(bytes.len()) {
            let expected = expected.map_or("too many".to_owned(), |bytes| bytes.to_string());
            return Err(ArrayError::Length { shape, expected, actual: bytes.len() });
        }
        let values = bytes.chunks_exact(element.size()).map(|bytes| element.decode(bytes));
        let mut values: Vec<f64> = values.collect();
        if is_column_major {
            values = row_major(&values, &shape);
        }
        Ok(Self { shape, values })
    }

    /// Reads the numeric array at `id`: an array or scalar of numpy, a scalar, or a constant of
    /// chumpy (an array that a fitting program could differentiate by).
    ///
    /// # Errors
    /// If the value is none of these, or damaged.
    pub fn read(pickle: &Pickle, id: Id) -> Result<Self, ArrayError> {
        crate::pickle::constant::read(pickle, id)
    }

    /// Reads an array or a scalar, but no constant of chumpy.
    pub(crate) fn plain(pickle: &Pickle, id: Id) -> Result<Self, ArrayError> {
        match pickle.node(id) {
            PickleValue::Int(value) => {
                return Ok(Self { shape: Vec::new(), values: vec![*value as f64] });
            }
            PickleValue::Float(value) => {
                return Ok(Self { shape: Vec::new(), values: vec![*value] });
            }
            PickleValue::Call { .. } => {}
            _ => return Err(ArrayError::Other(describe(pickle, id))),
        }
        let Some((module, name, arguments)) = pickle.call(id) else {
            return Err(ArrayError::Other(describe(pickle, id)));
        };
        // The functions moved to `numpy._core` in version 2: any module counts.
        let is_numpy = module == "numpy" || module.starts_with("numpy.");
        match (is_numpy, name, arguments) {
            (true, "_reconstruct", _) => Self::restored(pickle, id),
            (true, "scalar", &[dtype, value]) => {
                let element = element(pickle, dtype)?;
                let bytes =
                    bytes(pickle, value).ok_or(ArrayError::Damaged("a number of no bytes"))?;
                Self::from_bytes(Vec::new(), element, false, &bytes)
            }
            (true, "_frombuffer", &[buffer, dtype, shape, order]) => {
                let element = element(pickle, dtype)?;
                let bytes = bytes(pickle, buffer).ok_or(ArrayError::Damaged("no bytes"))?;
                let shape = pickle.sizes(shape).ok_or(ArrayError::Damaged("no shape"))?;
                Self::from_bytes(shape, element, pickle.text(order) == Some("F"), &bytes)
            }
            _ => Err(ArrayError::Other(describe(pickle, id))),
        }
    }

    /// `numpy.core.multiarray._reconstruct(ndarray, (0,), "b")` with the state `(version, shape,
    /// dtype, is column-major, bytes)`, of which old writers leave out the version.
    fn restored(pickle: &Pickle, id: Id) -> Result<Self, ArrayError> {
        let state = pickle.state(id).and_then(|state| pickle.sequence(state));
        let [shape, dtype, is_column_major, content] = match state {
            Some(&[_, shape, dtype, order, content]) | Some(&[shape, dtype, order, content]) => {
                [shape, dtype, order, content]
            }
            _ => return Err(ArrayError::Damaged("an array without its content")),
        };
        let shape = pickle.sizes(shape).ok_or(ArrayError::Damaged("no shape"))?;
        let element = element(pickle, dtype)?;
        // NumPy itself accepts an integer as well.
        let is_column_major = match pickle.node(is_column_major) {
            PickleValue::Bool(value) => *value,
            PickleValue::Int(value) => *value != 0,
            _ => return Err(ArrayError::Damaged("neither row by row nor column by column")),
        };
        let bytes = bytes(pickle, content).ok_or(ArrayError::Damaged("its content is no bytes"))?;
        Self::from_bytes(shape, element, is_column_major, &bytes)
    }

    /// The objects of an array of Python objects.
    pub fn objects(pickle: &Pickle, id: Id) -> Option<&[Id]> {
        let (_, "_reconstruct", _) = pickle.call(id)? else { return None };
        let content = *pickle.sequence(pickle.state(id)?)?.last()?;
        match pickle.node(content) {
            PickleValue::List(items) => Some(items),
            _ => None,
        }
    }
}

/// The element of `numpy.dtype(name, align, copy)` with the state `(version, byte order, ...)`.
fn element(pickle: &Pickle, id: Id) -> Result<Element, ArrayError> {
    const DAMAGED: ArrayError = ArrayError::Damaged("values without a type");
    let ("numpy" | "numpy.core.multiarray" | "numpy._core.multiarray", "dtype", &[name, ..]) =
        pickle.call(id).ok_or(DAMAGED)?
    else {
        return Err(DAMAGED);
    };
    let name = pickle.text(name).ok_or(DAMAGED)?;
    if name.trim_start_matches(['|', '<', '>', '=']).starts_with('O') {
        return Err(ArrayError::Objects);
    }
    let element = Element::parse(name).ok_or_else(|| ArrayError::Type(shortened(name)))?;
    // NumPy writes the order of bytes into the state, not into the name.
    let state = pickle.state(id).and_then(|state| pickle.sequence(state));
    let order = state.and_then(|state| pickle.text(*state.get(1)?));
    Ok(order.map_or(element, |order| element.with_order(order)))
}

/// Bytes, however a version of Python writes them: as such, as text of the same code points, or as
/// that text and how to encode it.
fn bytes(pickle: &Pickle, id: Id) -> Option<Cow<'_, [u8]>> {
    let latin = |text: &str| {
        let bytes = text.chars().map(|c| u8::try_from(u32::from(c)).ok()).collect::<Option<_>>();
        bytes.map(Cow::Owned)
    };
    match pickle.node(id) {
        PickleValue::Bytes(bytes) => Some(Cow::Borrowed(bytes)),
        PickleValue::Text(text) => latin(text),
        // Protocols before 3 have no bytes: Python 3 writes how to make them.
        _ => match pickle.call(id)? {
            ("_codecs", "encode", &[text, encoding])
                if matches!(pickle.text(encoding), Some("latin1" | "latin-1")) =>
            {
                latin(pickle.text(text)?)
            }
            ("__builtin__" | "builtins", "bytes" | "bytearray", []) => Some(Cow::Borrowed(&[])),
            ("__builtin__" | "builtins", "bytearray", &[content]) => match pickle.node(content) {
                PickleValue::Bytes(bytes) => Some(Cow::Borrowed(bytes)),
                _ => None,
            },
            _ => None,
        },
    }
}

/// A number as an index below `limit`, or the fault.
pub(crate) fn index(value: f64, limit: usize, fault: &'static str) -> Result<usize, ArrayError> {
    let fits = value.fract() == 0.0 && value >= 0.0 && value < limit as f64;
    if fits { Ok(value as usize) } else { Err(ArrayError::Damaged(fault)) }
}

/// Describes the value at `id` for a message.
pub(crate) fn describe(pickle: &Pickle, id: Id) -> String {
    match pickle.node(id) {
        PickleValue::None => "nothing".to_owned(),
        PickleValue::Bool(_) => "a truth value".to_owned(),
        PickleValue::Int(_) | PickleValue::LongInt(_) => "an integer".to_owned(),
        PickleValue::Float(_) => "a number".to_owned(),
        PickleValue::Text(_) | PickleValue::Bytes(_) => "a text".to_owned(),
        PickleValue::List(_) | PickleValue::Tuple(_) => "a list".to_owned(),
        PickleValue::Dict(_) => "a dictionary".to_owned(),
        PickleValue::Global { module, name } => {
            format!("`{}`", shortened(&format!("{module}.{name}")))
        }
        PickleValue::Persistent(_) => "something outside of the file".to_owned(),
        PickleValue::Call { .. } => match pickle.class(id) {
            Some((module, name)) => {
                format!("an object of `{}`", shortened(&format!("{module}.{name}")))
            }
            None => "an object".to_owned(),
        },
    }
}

/// A name from an untrusted file, for a message: at most 80 characters, none of them a control one.
fn shortened(name: &str) -> String {
    let clean = name.chars().map(|c| if c.is_control() { '?' } else { c });
    clean.take(80).collect()
}
