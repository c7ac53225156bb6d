//! The provenance of a stored result.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::machine::Machine;
use crate::run_info::COMMIT;

/// Machine, program and time of a result: the first fields of its JSON file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Provenance {
    /// Machine that the result was computed on.
    pub machine: Machine,
    /// Commit of the program.
    pub commit: String,
    /// Version of the program.
    #[serde(default)]
    pub version: String,
    /// Day on which it began, `YYYY-MM-DD` in UTC.
    #[serde(default)]
    pub date: String,
    /// Command line that wrote it.
    #[serde(default)]
    pub command: String,
    /// Threads that ran or waited to run on the machine, mean over the minute before (Linux): other work,
    /// which makes times longer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_before: Option<f64>,
}

impl Provenance {
    /// Of a result that this process begins to measure on `machine`.
    pub fn new(machine: Machine) -> Self {
        let arguments = std::env::args().skip(1);
        Self {
            machine,
            commit: COMMIT.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            date: date(SystemTime::now()),
            command: std::iter::once("evpose".to_owned())
                .chain(arguments)
                .collect::<Vec<_>>()
                .join(" "),
            load_before: load(),
        }
    }

    /// Of a result that this process begins to measure, with the threads in use.
    pub fn this() -> Self {
        Self::new(Machine::this())
    }
}

/// The load average of the last minute.
fn load() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    text.split(' ').next()?.parse().ok()
}

/// The day in UTC.
///
/// # Source
/// Howard Hinnant, "chrono-compatible low-level date algorithms", `civil_from_days`: years begin in March, and
/// 719,468 days lie between 0000-03-01 and 1970-01-01.
fn date(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let days = seconds / 86_400 + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    // From March on, months come in fives of 31, 30, 31, 30 and 31 days: 153 together.
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = 400 * era + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn days_are_those_of_the_calendar() {
        // `date -u -d @SECONDS +%F`
        for (seconds, day) in [
            (0, "1970-01-01"),
            (951_782_400, "2000-02-29"),
            (951_868_800, "2000-03-01"),
            (1_767_225_599, "2025-12-31"),
            (1_767_225_600, "2026-01-01"),
            (4_107_542_400, "2100-03-01"),
        ] {
            assert_eq!(date(UNIX_EPOCH + Duration::from_secs(seconds)), day);
        }
    }
}
