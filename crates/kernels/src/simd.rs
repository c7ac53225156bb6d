//! The vectors of these kernels: sixteen lanes, one block of channels of nChw16c.

pub(crate) use evpose_simd::{
    Kernel16 as Kernel, LANES_16 as LANES, Lanes16 as Lanes, Level, ReducedDispatch, ReducedKernel,
};

/// Elements of reduced precision and their dot products.
pub(crate) mod dots {
    pub(crate) use evpose_simd::{Bf16, DotProduct, ReducedPrecision, weight_vector_bytes};
}
