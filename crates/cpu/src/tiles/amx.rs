//! The tiles of Intel's AMX, by inline assembly: its intrinsics are not stable in Rust.
//!
//! Tiles keep their contents from one statement to the next, as nothing else uses them: compilers
//! allocate tiles only for code that asks for AMX, which no crate of ours does.

use std::arch::asm;

use super::unit::{TileConfig, TileUnit};

/// The tiles of the processor's thread.
///
/// Its instructions are there where [`TileElement::has_amx`](super::TileElement::has_amx) says so.
#[derive(Debug)]
pub struct Amx(());

impl TileUnit for Amx {
    #[inline(always)]
    unsafe fn configure(config: &TileConfig) -> Self {
        // SAFETY: the caller's.
        unsafe {
            asm!(
                "ldtilecfg [{config}]",
                config = in(reg) std::ptr::from_ref(config),
                options(nostack, preserves_flags, readonly),
            );
        }
        Self(())
    }

    #[inline(always)]
    unsafe fn zero<const TILE: usize>(&mut self) {
        // SAFETY: the caller's.
        unsafe {
            asm!("tilezero tmm{tile}", tile = const TILE, options(nostack, preserves_flags, nomem));
        }
    }

    #[inline(always)]
    unsafe fn load<const TILE: usize>(&mut self, from: *const u8, stride_bytes: usize) {
        // SAFETY: the caller's.
        unsafe {
            asm!(
                "tileloadd tmm{tile}, [{from} + {stride} * 1]",
                tile = const TILE,
                from = in(reg) from,
                stride = in(reg) stride_bytes,
                options(nostack, preserves_flags, readonly),
            );
        }
    }

    #[inline(always)]
    unsafe fn add_products_u8<const SUM: usize, const A: usize, const B: usize>(&mut self) {
        // SAFETY: the caller's.
        unsafe {
            asm!(
                "tdpbusd tmm{sum}, tmm{a}, tmm{b}",
                sum = const SUM,
                a = const A,
                b = const B,
                options(nostack, preserves_flags, nomem),
            );
        }
    }

    #[inline(always)]
    unsafe fn add_products_bf16<const SUM: usize, const A: usize, const B: usize>(&mut self) {
        // SAFETY: the caller's.
        unsafe {
            asm!(
                "tdpbf16ps tmm{sum}, tmm{a}, tmm{b}",
                sum = const SUM,
                a = const A,
                b = const B,
                options(nostack, preserves_flags, nomem),
            );
        }
    }

    #[inline(always)]
    unsafe fn store<const TILE: usize>(&mut self, to: *mut u8, stride_bytes: usize) {
        // SAFETY: the caller's.
        unsafe {
            asm!(
                "tilestored [{to} + {stride} * 1], tmm{tile}",
                tile = const TILE,
                to = in(reg) to,
                stride = in(reg) stride_bytes,
                options(nostack, preserves_flags),
            );
        }
    }

    #[inline(always)]
    unsafe fn release(self) {
        // SAFETY: the caller's.
        unsafe {
            asm!("tilerelease", options(nostack, preserves_flags, nomem));
        }
    }
}
