//! Where a refused word is the right one.

/// An exception.
pub(super) struct Exception {
    /// The word's name in the list.
    pub(super) word: &'static str,
    /// The beginning of the paths it holds for.
    pub(super) path: &'static str,
    /// A part of the lines it holds for; empty for all.
    pub(super) line: &'static str,
    /// The reason.
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
    allow("surface of events", "", "time surface", "the representation of that name"),
    allow("surface of events", "", "TimeSurface", "the representation of that name"),
    allow("surface of events", "", "time_surface", "the representation of that name"),
    allow("surface of events", "crates/body/src/implicit", "", "a surface in space"),
    allow("surface of events", "crates/body/src/human", "", "a surface in space"),
    allow("eye", "crates/body/", "", "a part of the body"),
    allow("eye", "crates/pose/", "", "a part of the body"),
    allow("eye", "crates/datasets/", "", "a part of the body"),
];
