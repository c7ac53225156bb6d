//! The two ways in which protocol 0 writes texts into a line.

use crate::pickle::program::{Step, fault};

/// A byte string in quotes, with the escapes of Python's `repr`.
///
/// # Errors
/// If it is not in quotes, or an escape is cut off or none.
pub(crate) fn quoted(line: &[u8]) -> Step<Vec<u8>> {
    let line = line.trim_ascii();
    let inner = match line {
        [b'\'', inner @ .., b'\''] | [b'"', inner @ .., b'"'] => inner,
        _ => return Err(fault("a text without its quotes")),
    };
    let mut bytes = Vec::with_capacity(inner.len());
    let mut rest = inner;
    while let [first, behind @ ..] = rest {
        rest = behind;
        if *first != b'\\' {
            bytes.push(*first);
            continue;
        }
        let [escape, behind @ ..] = rest else { return Err(fault("an escape is cut off")) };
        rest = behind;
        bytes.push(match escape {
            b'\\' | b'\'' | b'"' => *escape,
            b'n' => b'\n',
            b'r' => b'\r',
            b't' => b'\t',
            b'a' => 0x07,
            b'b' => 0x08,
            b'f' => 0x0c,
            b'v' => 0x0b,
            b'x' => {
                let value = hexadecimal(rest, 2)?;
                rest = &rest[2..];
                value as u8
            }
            other => return Err(fault(format!("unknown escape 0x{other:02x}"))),
        });
    }
    Ok(bytes)
}

/// A text in the encoding `raw-unicode-escape`: Latin-1, with `\uXXXX` for what is beyond.
///
/// # Errors
/// If an escape is cut off or means no character.
pub(crate) fn escaped(line: &[u8]) -> Step<String> {
    let mut text = String::with_capacity(line.len());
    let mut rest = line;
    while let [first, behind @ ..] = rest {
        // A backslash before any other letter stands for itself.
        let digits = match rest {
            [b'\\', b'u', ..] => 4,
            [b'\\', b'U', ..] => 8,
            _ => {
                text.push(char::from(*first));
                rest = behind;
                continue;
            }
        };
        let value = hexadecimal(&rest[2..], digits)?;
        text.push(char::from_u32(value).ok_or_else(|| fault("an escape that is no character"))?);
        rest = &rest[2 + digits..];
    }
    Ok(text)
}

fn hexadecimal(bytes: &[u8], digits: usize) -> Step<u32> {
    let digits = bytes.get(..digits).ok_or_else(|| fault("an escape is cut off"))?;
    digits.iter().try_fold(0u32, |value, &digit| {
        let digit =
            char::from(digit).to_digit(16).ok_or_else(|| fault("an escape with a wrong digit"))?;
        Ok(value << 4 | digit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_read_as_python_writes_them() {
        // repr(b"a\x00'\n\\\xff") in Python 2, and u"\u0142\xe9".encode("raw-unicode-escape").
        assert_eq!(quoted(br#""a\x00'\n\\\xff""#), Ok(b"a\0'\n\\\xff".to_vec()));
        assert_eq!(escaped(b"\\u0142\xe9"), Ok("\u{142}\u{e9}".to_owned()));
    }

    #[test]
    fn escapes_that_are_cut_off_are_refused() {
        for line in [&b"'a"[..], b"'", b"", br"'\'", br"'\x0'", br"'\q'"] {
            assert!(quoted(line).is_err(), "{line:?}");
        }
        assert!(escaped(br"\u12").is_err());
        assert!(escaped(br"\ud800").is_err());
    }
}
