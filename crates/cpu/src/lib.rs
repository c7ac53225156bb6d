//! Vector instructions of the processor, and threads for short parallel regions.
//!
//! * [`Level`]: portable, AVX2 or AVX-512; detected when the program runs.
//! * [`vectorize`]: a plain loop, compiled for the widest vectors of this processor.
//! * [`prefetch`]: a cache line asked for before it is needed.
//! * [`Lanes8`], [`Kernel8`], [`dispatch`]: vectors of 8 `f32` or `i32`, safe, in and out of arrays.
//!   Results have the same bits at every level.
//! * [`Lanes16`], [`Kernel16`], [`Level::run`]: vectors of 16 `f32`, by pointer, with a fused
//!   multiply-add where the processor has one.
//! * [`Bf16`], [`ReducedPrecision`], [`DotProduct`]: values of 16 and 8 bits, and the instructions that
//!   multiply and add several of them at once.
//! * [`TileUnit`], [`TileElement`], [`TileConfig`]: matrix products on the tiles of AMX, and
//!   [`EmulatedTiles`], which tests take elsewhere.
//! * [`ThreadPool`]: parallel regions of tens of microseconds.
//!
//! Kernels are written once and compiled for every level. A kernel's `run` and everything that it
//! calls must be `#[inline(always)]`: a function that is not inlined is compiled for the baseline of
//! the target.
//!
//! ```
//! use evpose_cpu::{Kernel8, LANES_8, Lanes8, dispatch};
//!
//! /// `scale · x + offset`, eight values at a time.
//! struct Affine<'a> {
//!     values: &'a mut [[f32; LANES_8]],
//!     scale: f32,
//!     offset: f32,
//! }
//!
//! impl Kernel8 for Affine<'_> {
//!     type Output = ();
//!
//!     #[inline(always)]
//!     fn run<L: Lanes8>(self, l: L) {
//!         let (scale, offset) = (l.splat(self.scale), l.splat(self.offset));
//!         for chunk in self.values {
//!             *chunk = l.store(l.add(l.mul(l.load(*chunk), scale), offset));
//!         }
//!     }
//! }
//!
//! let mut values = [[1.0; LANES_8], [3.0; LANES_8]];
//! dispatch(Affine { values: &mut values, scale: 2.0, offset: 0.5 });
//! assert_eq!(values, [[2.5; LANES_8], [6.5; LANES_8]]);
//! ```
//!
//! # Unsafe code
//! Vector instructions need it: a processor without an instruction has no defined behaviour for it,
//! and vectors of 16 lanes are read and written through pointers. [`Level`] and the tokens of
//! `pulp` prove that the instructions exist; the contracts about memory are written at [`Lanes16`],
//! [`DotProduct`] and [`TileUnit`].

#![allow(unsafe_code, reason = "vector instructions; contracts are written at each trait")]

mod lanes16;
mod lanes8;
mod level;
mod prefetch;
mod reduced;
mod thread_pool;
mod tiles;
mod vectorize;

pub use lanes8::{Kernel8, LANES_8, Lanes8, dispatch};
pub use lanes16::{Kernel16, LANES_16, Lanes16};
pub use level::Level;
pub use prefetch::prefetch;
pub use reduced::{
    Bf16, DotProduct, ReducedDispatch, ReducedKernel, ReducedPrecision, weight_vector_bytes,
};
pub use thread_pool::{Part, ThreadPool};
#[cfg(target_arch = "x86_64")]
pub use tiles::Amx;
pub use tiles::{
    EmulatedTiles, TILE_ROW_BYTES, TILE_ROWS, TileConfig, TileElement, TileShape, TileUnit,
};
pub use vectorize::vectorize;
