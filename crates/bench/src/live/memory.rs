//! Resident memory of the process.

use serde::Serialize;

/// Resident memory during a run, in MiB.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Memory {
    /// After a tenth of the events.
    pub(super) settled_mib: f64,
    /// Maximum from then on.
    pub(super) max_mib: f64,
    pub(super) end_mib: f64,
}

#[derive(Debug, Default)]
pub(super) struct MemorySamples {
    /// Events so far, and MiB.
    samples: Vec<(u64, f64)>,
}

impl MemorySamples {
    pub(super) fn sample(&mut self, events: u64) {
        self.samples.extend(resident_mib().map(|mib| (events, mib)));
    }

    /// The summary; none on systems without `/proc`.
    pub(super) fn memory(&self) -> Option<Memory> {
        let &(all, end_mib) = self.samples.last()?;
        // Buffers grow at first: from here on, growth is a leak.
        let settled = self.samples.iter().position(|(events, _)| 10 * events >= all)?;
        let later = &self.samples[settled..];
        let max_mib = later.iter().map(|(_, mib)| *mib).fold(0.0, f64::max);
        Some(Memory { settled_mib: later[0].1, max_mib, end_mib })
    }
}

/// Resident set size, from Linux's `/proc`.
fn resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_memory_counts_from_a_tenth_of_the_events_on() {
        let samples = vec![(0, 90.0), (5, 50.0), (10, 20.0), (60, 30.0), (100, 25.0)];
        let memory = MemorySamples { samples }.memory();
        let expected = Memory { settled_mib: 20.0, max_mib: 30.0, end_mib: 25.0 };
        assert_eq!(memory, Some(expected));
    }
}
