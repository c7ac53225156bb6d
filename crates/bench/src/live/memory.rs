//! How much memory the program holds.

use serde::Serialize;

/// What a run held, in MiB.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Memory {
    /// When a tenth of it was done.
    pub(super) settled_mib: f64,
    /// The most from then on.
    pub(super) most_mib: f64,
    /// At its end.
    pub(super) end_mib: f64,
}

/// Looks at the memory again and again.
#[derive(Debug, Default)]
pub(super) struct Watched {
    /// Events that had come, and MiB.
    looks: Vec<(u64, f64)>,
}

impl Watched {
    pub(super) fn infer(&mut self, events: u64) {
        self.looks.extend(resident_mib().map(|mib| (events, mib)));
    }

    /// None where the system does not tell.
    pub(super) fn memory(&self) -> Option<Memory> {
        let &(all, end_mib) = self.looks.last()?;
        let settled = self.looks.iter().position(|(events, _)| 10 * events >= all)?;
        let later = &self.looks[settled..];
        let most_mib = later.iter().map(|(_, mib)| *mib).fold(0.0, f64::max);
        Some(Memory { settled_mib: later[0].1, most_mib, end_mib })
    }
}

/// Linux tells without a dependency.
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
        let looks = vec![(0, 90.0), (5, 50.0), (10, 20.0), (60, 30.0), (100, 25.0)];
        let memory = Watched { looks }.memory();
        let expected = Memory { settled_mib: 20.0, most_mib: 30.0, end_mib: 25.0 };
        assert_eq!(memory, Some(expected));
    }
}
