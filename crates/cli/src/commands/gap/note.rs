//! Notes on the inputs of a comparison: a line on the terminal and one of the verdict.

use evpose_gap::input::Problem;

/// A note on an input.
pub(super) enum InputNote {
    /// A property of the input, or an assumption.
    Property(String),
    /// A problem, and whether it is corrected.
    Problem(String, bool),
}

impl InputNote {
    /// A note on a problem.
    pub(super) fn of(problem: &Problem, is_corrected: bool) -> Self {
        Self::Problem(problem.to_string(), is_corrected)
    }

    /// The line on the terminal, behind a label.
    pub(super) fn on_terminal(&self) -> String {
        match self {
            Self::Property(text) => format!("note      {text}"),
            Self::Problem(text, true) => format!("corrected {text}"),
            Self::Problem(text, false) => format!("problem   {text}"),
        }
    }

    /// The line of the verdict, among its notes.
    pub(super) fn in_verdict(self) -> String {
        match self {
            Self::Property(text) => text,
            Self::Problem(text, true) => format!("corrected: {text}"),
            Self::Problem(text, false) => format!("problem: {text}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_not_called_a_note_among_notes() {
        let note = InputNote::Property("stamps are whole microseconds".to_owned());
        assert_eq!(note.on_terminal(), "note      stamps are whole microseconds");
        assert_eq!(note.in_verdict(), "stamps are whole microseconds");
        let problem = InputNote::Problem("swapped axes".to_owned(), true);
        assert_eq!(problem.on_terminal(), "corrected swapped axes");
        assert_eq!(problem.in_verdict(), "corrected: swapped axes");
    }
}
