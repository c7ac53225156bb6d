//! Numeric types, and their storage by machine.

use crate::cdf::CdfError;
use crate::number::{ByteOrder, NumberKind};

/// The byte order of the format's code of a machine, which stands at `byte`.
pub(crate) fn order_of_encoding(encoding: u32, byte: u64) -> Result<ByteOrder, CdfError> {
    match encoding {
        // Network, Sun, Silicon Graphics, IBM RS, Macintosh, HP, NeXT and big ARM.
        1 | 2 | 5 | 7 | 9 | 11 | 12 | 18 => Ok(ByteOrder::Big),
        // DECstation, PC, Alpha OSF/1 and VMS, little ARM, Itanium.
        4 | 6 | 13 | 16 | 17 | 19 => Ok(ByteOrder::Little),
        _ => Err(CdfError::Unsupported {
            byte,
            what: format!("values of machine {encoding}"),
            instead: "those of all machines but VAX are",
        }),
    }
}

/// The type and the bytes of a value by the format's code, which stands at `byte`.
pub(crate) fn number_of_type(code: u32, byte: u64) -> Result<(NumberKind, usize), CdfError> {
    // 41, 44 and 45 are other names of the same types.
    Ok(match code {
        1 | 41 => (NumberKind::Signed, 1),
        2 => (NumberKind::Signed, 2),
        4 => (NumberKind::Signed, 4),
        8 => (NumberKind::Signed, 8),
        11 => (NumberKind::Unsigned, 1),
        12 => (NumberKind::Unsigned, 2),
        14 => (NumberKind::Unsigned, 4),
        21 | 44 => (NumberKind::Float, 4),
        22 | 45 => (NumberKind::Float, 8),
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
