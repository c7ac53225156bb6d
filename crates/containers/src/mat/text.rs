//! Decoding of stored text.

use crate::mat::class::Storage;
use crate::number::ByteOrder;

/// Decodes text; none if the bytes are no valid Unicode.
///
/// # Source
/// MATLAB's letters are UTF-16. Old programs store those of one byte as integers of 8 bits: they
/// are the first 256 of Unicode.
pub(crate) fn text_of(bytes: &[u8], storage: Storage, order: ByteOrder) -> Option<String> {
    match storage {
        Storage::Utf8 => std::str::from_utf8(bytes).ok().map(str::to_owned),
        Storage::U8 | Storage::I8 => Some(bytes.iter().map(|&byte| char::from(byte)).collect()),
        Storage::Utf16 | Storage::U16 | Storage::I16 => {
            let units = bytes.as_chunks::<2>().0.iter().map(|&unit| match order {
                ByteOrder::Little => u16::from_le_bytes(unit),
                ByteOrder::Big => u16::from_be_bytes(unit),
            });
            char::decode_utf16(units).collect::<Result<_, _>>().ok()
        }
        Storage::Utf32 | Storage::U32 | Storage::I32 => {
            let letters = bytes.as_chunks::<4>().0.iter();
            letters.map(|&letter| char::from_u32(order.u32(letter))).collect()
        }
        Storage::F32 | Storage::F64 | Storage::I64 | Storage::U64 => None,
    }
}
