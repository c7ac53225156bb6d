//! The operations of a unit with tiles, and how tiles are configured.

/// Rows of the largest tile.
pub const TILE_ROWS: usize = 16;
/// Bytes of the longest row of a tile.
pub const TILE_ROW_BYTES: usize = 64;
/// Number of tiles.
pub(super) const TILES: usize = 8;
/// Entries of a configuration: palettes to come may have as many tiles.
const CONFIG_ENTRIES: usize = 16;
/// The palette of eight tiles of 1 KiB.
const PALETTE: u8 = 1;

/// Rows of a tile, and bytes of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileShape {
    /// 1 to [`TILE_ROWS`].
    pub rows: usize,
    /// A multiple of 4, up to [`TILE_ROW_BYTES`].
    pub row_bytes: usize,
}

/// Shapes of all tiles, in the 64 bytes that the processor reads (`LDTILECFG`).
///
/// # Source
/// Intel: *Architectures Software Developer's Manual*, volume 1, Sec. 18.2, memory area of
/// `LDTILECFG`.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct TileConfig {
    palette: u8,
    start_row: u8,
    reserved: [u8; 14],
    row_bytes: [u16; CONFIG_ENTRIES],
    rows: [u8; CONFIG_ENTRIES],
}

const _: () = assert!(size_of::<TileConfig>() == 64, "64 bytes");

impl TileConfig {
    /// Eight tiles of these shapes.
    ///
    /// # Panics
    /// If a shape is not one that [`TileShape`] allows.
    pub fn new(shapes: [TileShape; TILES]) -> Self {
        let mut config = Self {
            palette: PALETTE,
            start_row: 0,
            reserved: [0; 14],
            row_bytes: [0; CONFIG_ENTRIES],
            rows: [0; CONFIG_ENTRIES],
        };
        for (tile, TileShape { rows, row_bytes }) in shapes.into_iter().enumerate() {
            assert!((1..=TILE_ROWS).contains(&rows), "{rows} rows of a tile");
            assert!(
                (4..=TILE_ROW_BYTES).contains(&row_bytes) && row_bytes.is_multiple_of(4),
                "{row_bytes} bytes of a row of a tile"
            );
            config.rows[tile] = rows as u8;
            config.row_bytes[tile] = row_bytes as u16;
        }
        config
    }

    pub(super) fn shape(&self, tile: usize) -> TileShape {
        TileShape { rows: self.rows[tile].into(), row_bytes: self.row_bytes[tile].into() }
    }
}

/// A unit with eight tiles, numbered from 0. Tiles are named by constants, since instructions have
/// no others.
///
/// # Safety
/// Every method requires that the processor has the instructions of the type, and that the memory
/// it reads or writes is readable or writable. A thread configures one unit at a time.
#[allow(clippy::missing_safety_doc, reason = "one contract for all methods, at the trait")]
pub trait TileUnit: Sized {
    /// Gives the tiles their shapes and sets them to zero (`LDTILECFG`).
    unsafe fn configure(config: &TileConfig) -> Self;

    /// Sets a tile to zero (`TILEZERO`).
    unsafe fn zero<const TILE: usize>(&mut self);

    /// Loads a tile, whose rows are `stride_bytes` apart (`TILELOADD`). Rows may overlap.
    unsafe fn load<const TILE: usize>(&mut self, from: *const u8, stride_bytes: usize);

    /// Adds products of unsigned bytes by signed ones to sums in i32 (`TDPBUSD`): the sum of row
    /// `m` and column `n` is increased by `Σ_k Σ_i A[m][4 k + i] · B[k][4 n + i]`, `i` from 0 to 3.
    /// `SUM` and `A` have as many rows, `SUM` and `B` rows as long, and `B` a row for every four
    /// bytes of a row of `A`.
    unsafe fn add_products_u8<const SUM: usize, const A: usize, const B: usize>(&mut self);

    /// Adds products of bfloat16 values to sums in f32 (`TDPBF16PS`), as
    /// [`add_products_u8`](Self::add_products_u8) with two values in the place of four bytes.
    /// Even and odd `k` are summed apart; denormal values count as 0.
    unsafe fn add_products_bf16<const SUM: usize, const A: usize, const B: usize>(&mut self);

    /// Stores a tile, with rows `stride_bytes` apart (`TILESTORED`).
    unsafe fn store<const TILE: usize>(&mut self, to: *mut u8, stride_bytes: usize);

    /// Gives the tiles back, so that the system need not save them (`TILERELEASE`).
    unsafe fn release(self);
}
