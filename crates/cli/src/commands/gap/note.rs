//! Notes on the inputs of a comparison: a line on the terminal and one of the verdict.

use evpose_gap::input::Problem;
use evpose_gap::report::CORRECTED_NOTE;

pub(super) struct InputNote {
    /// None of a property of the input, or of an assumption.
    label: Option<&'static str>,
    text: String,
}

impl InputNote {
    /// A note on a property of the input, or an assumption.
    pub(super) fn property(text: String) -> Self {
        Self { label: None, text }
    }

    pub(super) fn of(problem: &Problem, is_corrected: bool) -> Self {
        // The verdict finds corrections by the beginning of their notes.
        let label =
            Some(if is_corrected { CORRECTED_NOTE.trim_end_matches(": ") } else { "problem" });
        Self { label, text: problem.to_string() }
    }

    /// The line on the terminal, behind a label.
    pub(super) fn on_terminal(&self) -> String {
        format!("{:<10}{}", self.label.unwrap_or("note"), self.text)
    }

    /// The line of the verdict, among its notes.
    pub(super) fn in_verdict(self) -> String {
        self.label.map(|label| format!("{label}: {}", self.text)).unwrap_or(self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_not_called_a_note_among_notes() {
        let note = InputNote::property("stamps are whole microseconds".to_owned());
        assert_eq!(note.on_terminal(), "note      stamps are whole microseconds");
        assert_eq!(note.in_verdict(), "stamps are whole microseconds");
        let problem = InputNote { label: Some("corrected"), text: "swapped axes".to_owned() };
        assert_eq!(problem.on_terminal(), "corrected swapped axes");
        assert_eq!(problem.in_verdict(), "corrected: swapped axes");
    }
}
