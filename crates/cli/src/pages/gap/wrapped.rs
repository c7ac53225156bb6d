//! Text on a terminal, wrapped behind a label.

/// Columns of a line at most.
pub(crate) const COLUMNS: usize = 100;

/// `text` behind a label, in lines of no more than a hundred columns, shortened to `max_lines`
/// lines.
pub(crate) fn wrapped(label: &str, text: &str, max_lines: usize, indent: usize) -> Vec<String> {
    let mut lines = vec![format!("{label:<indent$}")];
    let mut is_new = true;
    for word in text.split_whitespace() {
        let line = &lines[lines.len() - 1];
        // Columns are letters, not bytes.
        let columns = line.chars().count() + usize::from(!is_new) + word.chars().count();
        if columns > COLUMNS && !is_new {
            lines.push(" ".repeat(indent));
            is_new = true;
        }
        let last = lines.len() - 1;
        if !is_new {
            lines[last].push(' ');
        }
        lines[last].push_str(word);
        is_new = false;
    }
    if lines.len() > max_lines {
        lines.truncate(max_lines);
        let last = &mut lines[max_lines - 1];
        while last.chars().count() > COLUMNS - 4 {
            last.pop();
        }
        last.push_str(" ...");
    }
    for line in &mut lines {
        // A word that is longer than a line.
        *line = line.chars().take(COLUMNS).collect();
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_text_is_wrapped_behind_its_label_and_shortened() {
        let text = "word ".repeat(60);
        let lines = wrapped("LABEL", &text, 2, 8);
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("LABEL   word") && lines[1].starts_with("        word"));
        assert!(lines[1].ends_with("...") && lines[1].len() <= COLUMNS);
    }
}
