//! Differences of two texts, line by line.

/// One line of either text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Line<'a> {
    Same(&'a str),
    Taken(&'a str),
    Added(&'a str),
}

/// The shortest way from one text to the other: lines that both have in order stay.
pub(crate) fn diff<'a>(before: &'a str, after: &'a str) -> Vec<Line<'a>> {
    let (a, b): (Vec<&str>, Vec<&str>) = (before.lines().collect(), after.lines().collect());
    // `common[i][j]`: lines that the rests from `i` and `j` have in common.
    let mut common = vec![vec![0usize; b.len() + 1]; a.len() + 1];
    for i in (0..a.len()).rev() {
        for j in (0..b.len()).rev() {
            common[i][j] = match a[i] == b[j] {
                true => common[i + 1][j + 1] + 1,
                false => common[i + 1][j].max(common[i][j + 1]),
            };
        }
    }
    let (mut i, mut j) = (0, 0);
    let mut lines = Vec::with_capacity(a.len() + b.len());
    while i < a.len() || j < b.len() {
        if i < a.len() && j < b.len() && a[i] == b[j] {
            lines.push(Line::Same(a[i]));
            (i, j) = (i + 1, j + 1);
        } else if j == b.len() || i < a.len() && common[i + 1][j] >= common[i][j + 1] {
            // Lines that are taken come before those that replace them.
            lines.push(Line::Taken(a[i]));
            i += 1;
        } else {
            lines.push(Line::Added(b[j]));
            j += 1;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_line_is_taken_and_added_and_others_stay() {
        let lines = diff("a\nb\nc", "a\nx\nc\nd");
        let expected = [
            Line::Same("a"),
            Line::Taken("b"),
            Line::Added("x"),
            Line::Same("c"),
            Line::Added("d"),
        ];
        assert_eq!(lines, expected);
        assert_eq!(diff("", ""), []);
    }
}
