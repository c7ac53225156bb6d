//! Counts of words and events that decoders skip.

/// Counts of words and events that are not events of the recording.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct SkippedRecords {
    /// Events before the first word that sets the time.
    pub(crate) untimed: u64,
    /// Events before the first row, or vectors before the first base.
    pub(crate) unplaced: u64,
    /// Events of another camera in the same file.
    pub(crate) other_camera: u64,
    /// Edges at trigger inputs.
    pub(crate) triggers: u64,
    /// Words of monitoring data, and words that go on with them.
    pub(crate) monitoring: u64,
    /// Words of types that no document names.
    pub(crate) unknown: u64,
    /// Bytes behind the last word.
    pub(crate) padding: u64,
}

impl SkippedRecords {
    /// A sentence for each count that is not 0.
    pub(crate) fn remarks(&self) -> Vec<String> {
        [
            (self.untimed, "events stand before the first time stamp: they are left out"),
            (self.unplaced, "events stand before the first row or base: they are left out"),
            (self.other_camera, "events are of another camera: they are left out"),
            (self.triggers, "edges of trigger inputs are no events: they are left out"),
            (self.monitoring, "words of monitoring data are passed over"),
            (self.unknown, "words of unknown types are passed over"),
            (self.padding, "bytes of an end of line behind the last word are passed over"),
        ]
        .into_iter()
        .filter(|&(count, _)| count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect()
    }
}
