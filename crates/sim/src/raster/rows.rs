//! Gathering of short records, eight at a time.

use evpose_cpu::LANES_8;

/// Records `first..first + 8` of `WIDTH` values each, each extended to four by the values that
/// follow it. At the end of `values` they are copied to `padding`, where the last record is
/// repeated.
///
/// # Panics
/// If there is no such record.
#[inline(always)]
pub(super) fn eight_rows<'a, const WIDTH: usize>(
    values: &'a [i32],
    first: usize,
    padding: &'a mut [i32; 4 * LANES_8],
) -> [&'a [i32; 4]; LANES_8] {
    let here = &values[first * WIDTH..];
    // Four values are taken of each record: the last one reads beyond its own.
    let here = match here.get(..(LANES_8 - 1) * WIDTH + 4) {
        Some(here) => here,
        None => {
            let last = here.len() / WIDTH - 1;
            for k in 0..LANES_8 {
                let from = k.min(last) * WIDTH;
                padding[k * WIDTH..][..WIDTH].copy_from_slice(&here[from..][..WIDTH]);
            }
            &padding[..]
        }
    };
    // Spelled out: a map would go through memory.
    [
        row::<WIDTH>(here, 0),
        row::<WIDTH>(here, 1),
        row::<WIDTH>(here, 2),
        row::<WIDTH>(here, 3),
        row::<WIDTH>(here, 4),
        row::<WIDTH>(here, 5),
        row::<WIDTH>(here, 6),
        row::<WIDTH>(here, 7),
    ]
}

#[inline(always)]
fn row<const WIDTH: usize>(values: &[i32], k: usize) -> &[i32; 4] {
    values[k * WIDTH..].first_chunk().unwrap_or(&[0; 4])
}
