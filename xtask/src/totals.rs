//! Tests seen in the output of `cargo test`.

/// Counts of tests, and the names that a summary needs.
#[derive(Debug, Default)]
pub(crate) struct Totals {
    pub(crate) passed: u64,
    pub(crate) failed: u64,
    pub(crate) ignored: u64,
    /// Names of tests that ran.
    run: Vec<String>,
    pub(crate) failed_tests: Vec<String>,
    /// Names of ignored tests, with the reasons that were given.
    pub(crate) ignored_tests: Vec<(String, String)>,
}

impl Totals {
    /// Adds a line like `test result: ok. 3 passed; 0 failed; 1 ignored; …`, or that of a test.
    pub(crate) fn add_line(&mut self, line: &str) {
        if let Some((_, counts)) = line.split_once("test result: ") {
            self.add_counts(counts);
        } else if let Some((name, result)) =
            line.strip_prefix("test ").and_then(|line| line.split_once(" ... "))
        {
            self.add_test(name.trim(), result.trim());
        }
    }

    fn add_counts(&mut self, counts: &str) {
        let words: Vec<&str> = counts.split([' ', ';', '.']).filter(|w| !w.is_empty()).collect();
        for pair in words.windows(2) {
            let Ok(count) = pair[0].parse::<u64>() else { continue };
            match pair[1] {
                "passed" => self.passed += count,
                "failed" => self.failed += count,
                "ignored" => self.ignored += count,
                _ => {}
            }
        }
    }

    fn add_test(&mut self, name: &str, result: &str) {
        let name = name.to_owned();
        // Its own harness writes `ignored, reason`; that of tests without it `ignored (reason)`.
        if let Some(reason) = result.strip_prefix("ignored") {
            let reason = reason.trim_start_matches([',', ' ']);
            let inner = reason.strip_prefix('(').and_then(|reason| reason.strip_suffix(')'));
            self.ignored_tests.push((name, inner.unwrap_or(reason).to_owned()));
        } else if result == "ok" {
            self.run.push(name);
        } else if result == "FAILED" {
            self.run.push(name.clone());
            self.failed_tests.push(name);
        }
    }

    /// Adds those of a later step. What it `runs_ignored` is ignored no longer.
    pub(crate) fn add_step(&mut self, step: Self, runs_ignored: bool) {
        if runs_ignored {
            let before = self.ignored_tests.len();
            self.ignored_tests.retain(|(name, _)| !step.run.contains(name));
            self.ignored -= (before - self.ignored_tests.len()) as u64;
        }
        self.passed += step.passed;
        self.failed += step.failed;
        self.ignored += step.ignored;
        self.failed_tests.extend(step.failed_tests);
        self.ignored_tests.extend(step.ignored_tests);
    }

    /// Whether no test was found.
    pub(crate) fn is_empty(&self) -> bool {
        self.passed + self.failed + self.ignored == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(lines: &[&str]) -> Totals {
        let mut totals = Totals::default();
        lines.iter().for_each(|line| totals.add_line(line));
        totals
    }

    #[test]
    fn totals_add_up_over_test_binaries() {
        let totals = of(&[
            "test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out",
            "test result: FAILED. 2 passed; 4 failed; 0 ignored; 0 measured",
            "running 5 tests",
        ]);
        assert_eq!((totals.passed, totals.failed, totals.ignored), (5, 4, 1));
        assert!(!totals.is_empty() && of(&["running 0 tests"]).is_empty());
    }

    #[test]
    fn names_and_reasons_are_read_of_both_harnesses() {
        let totals = of(&[
            "test slow ... ignored, ten minutes",
            "test page   ... ignored (no Chromium (or other))",
            "test src/lib.rs - (line 3) ... ignored",
            "test wrong ... FAILED",
            "test right ... ok",
        ]);
        let ignored: Vec<_> =
            totals.ignored_tests.iter().map(|(n, r)| (n.as_str(), r.as_str())).collect();
        let last = ("src/lib.rs - (line 3)", "");
        assert_eq!(ignored, [("slow", "ten minutes"), ("page", "no Chromium (or other)"), last]);
        assert_eq!(totals.failed_tests, ["wrong"]);
    }

    #[test]
    fn what_a_later_step_runs_is_no_longer_ignored() {
        let first = || {
            of(&[
                "test tiles ... ignored, needs AMX",
                "test other ... ignored",
                "test result: ok. 7 passed; 0 failed; 2 ignored;",
            ])
        };
        let later =
            || of(&["test tiles ... ok", "test result: ok. 1 passed; 0 failed; 0 ignored;"]);
        for (runs_ignored, ignored) in [(true, 1), (false, 2)] {
            let mut totals = first();
            totals.add_step(later(), runs_ignored);
            assert_eq!((totals.passed, totals.failed, totals.ignored), (8, 0, ignored));
        }
    }
}
