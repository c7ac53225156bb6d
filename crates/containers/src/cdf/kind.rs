//! Numeric types, and their storage by machine.

use crate::cdf::CdfError;

/// Byte order of stored values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    Big,
    Little,
}

impl ByteOrder {
    /// The byte order of the format's code of a machine, which stands at `byte`.
    pub(crate) fn of_encoding(encoding: u32, byte: u64) -> Result<Self, CdfError> {
        match encoding {
            // Network, Sun, Silicon Graphics, IBM RS, Macintosh, HP, NeXT and big ARM.
            1 | 2 | 5 | 7 | 9 | 11 | 12 | 18 => Ok(Self::Big),
            // DECstation, PC, Alpha OSF/1 and VMS, little ARM, Itanium.
            4 | 6 | 13 | 16 | 17 | 19 => Ok(Self::Little),
            _ => Err(CdfError::Unsupported {
                byte,
                what: format!("values of machine {encoding}"),
                instead: "those of all machines but VAX are",
            }),
        }
    }
}

/// Numeric type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberKind {
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    F32,
    F64,
}

impl NumberKind {
    /// The type by the format's code, which stands at `byte`.
    pub(crate) fn of_type(code: u32, byte: u64) -> Result<Self, CdfError> {
        // 41, 44 and 45 are other names of the same types.
        Ok(match code {
            1 | 41 => Self::I8,
            2 => Self::I16,
            4 => Self::I32,
            8 => Self::I64,
            11 => Self::U8,
            12 => Self::U16,
            14 => Self::U32,
            21 | 44 => Self::F32,
            22 | 45 => Self::F64,
            _ => {
                let what = match code {
                    31..=33 => "times".to_owned(),
                    51 | 52 => "text".to_owned(),
                    _ => format!("values of type {code}"),
                };
                return Err(CdfError::Unsupported { byte, what, instead: "numeric types are" });
            }
        })
    }

    /// Bytes of a value.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::F64 => 8,
        }
    }

    /// Decodes `bytes`, which are [`Self::size`] long.
    pub(crate) fn decode(self, bytes: &[u8], order: ByteOrder) -> f64 {
        let push = |bits: u64, &byte: &u8| bits << 8 | u64::from(byte);
        let bits = match order {
            ByteOrder::Big => bytes.iter().fold(0, push),
            ByteOrder::Little => bytes.iter().rev().fold(0, push),
        };
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::I16 => f64::from(bits as i16),
            Self::I32 => f64::from(bits as i32),
            Self::I64 => bits as i64 as f64,
            Self::U8 | Self::U16 | Self::U32 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}
