//! Where a refused word is the right one.

pub(super) struct Exception {
    /// The word's name in the list.
    pub(super) word: &'static str,
    /// The beginning of the paths it holds for.
    pub(super) path: &'static str,
    /// A part of the lines it holds for; empty for all.
    pub(super) line: &'static str,
    #[expect(dead_code, reason = "for the reader")]
    reason: &'static str,
}

const fn allow(
    word: &'static str,
    path: &'static str,
    line: &'static str,
    reason: &'static str,
) -> Exception {
    Exception { word, path, line, reason }
}

/// By word, then by path.
pub(super) const ALLOWED: &[Exception] = &[
    allow("exchange", "crates/gap/src/c2st/mod.rs", "CounterRng", "the key of a noise stream"),
    allow(
        "judge",
        "crates/cli/src/commands/gap/verify.rs",
        "seed_for(",
        "the key of a noise stream",
    ),
    allow("lab", "crates/gap/src/workflow/inputs.rs", "seed_for(", "the key of a noise stream"),
    allow("numbers", "crates/gap/", "CounterRng", "keys of noise streams"),
    allow(
        "picture",
        "crates/bench/src/repr/photograph.rs",
        "CounterRng",
        "the key of a noise stream",
    ),
    allow("surface of events", "crates/bench/src/sim/mesh.rs", "", "surfaces of bodies"),
    allow("kept", "xtask/src/totals.rs", "passed", "tests that passed"),
    allow(
        "surface of events",
        "",
        "(locally normalised event surfaces)",
        "the name that LNES abbreviates",
    ),
    allow("between", "", "difference", "a difference between two poses"),
    allow("surface of events", "crates/repr/tests/golden/", "`surface.h`", "the name of a file"),
    allow("surface of events", "crates/body/", "", "surfaces of bodies"),
    allow("surface of events", "crates/sim/", "", "surfaces of bodies and scenes"),
];
