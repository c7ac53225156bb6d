//! Outputs as pages print them, compared with what the program says.

/// Relative difference of a number beyond which it is another: results are the same on every run, and nearly so
/// on processors with other vector instructions.
const TOLERANCE: f64 = 0.02;

/// A line that stands for any others, and the end of one that stands for the rest of it.
const ELLIPSES: [&str; 2] = ["...", "…"];

/// A line without its values, and its values with the unit of their last digit: 0 of whole ones.
fn parts(line: &str) -> (String, Vec<(f64, f64)>) {
    let (mut words, mut values) = (String::new(), Vec::new());
    let letters: Vec<char> = line.chars().collect();
    let digit = |at: usize| letters.get(at).is_some_and(char::is_ascii_digit);
    let mut at = 0;
    while let Some(&letter) = letters.get(at) {
        if !(digit(at) || letter == '.' && digit(at + 1)) {
            let is_double = letter == ' ' && (words.ends_with(' ') || words.is_empty());
            if !is_double {
                words.push(letter);
            }
            at += 1;
            continue;
        }
        let begin = at;
        while digit(at) || (letters.get(at) == Some(&'.') && digit(at + 1)) {
            at += 1;
        }
        let text: String = letters[begin..at].iter().collect();
        let digits = text.split_once('.').map_or(0, |(_, behind)| behind.len() as i32);
        let unit = if digits == 0 { 0.0 } else { 10f64.powi(-digits) };
        // A version such as 1.2.3 is no number, and has to be the same.
        match text.parse() {
            Ok(number) => {
                words.push('#');
                values.push((number, unit));
            }
            Err(_) => words += &text,
        }
    }
    (words.trim_end().to_owned(), values)
}

/// Whether a line of the program is the one of a page, its values aside.
fn is_same_line(page: &str, said: &str) -> bool {
    match ELLIPSES.iter().find_map(|ellipsis| page.trim_end().strip_suffix(ellipsis)) {
        Some(begin) => parts(said).0.starts_with(&parts(begin).0),
        None => parts(page).0 == parts(said).0,
    }
}

/// The values of a page's line that are not those of the program's.
fn wrong_values(page: &str, said: &str) -> Vec<String> {
    let pairs = parts(page).1.into_iter().zip(parts(said).1);
    let is_wrong = |((page, unit), (said, _)): &((f64, f64), (f64, f64))| {
        let difference = (page - said).abs();
        difference > unit * 1.01 && difference > TOLERANCE * said.abs()
    };
    pairs.filter(is_wrong).map(|((page, _), (said, _))| format!("{page} is {said}")).collect()
}

/// The lines of the program that a page's lines are: those between two ellipses one after another.
///
/// # Errors
/// The first line of a page that the program does not say there.
fn matched<'a>(page: &[&str], said: &[&'a str]) -> Result<Vec<&'a str>, String> {
    let mut matched = Vec::new();
    let mut from = 0;
    for group in
        page.split(|line| ELLIPSES.contains(&line.trim())).filter(|group| !group.is_empty())
    {
        let is_here =
            |lines: &[&str]| lines.iter().zip(group).all(|(said, page)| is_same_line(page, said));
        let at = said[from..].windows(group.len()).position(is_here).ok_or_else(|| {
            // The first line that is nowhere: others may only have moved.
            let missing =
                group.iter().find(|page| !said[from..].iter().any(|said| is_same_line(page, said)));
            format!("the program does not say `{}`", missing.unwrap_or(&group[0]).trim())
        })?;
        matched.extend(&said[from + at..from + at + group.len()]);
        from += at + group.len();
    }
    Ok(matched)
}

/// The lines of a page without those that are empty.
fn on_page(lines: &[String]) -> Vec<&str> {
    lines.iter().map(String::as_str).filter(|line| !line.trim().is_empty()).collect()
}

/// The lines of an output without those that are empty.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim_end).filter(|line| !line.is_empty()).collect()
}

