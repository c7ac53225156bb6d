//! Classes of arrays, and the types in which their values are stored.

use std::fmt;

use crate::number::{ByteOrder, Number, NumberKind};

/// MATLAB's class of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatClass {
    /// An array of arrays.
    Cell,
    /// An array of structures of the same fields.
    Struct,
    /// An object of an old class.
    Object,
    /// Text.
    Char,
    /// A sparse matrix: only nonzero elements are stored.
    Sparse,
    /// `double`.
    F64,
    /// `single`.
    F32,
    /// `int8`.
    I8,
    /// `uint8`.
    U8,
    /// `int16`.
    I16,
    /// `uint16`.
    U16,
    /// `int32`.
    I32,
    /// `uint32`.
    U32,
    /// `int64`.
    I64,
    /// `uint64`.
    U64,
    /// A function handle.
    Function,
    /// An object of a new class: `table`, `string`, `datetime`, …
    Opaque,
}

impl MatClass {
    pub(crate) fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            1 => Self::Cell,
            2 => Self::Struct,
            3 => Self::Object,
            4 => Self::Char,
            5 => Self::Sparse,
            6 => Self::F64,
            7 => Self::F32,
            8 => Self::I8,
            9 => Self::U8,
            10 => Self::I16,
            11 => Self::U16,
            12 => Self::I32,
            13 => Self::U32,
            14 => Self::I64,
            15 => Self::U64,
            16 => Self::Function,
            17 => Self::Opaque,
            _ => return None,
        })
    }

    /// Whether the content of arrays of this class is read.
    pub(crate) fn is_read(self) -> bool {
        !matches!(self, Self::Object | Self::Sparse | Self::Function | Self::Opaque)
    }
}

impl fmt::Display for MatClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cell => "a cell array",
            Self::Struct => "a structure",
            Self::Object => "an object of an old class",
            Self::Char => "text",
            Self::Sparse => "a sparse matrix",
            Self::F64 => "an array of double",
            Self::F32 => "an array of single",
            Self::I8 => "an array of int8",
            Self::U8 => "an array of uint8",
            Self::I16 => "an array of int16",
            Self::U16 => "an array of uint16",
            Self::I32 => "an array of int32",
            Self::U32 => "an array of uint32",
            Self::I64 => "an array of int64",
            Self::U64 => "an array of uint64",
            Self::Function => "a handle of a function",
            Self::Opaque => "an object",
        })
    }
}

/// Data type in which values are stored; often narrower than their class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Storage {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
    I64,
    U64,
    Utf8,
    Utf16,
    Utf32,
}

impl Storage {
    pub(crate) fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::I8,
            2 => Self::U8,
            3 => Self::I16,
            4 => Self::U16,
            5 => Self::I32,
            6 => Self::U32,
            7 => Self::F32,
            9 => Self::F64,
            12 => Self::I64,
            13 => Self::U64,
            16 => Self::Utf8,
            17 => Self::Utf16,
            18 => Self::Utf32,
            _ => return None,
        })
    }

    /// Bytes of a value.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 | Self::Utf8 => 1,
            Self::I16 | Self::U16 | Self::Utf16 => 2,
            Self::I32 | Self::U32 | Self::F32 | Self::Utf32 => 4,
            Self::F64 | Self::I64 | Self::U64 => 8,
        }
    }

    pub(crate) fn is_text(self) -> bool {
        matches!(self, Self::Utf8 | Self::Utf16 | Self::Utf32)
    }

    /// Decodes `bytes`, which are [`Self::size`] long.
    pub(crate) fn decode(self, bytes: &[u8], order: ByteOrder) -> Number {
        let kind = match self {
            Self::F32 | Self::F64 => NumberKind::Float,
            Self::I8 | Self::I16 | Self::I32 | Self::I64 => NumberKind::Signed,
            _ => NumberKind::Unsigned,
        };
        kind.decode(bytes, order)
    }
}
