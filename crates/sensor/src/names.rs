//! Suggestions for misspelt names.

/// At most three of `known` that resemble `name`, the most similar first.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let plain = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    let typed = plain(name);
    let mut similar: Vec<(usize, &str)> = known
        .into_iter()
        .filter_map(|candidate| {
            let other = plain(candidate);
            let apart = distance(&typed, &other);
            let is_part = typed.len() >= 3 && (other.contains(&typed) || typed.contains(&other));
            // At most two letters in five differ.
            let is_near = apart * 5 <= 2 * typed.chars().count().max(other.chars().count());
            (is_part || is_near).then_some((if is_part { 0 } else { apart }, candidate))
        })
        .collect();
    similar.sort_by_key(|&(apart, _)| apart);
    similar.into_iter().take(3).map(|(_, candidate)| candidate).collect()
}

/// `; did you mean a, b?`, or nothing.
pub(crate) fn hint<S: AsRef<str>>(name: &str, known: &[S]) -> String {
    let near = nearest(name, known.iter().map(AsRef::as_ref));
    if near.is_empty() { String::new() } else { format!("; did you mean {}?", near.join(", ")) }
}

/// How many letters must be put in, left out or changed (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        // One row of the matrix of Levenshtein (1966) is enough: only the row before is looked at.
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let changed = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_counted() {
        for (a, b, apart) in [("", "abc", 3), ("leak", "leak", 0), ("lek", "leak", 1)] {
            assert_eq!(distance(a, b), apart);
            assert_eq!(distance(b, a), apart);
        }
    }

    #[test]
    fn slips_parts_and_hyphens_are_understood() {
        let known = ["davis240c", "davis346", "leak_on", "v2e-clean"];
        assert_eq!(nearest("davis", known), ["davis240c", "davis346"]);
        assert_eq!(nearest("leak-onn", known), ["leak_on"]);
        assert_eq!(nearest("v2e_clean", known), ["v2e-clean"]);
        assert!(nearest("prophesee", known).is_empty());
    }
}