/// Compares the output that a page prints with what the program said.
///
/// # Errors
/// What differs.
pub(crate) fn compare(page: &[String], said: &str) -> Result<(), String> {
    let (page, said) = (on_page(page), lines(said));
    let mut wrong = Vec::new();
    let printed = page.iter().filter(|line| !ELLIPSES.contains(&line.trim()));
    for (page, said) in printed.zip(matched(&page, &said)?) {
        wrong.extend(
            wrong_values(page, said).into_iter().map(|wrong| format!("{wrong}, in `{said}`")),
        );
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) }
}

/// The output of a page as the program says it now; lines that a page leaves out stay out.
///
/// # Errors
/// If a page leaves lines out, and the others are not said.
pub(crate) fn renewed(page: &[String], said: &str) -> Result<Vec<String>, String> {
    let said = lines(said);
    match matched(&on_page(page), &said) {
        Ok(now) => {
            let mut now = now.into_iter();
            let renewed = page.iter().map(|line| {
                let trimmed = line.trim_end();
                if trimmed.is_empty() || ELLIPSES.contains(&trimmed.trim()) {
                    return line.clone();
                }
                let said = now.next().unwrap_or_default();
                match ELLIPSES.iter().find(|ellipsis| trimmed.ends_with(**ellipsis)) {
                    Some(ellipsis) if !said.ends_with(ellipsis) => {
                        shortened(trimmed, said, ellipsis)
                    }
                    _ => said.to_owned(),
                }
            });
            Ok(renewed.collect())
        }
        // Without an ellipsis the whole output is the page's.
        Err(_) if !page.iter().any(|line| ELLIPSES.contains(&line.trim())) => {
            Ok(said.into_iter().map(str::to_owned).collect())
        }
        Err(problem) => Err(problem),
    }
}

/// A line up to about where a page breaks it off.
fn shortened(page: &str, said: &str, ellipsis: &str) -> String {
    let words = page.split_whitespace().count() - 1;
    let end = said
        .split_whitespace()
        .nth(words)
        .map_or(said.len(), |word| word.as_ptr() as usize - said.as_ptr() as usize);
    format!("{}{ellipsis}", &said[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAID: &str = "note  first\nMISSING EFFECT: LEAK_ON\nGAP     6.76 [4.12, 9.57] as given\n\nseen 1001 \
                        frames, of version 1.2.3\n11\n";

    fn compared(page: &[&str]) -> Result<(), String> {
        compare(&page.iter().map(|line| (*line).to_owned()).collect::<Vec<_>>(), SAID)
    }

    #[test]
    fn a_page_that_says_what_the_program_says_passes() {
        assert_eq!(
            compared(&["MISSING EFFECT: LEAK_ON", "GAP 6.77 [4.12, 9.5] as given", "...", "11"]),
            Ok(())
        );
        assert_eq!(
            compared(&["GAP     6.76 [4.12, 9.57] …", "", "seen 1001 frames, of version 1.2.3"]),
            Ok(())
        );
    }

    #[test]
    fn another_name_number_or_line_is_seen() {
        for page in [
            &["MISSING EFFECT: REFRACTORY"][..],
            &["GAP     6.9 [4.12, 9.57] as given"],
            &["MISSING EFFECT: LEAK_ON", "11"],
            &["11", "...", "MISSING EFFECT: LEAK_ON"],
            &["seen 1001 frames, of version 1.2.4"],
            &["12"],
        ] {
            assert!(compared(page).is_err(), "{page:?}");
        }
    }

    #[test]
    fn what_a_page_leaves_out_stays_out() {
        let page = ["MISSING EFFECT: LEAK_ON", "", "GAP 9.9 …", "...", "12"].map(str::to_owned);
        let renewed = renewed(&page, SAID).expect("the lines are said");
        assert_eq!(renewed, ["MISSING EFFECT: LEAK_ON", "", "GAP     6.76 …", "...", "11"]);
        let all = super::renewed(&["gone".to_owned()], SAID).expect("all of it");
        assert_eq!(all.len(), 5);
    }
}
