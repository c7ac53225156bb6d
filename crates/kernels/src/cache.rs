//! Sizes of the caches of this machine.

use std::sync::OnceLock;

/// Second-level cache where its size is unknown, in bytes.
const DEFAULT_L2_BYTES: usize = 1 << 20;
/// Bounds within which a size is believed: virtual machines report what they like.
const L2_RANGE_BYTES: std::ops::RangeInclusive<usize> = (256 << 10)..=(8 << 20);

/// Bytes of a share of the second-level cache of a core.
pub(crate) fn l2_share_bytes(share: f64) -> usize {
    (share * l2_bytes() as f64) as usize
}

/// Bytes of the second-level cache of a core, as the processor reports it.
fn l2_bytes() -> usize {
    static BYTES: OnceLock<usize> = OnceLock::new();
    *BYTES.get_or_init(|| {
        let reported = reported_l2_bytes().filter(|bytes| L2_RANGE_BYTES.contains(bytes));
        reported.unwrap_or(DEFAULT_L2_BYTES)
    })
}

#[cfg(target_arch = "x86_64")]
fn reported_l2_bytes() -> Option<usize> {
    let mut caches = raw_cpuid::CpuId::new().get_cache_parameters()?;
    let cache = caches.find(|cache| cache.level() == 2)?;
    let lines = cache.associativity() * cache.physical_line_partitions() * cache.sets();
    Some(lines * cache.coherency_line_size())
}

#[cfg(not(target_arch = "x86_64"))]
fn reported_l2_bytes() -> Option<usize> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_is_a_plausible_one_and_that_of_the_system() {
        assert!(L2_RANGE_BYTES.contains(&l2_bytes()));
        let file = "/sys/devices/system/cpu/cpu0/cache/index2/size";
        let Ok(text) = std::fs::read_to_string(file) else { return };
        let kib: usize = text.trim().trim_end_matches('K').parse().unwrap_or_default();
        if cfg!(target_arch = "x86_64") && L2_RANGE_BYTES.contains(&(kib << 10)) {
            assert_eq!(l2_bytes(), kib << 10);
        }
    }
}
