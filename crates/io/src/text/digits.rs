//! Integers written as digits, eight at a time.

/// Bytes that [`put`] may touch behind the place where it writes.
pub(super) const REACH: usize = 24;

/// Writes the digits of `value` from byte `at` of `line` on; returns where they end. Bytes behind
/// may have changed.
#[inline(always)]
pub(super) fn put(line: &mut [u8], at: usize, value: u64) -> usize {
    const EIGHT: u64 = 100_000_000;
    if value < EIGHT {
        return put_first(line, at, value);
    }
    // A value of 64 bits has 20 digits at most: three pieces of eight.
    let above = value / EIGHT;
    let at = if above < EIGHT {
        put_first(line, at, above)
    } else {
        let at = put_first(line, at, above / EIGHT);
        put_eight(line, at, ascii(above % EIGHT));
        at + 8
    };
    put_eight(line, at, ascii(value % EIGHT));
    at + 8
}

/// Writes a number below 10^8 without zeros before it.
#[inline(always)]
fn put_first(line: &mut [u8], at: usize, value: u64) -> usize {
    let digits = ascii(value);
    // The last digit is kept even if it is a zero.
    let zeros = ((digits ^ ZEROS) | 1 << 63).trailing_zeros() / 8;
    put_eight(line, at, digits >> (8 * zeros));
    at + 8 - zeros as usize
}

#[inline(always)]
fn put_eight(line: &mut [u8], at: usize, digits: u64) {
    line[at..at + 8].copy_from_slice(&digits.to_le_bytes());
}

/// Eight times the digit zero.
const ZEROS: u64 = 0x3030_3030_3030_3030;

/// Eight digits of a number below 10^8, the first in the lowest byte.
#[inline(always)]
fn ascii(value: u64) -> u64 {
    // Halves of four digits, in lanes of 32 bits; then pairs in lanes of 16, then single digits.
    let fours = (value / 10_000) | ((value % 10_000) << 32);
    // n / 100 is n * 10486 / 2^20 below 10^4, and n / 10 is n * 103 / 2^10 below 10^2.
    let hundreds = ((fours * 10_486) >> 20) & 0x0000_007f_0000_007f;
    let pairs = hundreds | (fours - 100 * hundreds) << 16;
    let tens = ((pairs * 103) >> 10) & 0x000f_000f_000f_000f;
    (tens | (pairs - 10 * tens) << 8) + ZEROS
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn written(value: u64) -> String {
        let mut line = [b'x'; REACH];
        let end = put(&mut line, 0, value);
        String::from_utf8_lossy(&line[..end]).into_owned()
    }

    #[test]
    fn every_number_of_few_digits_and_every_power_of_ten_is_written() {
        let powers = (0..20).map(|k| 10_u64.pow(k)).flat_map(|power| [power - 1, power, power + 1]);
        for value in (0..200_000).chain(powers).chain([u64::MAX]) {
            assert_eq!(written(value), value.to_string());
        }
    }

    proptest! {
        #[test]
        fn any_number_is_written(value in any::<u64>(), shift in 0..64_u32) {
            let value = value >> shift;
            prop_assert_eq!(written(value), value.to_string());
        }
    }
}
