//! The tiles of AMX in plain Rust, for tests on processors without them.

use super::unit::{TILE_ROW_BYTES, TILE_ROWS, TILES, TileConfig, TileShape, TileUnit};
use crate::reduced::{Bf16, ReducedPrecision as _};

type Tile = [[u8; TILE_ROW_BYTES]; TILE_ROWS];

const ZERO: Tile = [[0; TILE_ROW_BYTES]; TILE_ROWS];

/// A unit that computes what AMX does, to the bit, and refuses what AMX refuses. Slow: for tests.
///
/// # Panics
/// Its operations panic where the instruction would be an invalid one: at products of tiles whose
/// shapes do not fit, or of a tile with itself.
///
/// # Source
/// The operations in pseudo-code of Intel: *Architectures Software Developer's Manual*, volume 2,
/// `LDTILECFG`, `TILELOADD`, `TDPBUSD`, `TDPBF16PS`, `TILESTORED`.
#[derive(Debug)]
pub struct EmulatedTiles {
    config: TileConfig,
    /// Bytes beyond the shape of a tile are 0.
    tiles: [Tile; TILES],
}

impl EmulatedTiles {
    pub(super) fn zero_tile(&mut self, tile: usize) {
        self.tiles[tile] = ZERO;
    }

    /// # Safety
    /// That of [`TileUnit::load`].
    pub(super) unsafe fn load_tile(&mut self, tile: usize, from: *const u8, stride_bytes: usize) {
        let TileShape { rows, row_bytes } = self.config.shape(tile);
        let mut loaded = ZERO;
        for (row, to) in loaded[..rows].iter_mut().enumerate() {
            // SAFETY: the caller's.
            let from =
                unsafe { std::slice::from_raw_parts(from.add(row * stride_bytes), row_bytes) };
            to[..row_bytes].copy_from_slice(from);
        }
        self.tiles[tile] = loaded;
    }

    /// # Safety
    /// That of [`TileUnit::store`].
    pub(super) unsafe fn store_tile(&self, tile: usize, to: *mut u8, stride_bytes: usize) {
        let TileShape { rows, row_bytes } = self.config.shape(tile);
        for (row, from) in self.tiles[tile][..rows].iter().enumerate() {
            // SAFETY: the caller's.
            unsafe {
                to.add(row * stride_bytes).copy_from_nonoverlapping(from.as_ptr(), row_bytes);
            }
        }
    }

    /// Adds products of bytes; `tiles` are sums, A and B.
    pub(super) fn add_u8(&mut self, tiles: [usize; 3]) {
        self.replace_rows(tiles, |sums, a, b| {
            for (a, b) in a.iter().zip(b) {
                for (sum, b) in sums.iter_mut().zip(*b) {
                    let products =
                        a.iter().zip(b).map(|(a, b)| i32::from(*a) * i32::from(*b as i8));
                    let total = products.fold(i32::from_le_bytes(*sum), i32::wrapping_add);
                    *sum = total.to_le_bytes();
                }
            }
        });
    }

    /// Adds products of bfloat16 values; `tiles` are sums, A and B.
    pub(super) fn add_bf16(&mut self, tiles: [usize; 3]) {
        self.replace_rows(tiles, |sums, a, b| {
            for (column, total) in sums.iter_mut().enumerate() {
                let mut halves = [0.0_f32; 2];
                for (a, b) in a.iter().zip(b) {
                    let (a, b) = (pair(*a), pair(b[column]));
                    halves = [0, 1].map(|half| fused(a[half], b[half], halves[half]));
                }
                let products = sum(halves[0], halves[1]);
                *total = sum(f32::from_le_bytes(*total), products).to_le_bytes();
            }
        });
    }

    /// Replaces the sums of a tile by those of `row`, which gets a row of sums, a row of `a` and
    /// all of `b`.
    fn replace_rows(
        &mut self,
        [sum, a, b]: [usize; 3],
        row: impl Fn(&mut [[u8; 4]], &[[u8; 4]], &[&[[u8; 4]]]),
    ) {
        assert!(sum != a && a != b && b != sum, "three different tiles");
        let [of_sum, of_a, of_b] = [sum, a, b].map(|tile| self.config.shape(tile));
        assert_eq!(of_sum.rows, of_a.rows, "rows of sums and of A");
        assert_eq!(of_sum.row_bytes, of_b.row_bytes, "length of rows of sums and of B");
        assert_eq!(of_a.row_bytes, 4 * of_b.rows, "rows of B for the columns of A");
        let mut sums = self.tiles[sum];
        let weights: Vec<&[[u8; 4]]> =
            self.tiles[b][..of_b.rows].iter().map(|row| words(row, of_b)).collect();
        for (sums, a) in sums.iter_mut().zip(&self.tiles[a]).take(of_sum.rows) {
            let (sums, _) = sums[..of_sum.row_bytes].as_chunks_mut();
            row(sums, words(a, of_a), &weights);
        }
        self.tiles[sum] = sums;
    }
}

fn words(row: &[u8; TILE_ROW_BYTES], shape: TileShape) -> &[[u8; 4]] {
    row[..shape.row_bytes].as_chunks().0
}

/// Zero with the sign of `value` if that is denormal (denormals are zero, flush to zero).
fn without_denormals(value: f32) -> f32 {
    if value.is_subnormal() { 0.0_f32.copysign(value) } else { value }
}

/// `factor · other + term` of normal values, rounded once.
fn fused(factor: f32, other: f32, term: f32) -> f32 {
    let [factor, other, term] = [factor, other, term].map(without_denormals);
    without_denormals(factor.mul_add(other, term))
}

/// The sum of normal values.
fn sum(one: f32, other: f32) -> f32 {
    without_denormals(without_denormals(one) + without_denormals(other))
}

/// The two bfloat16 values of a word.
fn pair([a, b, c, d]: [u8; 4]) -> [f32; 2] {
    [[a, b], [c, d]].map(|bytes| Bf16(u16::from_le_bytes(bytes)).value())
}

impl TileUnit for EmulatedTiles {
    unsafe fn configure(config: &TileConfig) -> Self {
        Self { config: config.clone(), tiles: [ZERO; TILES] }
    }

    unsafe fn zero<const TILE: usize>(&mut self) {
        self.zero_tile(TILE);
    }

    unsafe fn load<const TILE: usize>(&mut self, from: *const u8, stride_bytes: usize) {
        // SAFETY: the caller's.
        unsafe { self.load_tile(TILE, from, stride_bytes) };
    }

    unsafe fn add_products_u8<const SUM: usize, const A: usize, const B: usize>(&mut self) {
        self.add_u8([SUM, A, B]);
    }

    unsafe fn add_products_bf16<const SUM: usize, const A: usize, const B: usize>(&mut self) {
        self.add_bf16([SUM, A, B]);
    }

    unsafe fn store<const TILE: usize>(&mut self, to: *mut u8, stride_bytes: usize) {
        // SAFETY: the caller's.
        unsafe { self.store_tile(TILE, to, stride_bytes) };
    }

    unsafe fn release(self) {}
}
