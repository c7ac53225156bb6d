//! Tables of figures outside of blocks: nothing says where they come from.

use super::{BEGIN, END};

/// Cells with a figure from which on a table counts as one of results.
const FIGURES: usize = 3;

/// Marker in the line above a table whose values are not measured: published ones, settings, examples.
const STATED: &str = "<!-- stated: ";

/// Tables whose results are checked elsewhere.
const ELSEWHERE: &[&str] = &["docs/guide/gap.md", "docs/guide/gap-examples.md"];

/// One message for each table of figures that is neither generated nor said to be of stated values.
pub(super) fn tables(page: &str, text: &str) -> Vec<String> {
    if ELSEWHERE.contains(&page) {
        return Vec::new();
    }
    let (mut is_inside, mut is_stated, mut figures) = (false, false, 0);
    let mut found = Vec::new();
    // One more empty line ends a table at the end of the page.
    for (number, line) in (1..).zip(text.lines().chain([""])) {
        if line.starts_with(BEGIN.trim_start()) || line == END.trim_end() {
            is_inside = line != END.trim_end();
        }
        if line.starts_with('|') {
            figures += line.split('|').filter(|cell| is_figure(cell)).count();
            continue;
        }
        if figures >= FIGURES && !is_inside && !is_stated {
            found.push(format!(
                "{page}:{number}: a table with {figures} figures above this line is neither generated \
                 (`{}NAME -->`) nor marked `{STATED}WHAT -->`",
                BEGIN.trim()
            ));
        }
        (figures, is_stated) = (0, line.starts_with(STATED));
    }
    found
}

/// Whether a cell begins with a number that has a fraction or a measured unit.
fn is_figure(cell: &str) -> bool {
    let cell = cell.trim().trim_start_matches(['*', '+', '-', '~']);
    let number: String =
        cell.chars().take_while(|c| c.is_ascii_digit() || ".,".contains(*c)).collect();
    if !number.starts_with(|c: char| c.is_ascii_digit() || c == '.') || number.is_empty() {
        return false;
    }
    let unit = cell[number.len()..].trim_start().split([' ', ',', ';']).next().unwrap_or_default();
    let has_fraction = number.trim_end_matches(['.', ',']).contains('.');
    let measured = ["%", "ms", "px", "mm", "s", "M", "MiB"];
    // The versions of the project begin with 0.1, and a version is no figure.
    has_fraction && !cell.starts_with("0.1.") || measured.contains(&unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str =
        "| a | b |\n|---|---|\n| one | 0.5 |\n| two | 12 ms, 4 |\n| three | **.3** [.1, .4] |\n\n";

    #[test]
    fn a_table_of_figures_needs_its_source() {
        assert_eq!(tables("a.md", TABLE).len(), 1);
        assert!(tables("a.md", &format!("{BEGIN}speed -->\n{TABLE}<!-- end -->\n")).is_empty());
        assert!(tables("a.md", &format!("{STATED}published -->\n{TABLE}")).is_empty());
        // A block covers what is in it, and a mark the table below it.
        let both = format!("{BEGIN}speed -->\n{TABLE}<!-- end -->\n\n{TABLE}");
        assert_eq!(tables("a.md", &both).len(), 1);
        assert_eq!(tables("a.md", &format!("{STATED}published -->\n{TABLE}\n{TABLE}")).len(), 1);
    }

    #[test]
    fn names_and_sizes_are_no_figures() {
        for cell in ["`body`", "192x144", "5,245 recordings", "EVT 3.0", "12", "published"] {
            assert!(!is_figure(cell), "{cell}");
        }
        for cell in ["0.879 (0.725)", "15 ms", "1.99 [1.98, 2.00]", ".104", "4 %", "**+.4**"] {
            assert!(is_figure(cell), "{cell}");
        }
    }
}
