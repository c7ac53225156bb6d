//! The order in which people count: `frame2` before `frame10`.

use std::cmp::Ordering;

/// Compares runs of digits by value, all else byte by byte.
pub(super) fn compare(a: &str, b: &str) -> Ordering {
    let (mut a_rest, mut b_rest) = (a.as_bytes(), b.as_bytes());
    loop {
        let digits = |rest: &[u8]| rest.iter().take_while(|c| c.is_ascii_digit()).count();
        let order = match (digits(a_rest), digits(b_rest)) {
            // Unless both sides begin with digits, one byte each is compared.
            (0, _) | (_, 0) => match (a_rest.split_first(), b_rest.split_first()) {
                // What differs in leading zeros only still needs an order.
                (None, None) => return a.cmp(b),
                (a_first, b_first) => {
                    a_rest = &a_rest[a_rest.len().min(1)..];
                    b_rest = &b_rest[b_rest.len().min(1)..];
                    a_first.map(|(c, _)| c).cmp(&b_first.map(|(c, _)| c))
                }
            },
            (a_digits, b_digits) => {
                let (a_number, a_behind) = a_rest.split_at(a_digits);
                let (b_number, b_behind) = b_rest.split_at(b_digits);
                (a_rest, b_rest) = (a_behind, b_behind);
                // Longer is larger, without leading zeros: no number is too long for this.
                let (a_number, b_number) = (significant(a_number), significant(b_number));
                a_number.len().cmp(&b_number.len()).then(a_number.cmp(b_number))
            }
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

fn significant(digits: &[u8]) -> &[u8] {
    &digits[digits.iter().take_while(|c| **c == b'0').count()..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_digits_compare_by_value_wherever_they_are() {
        let sorted =
            ["", "1.png", "01.png", "2.png", "10.png", "a", "a2b9", "a2b10", "a10", "b", "b0"];
        for (i, a) in sorted.iter().enumerate() {
            for (j, b) in sorted.iter().enumerate() {
                let expected =
                    if [1, 2].contains(&i) && [1, 2].contains(&j) { a.cmp(b) } else { i.cmp(&j) };
                assert_eq!(compare(a, b), expected, "{a:?} {b:?}");
            }
        }
    }
}
