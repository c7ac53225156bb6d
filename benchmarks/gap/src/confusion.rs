//! Confusion matrix: answers by hidden effects.

use std::collections::BTreeMap;

use gapbench_pixel::{CaseKind, EFFECTS};

use super::opened::Opened;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Cell {
    pub(super) n: usize,
    /// Of them: expected answers, and names that are not there.
    pub(super) met: usize,
    pub(super) wrong: usize,
}

/// The matrix: rows are hidden effects, columns answers.
#[derive(Debug, Default)]
pub(super) struct Confusion {
    pub(super) rows: Vec<String>,
    pub(super) columns: Vec<String>,
    pub(super) cells: Vec<Vec<Cell>>,
}

impl Confusion {
    pub(super) fn from_cases(opened: &[Opened]) -> Self {
        let mut rows = BTreeMap::new();
        let mut columns = BTreeMap::new();
        // Ranks before names: rows and columns in the order of the page, each once.
        for case in opened {
            rows.insert((row_rank(case), case.title()), ());
            columns.insert((column_rank(&case.answer_label()), case.answer_label()), ());
        }
        let rows: Vec<String> = rows.into_keys().map(|(_, name)| name).collect();
        let columns: Vec<String> = columns.into_keys().map(|(_, name)| name).collect();
        let mut cells = vec![vec![Cell::default(); columns.len()]; rows.len()];
        for case in opened {
            let (title, answer) = (case.title(), case.answer_label());
            let row = rows.iter().position(|name| *name == title);
            let column = columns.iter().position(|name| *name == answer);
            if let (Some(row), Some(column)) = (row, column) {
                let cell = &mut cells[row][column];
                cell.n += 1;
                cell.met += usize::from(case.is_met());
                cell.wrong += usize::from(case.is_wrong());
            }
        }
        Self { rows, columns, cells }
    }
}

/// Singles that show in the order of the plan, then other groups, then singles that do not show.
fn row_rank(case: &Opened) -> (usize, usize) {
    let effect = EFFECTS.iter().position(|effect| effect.name() == case.hidden());
    match (case.truth.kind, case.truth.is_visible) {
        (CaseKind::Single, true) => (0, effect.unwrap_or(EFFECTS.len())),
        (CaseKind::Single, false) => (7, effect.unwrap_or(EFFECTS.len())),
        (CaseKind::Pair, _) => (1, 0),
        (CaseKind::Several, _) => (1, 1),
        (CaseKind::Parameter, _) => (2, 0),
        (CaseKind::Null, _) => (3, 0),
        (CaseKind::LeftOut, _) => (4, 0),
        (CaseKind::NeverCatalogued, _) => (5, 0),
    }
}

/// Single names in the order of the plan, then others, then words that name nothing.
fn column_rank(answer: &str) -> (usize, usize) {
    let effect = EFFECTS.iter().position(|effect| effect.name() == answer);
    let words =
        ["conventions alone", "parameter", "no_gap", "partial", "undecided", "none_of_catalogue"];
    let word = words.iter().position(|word| *word == answer);
    match (effect, word) {
        (Some(i), _) => (0, i),
        (_, Some(i)) => (3, i),
        _ if answer.contains(" right, ") => (1, 0),
        _ => (2, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    #[test]
    fn every_case_is_in_one_cell_and_right_ones_are_on_the_diagonal() {
        let opened = example::opened();
        let matrix = Confusion::from_cases(&opened);
        let all: usize = matrix.cells.iter().flatten().map(|cell| cell.n).sum();
        assert_eq!(all, opened.len());
        for (i, effect) in EFFECTS.iter().enumerate() {
            assert_eq!(matrix.rows[i], effect.name());
            assert_eq!(matrix.columns[i], effect.name());
            let cell = matrix.cells[i][i];
            assert_eq!((cell.n, cell.met, cell.wrong), (9, 9, 0), "{}", matrix.rows[i]);
        }
    }
}
