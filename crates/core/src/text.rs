//! Texts as editors and spreadsheets write them: Excel, PowerShell and Notepad begin them with a mark of byte order,
//! which is no part of the content.

/// The mark of byte order.
pub const BOM: &str = "\u{feff}";

/// The text behind a mark of byte order, if there is one.
pub fn without_bom(text: &str) -> &str {
    text.strip_prefix(BOM).unwrap_or(text)
}

/// As [`without_bom`], of the bytes of a file.
pub fn bytes_without_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(BOM.as_bytes()).unwrap_or(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_mark_at_the_beginning_is_no_content() {
        assert_eq!((without_bom("\u{feff}t,x"), without_bom("t,x")), ("t,x", "t,x"));
        assert_eq!(without_bom("t,\u{feff}x"), "t,\u{feff}x");
        assert_eq!(bytes_without_bom(b"\xef\xbb\xbf{}"), b"{}");
        assert_eq!(bytes_without_bom(b"\xef\xbb"), b"\xef\xbb");
    }
}
