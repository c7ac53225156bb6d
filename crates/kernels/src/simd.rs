//! The vectors of these kernels: sixteen lanes, one block of channels of nChw16c.

pub(crate) use evpose_cpu::{
    Kernel16 as Kernel, LANES_16 as LANES, Lanes16 as Lanes, Level, ReducedDispatch, ReducedKernel,
};

/// Elements of reduced precision and their dot products.
pub(crate) mod dots {
    pub(crate) use evpose_cpu::{Bf16, DotProduct, ReducedPrecision, weight_vector_bytes};
}

/// Matrix products on tiles.
pub(crate) mod tiles {
    #[cfg(target_arch = "x86_64")]
    pub(crate) use evpose_cpu::Amx;
    #[cfg(test)]
    pub(crate) use evpose_cpu::EmulatedTiles;
    pub(crate) use evpose_cpu::{
        TILE_ROW_BYTES, TILE_ROWS, TileConfig, TileElement, TileShape, TileUnit,
    };
}
