//! Matrix products on two-dimensional registers, which Intel calls tiles (AMX).
//!
//! A tile is up to 16 rows of up to 64 bytes. One instruction multiplies a tile of rows of elements
//! by a tile of weights and adds the products to a tile of 16x16 sums, so that a kernel moves two
//! tiles for 16,384 products of bytes.

#[cfg(target_arch = "x86_64")]
mod amx;
#[cfg(target_arch = "x86_64")]
mod detection;
mod element;
mod emulation;
mod unit;

#[cfg(target_arch = "x86_64")]
pub use amx::Amx;
pub use element::TileElement;
pub use emulation::EmulatedTiles;
pub use unit::{TILE_ROW_BYTES, TILE_ROWS, TileConfig, TileShape, TileUnit};

#[cfg(target_arch = "x86_64")]
pub(crate) use detection::AmxFeatures;

#[cfg(test)]
mod tests;
