//! The emulated unit against plain loops, and the instructions of AMX against the emulated one.

use super::*;
use crate::reduced::{Bf16, ReducedPrecision as _};

#[cfg(all(target_arch = "x86_64", target_os = "linux", target_env = "gnu"))]
mod instructions;

/// Tiles of these tests.
const SUM: usize = 3;
const A: usize = 0;
const B: usize = 7;
const TILE_BYTES: usize = TILE_ROWS * TILE_ROW_BYTES;

/// Rows of sums, words of a row of A (rows of B), and columns of sums.
type Size = [usize; 3];

/// Sizes that fill tiles, that do not, and the smallest one.
const SIZES: [Size; 6] =
    [[16, 16, 16], [1, 1, 1], [7, 12, 16], [16, 4, 5], [3, 16, 9], [16, 8, 16]];

fn config([rows, words, columns]: Size) -> TileConfig {
    let mut shapes = [TileShape { rows: 1, row_bytes: 4 }; 8];
    shapes[SUM] = TileShape { rows, row_bytes: 4 * columns };
    shapes[A] = TileShape { rows, row_bytes: 4 * words };
    shapes[B] = TileShape { rows: words, row_bytes: 4 * columns };
    TileConfig::new(shapes)
}

/// `sums + a · b` on a unit. All three have rows of 64 bytes in memory.
fn products<S: TileElement, U: TileUnit>(
    size: Size,
    sums: &[S::Sum; TILE_BYTES / 4],
    a: &[u8; TILE_BYTES],
    b: &[u8; TILE_BYTES],
) -> Vec<S::Sum> {
    let [rows, _, columns] = size;
    let mut result = vec![S::Sum::default(); rows * columns];
    // SAFETY: the caller's processor has the unit; tiles are read from whole ones, and `result` has
    // rows of the stored tile.
    unsafe {
        let mut unit = U::configure(&config(size));
        unit.load::<SUM>(sums.as_ptr().cast(), TILE_ROW_BYTES);
        unit.load::<A>(a.as_ptr(), TILE_ROW_BYTES);
        unit.load::<B>(b.as_ptr(), TILE_ROW_BYTES);
        S::add_products::<U, SUM, A, B>(&mut unit);
        unit.store::<SUM>(result.as_mut_ptr().cast(), 4 * columns);
        unit.release();
    }
    result
}

/// Pseudo-random words.
fn random(seed: u32) -> impl FnMut() -> u32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    }
}

fn random_bytes(seed: u32) -> [u8; TILE_BYTES] {
    let mut next = random(seed);
    std::array::from_fn(|_| (next() >> 7) as u8)
}

/// Sums, and bytes of bfloat16 values between -1 and 1.
fn random_bf16(seed: u32) -> [u8; TILE_BYTES] {
    let mut next = random(seed);
    let mut bytes = [0; TILE_BYTES];
    for bytes in bytes.as_chunks_mut().0 {
        let value = next() as f32 / (1 << 23) as f32 - 1.0;
        *bytes = Bf16::nearest(value).0.to_le_bytes();
    }
    bytes
}

/// The bfloat16 values of a row of a tile.
fn bf16_row(tile: &[u8; TILE_BYTES], row: usize) -> Vec<f64> {
    let row = &tile[row * TILE_ROW_BYTES..][..TILE_ROW_BYTES];
    let pairs = row.as_chunks().0;
    pairs.iter().map(|bytes| f64::from(Bf16(u16::from_le_bytes(*bytes)).value())).collect()
}

#[test]
fn a_configuration_has_the_bytes_that_the_processor_reads() {
    let config = config([7, 12, 16]);
    // SAFETY: 64 bytes without padding.
    let bytes: [u8; 64] = unsafe { std::mem::transmute_copy(&config) };
    assert_eq!(bytes[..16], [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], "palette 1, row 0");
    assert_eq!(bytes[16..32], [48, 0, 4, 0, 4, 0, 64, 0, 4, 0, 4, 0, 4, 0, 64, 0], "row bytes");
    assert_eq!(bytes[32..48], [0; 16]);
    assert_eq!(bytes[48..56], [7, 1, 1, 7, 1, 1, 1, 12], "rows");
    assert_eq!(bytes[56..], [0; 8]);
}

#[test]
fn emulated_products_of_bytes_are_those_of_plain_loops() {
    let (a, b) = (random_bytes(1), random_bytes(2));
    let mut next = random(3);
    let sums: [i32; TILE_BYTES / 4] = std::array::from_fn(|_| next() as i32 - (1 << 23));
    for size in SIZES {
        let [rows, words, columns] = size;
        let result = products::<u8, EmulatedTiles>(size, &sums, &a, &b);
        for row in 0..rows {
            for column in 0..columns {
                let mut expected = sums[row * 16 + column];
                for k in 0..4 * words {
                    let weight = b[k / 4 * TILE_ROW_BYTES + 4 * column + k % 4] as i8;
                    expected += i32::from(a[row * TILE_ROW_BYTES + k]) * i32::from(weight);
                }
                assert_eq!(result[row * columns + column], expected, "{size:?} {row} {column}");
            }
        }
    }
}

