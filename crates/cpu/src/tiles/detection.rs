//! Whether the processor has AMX, and the system lets this process use it.

use std::arch::x86_64::{__cpuid, __cpuid_count, _xgetbv};
use std::sync::OnceLock;

/// Parts of AMX that this process may use.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct AmxFeatures {
    /// Products of bytes.
    pub(crate) int8: bool,
    /// Products of bfloat16 values.
    pub(crate) bf16: bool,
}

const EXTENSIONS_LEAF: u32 = 7;
/// Bits of `EDX` in that leaf.
const AMX_BF16: u32 = 1 << 22;
const AMX_TILE: u32 = 1 << 24;
const AMX_INT8: u32 = 1 << 25;
/// Bit of `ECX` in leaf 1: `XGETBV` may be executed.
const OSXSAVE: u32 = 1 << 27;
/// Bits of `XCR0`: the system saves the configuration and the contents of tiles.
const TILE_STATE: u64 = 1 << 17 | 1 << 18;

impl AmxFeatures {
    /// Those of this process. The first call asks the system for them.
    pub(crate) fn of_this_process() -> Self {
        static FEATURES: OnceLock<AmxFeatures> = OnceLock::new();
        *FEATURES.get_or_init(Self::detect)
    }

    fn detect() -> Self {
        let extensions = extensions();
        let has_tiles = extensions & AMX_TILE != 0 && is_tile_state_saved() && has_permission();
        if !has_tiles {
            return Self::default();
        }
        Self { int8: extensions & AMX_INT8 != 0, bf16: extensions & AMX_BF16 != 0 }
    }
}

/// `EDX` of the leaf of extensions; 0 where there is none.
fn extensions() -> u32 {
    let last_leaf = __cpuid(0).eax;
    if last_leaf < EXTENSIONS_LEAF { 0 } else { __cpuid_count(EXTENSIONS_LEAF, 0).edx }
}

/// Whether the system saves tiles when it switches threads.
fn is_tile_state_saved() -> bool {
    let has_xgetbv = __cpuid(1).ecx & OSXSAVE != 0;
    // SAFETY: the instruction is there.
    has_xgetbv && unsafe { _xgetbv(0) } & TILE_STATE == TILE_STATE
}

/// Asks Linux for the right to use tiles, which it gives to processes that ask: their threads need
/// 8 KiB more for saved registers.
#[cfg(target_os = "linux")]
fn has_permission() -> bool {
    /// Request of `arch_prctl`, from `asm/prctl.h`.
    const ARCH_REQ_XCOMP_PERM: libc::c_long = 0x1023;
    /// State component of the contents of tiles.
    const XFEATURE_XTILEDATA: libc::c_long = 18;
    // SAFETY: the call takes integers, and changes nothing that Rust knows of.
    let result =
        unsafe { libc::syscall(libc::SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) };
    result == 0
}

/// Other systems are not known to grant it.
#[cfg(not(target_os = "linux"))]
fn has_permission() -> bool {
    false
}