#[test]
fn emulated_products_of_bfloat16_are_those_of_plain_loops() {
    let (a, b) = (random_bf16(1), random_bf16(2));
    let mut next = random(3);
    let sums: [f32; TILE_BYTES / 4] = std::array::from_fn(|_| next() as f32 / (1 << 23) as f32);
    for size in SIZES {
        let [rows, words, columns] = size;
        let result = products::<Bf16, EmulatedTiles>(size, &sums, &a, &b);
        for row in 0..rows {
            for column in 0..columns {
                let a = bf16_row(&a, row);
                let mut expected = f64::from(sums[row * 16 + column]);
                for (k, a) in a.iter().enumerate().take(2 * words) {
                    expected += a * bf16_row(&b, k / 2)[2 * column + k % 2];
                }
                let off = (f64::from(result[row * columns + column]) - expected).abs();
                assert!(off < 1e-5, "{size:?} {row} {column}: {off}");
            }
        }
    }
}

/// The sum that starts with `sum`, of one row of A by one column of B.
fn one_bf16_sum(sum: f32, a: &[f32], b: &[f32]) -> f32 {
    let (mut a_tile, mut b_tile) = ([0; TILE_BYTES], [0; TILE_BYTES]);
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        a_tile[2 * k..][..2].copy_from_slice(&Bf16::nearest(*a).0.to_le_bytes());
        let at = k / 2 * TILE_ROW_BYTES + k % 2 * 2;
        b_tile[at..][..2].copy_from_slice(&Bf16::nearest(*b).0.to_le_bytes());
    }
    let sums = [sum; TILE_BYTES / 4];
    products::<Bf16, EmulatedTiles>([1, a.len() / 2, 1], &sums, &a_tile, &b_tile)[0]
}

#[test]
fn even_and_odd_channels_are_summed_apart_and_before_the_old_sum() {
    let large = (1_u32 << 24) as f32;
    // One after the other, each 1 would be lost beside the old sum.
    assert_eq!(one_bf16_sum(large, &[1.0; 4], &[0.5; 4]), large + 2.0);
    // The odd ones are complete before they meet the even ones.
    assert_eq!(one_bf16_sum(0.0, &[large, 1.0, -large, 1.0], &[1.0; 4]), 2.0);
    assert_eq!(one_bf16_sum(0.0, &[large, 1.0, 1.0, 1.0], &[1.0; 4]), large + 2.0);
}

#[test]
fn denormal_values_count_as_zero() {
    let denormal = f32::MIN_POSITIVE / 2.0;
    assert_eq!(one_bf16_sum(0.0, &[denormal, 0.0], &[1024.0, 0.0]), 0.0, "an input");
    assert_eq!(one_bf16_sum(denormal, &[0.0; 2], &[0.0; 2]), 0.0, "an old sum");
    assert_eq!(one_bf16_sum(0.0, &[f32::MIN_POSITIVE, 0.0], &[0.5, 0.0]), 0.0, "a product");
    assert_eq!(one_bf16_sum(0.0, &[2.0 * f32::MIN_POSITIVE, 0.0], &[0.5; 2]), f32::MIN_POSITIVE);
}

#[test]
fn loads_may_overlap_and_stores_leave_gaps_as_they_are() {
    let bytes = random_bytes(5);
    let mut stored = [0xAA_u8; 3 * 20];
    // SAFETY: an emulation; rows of 12 bytes, 5 and 20 apart, are inside.
    unsafe {
        let mut unit = EmulatedTiles::configure(&config([3, 3, 1]));
        unit.load::<A>(bytes.as_ptr(), 5);
        unit.store::<A>(stored.as_mut_ptr(), 20);
    }
    for row in 0..3 {
        assert_eq!(stored[row * 20..][..12], bytes[row * 5..][..12]);
        assert_eq!(stored[row * 20 + 12..][..8], [0xAA; 8]);
    }
}

/// Multiplies emulated tiles of these shapes, in the order sums, A and B.
fn multiply_shapes([sum, a, b]: [[usize; 2]; 3]) {
    let mut shapes = [TileShape { rows: 1, row_bytes: 4 }; 8];
    for (tile, [rows, row_bytes]) in [(SUM, sum), (A, a), (B, b)] {
        shapes[tile] = TileShape { rows, row_bytes };
    }
    // SAFETY: an emulation, which touches no memory here.
    unsafe { EmulatedTiles::configure(&TileConfig::new(shapes)).add_products_u8::<SUM, A, B>() };
}

#[test]
#[should_panic(expected = "rows of sums and of A")]
fn sums_of_other_rows_are_refused() {
    multiply_shapes([[15, 64], [16, 64], [16, 64]]);
}

#[test]
#[should_panic(expected = "rows of sums and of B")]
fn sums_of_other_columns_are_refused() {
    multiply_shapes([[16, 60], [16, 64], [16, 64]]);
}

#[test]
#[should_panic(expected = "rows of B for the columns of A")]
fn too_few_rows_of_weights_are_refused() {
    multiply_shapes([[16, 64], [16, 64], [15, 64]]);
}

#[test]
#[should_panic(expected = "68 bytes of a row")]
fn rows_of_other_than_whole_words_are_refused() {
    config([1, 1, 17]);
}
