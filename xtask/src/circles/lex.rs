//! Rust as identifiers and punctuation, without comments, strings, characters and lifetimes.

/// A piece of source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Token {
    Ident(String),
    /// `::`
    Path,
    Other(char),
    /// A string literal, whose text only `#[path = "…"]` needs.
    Text(String),
}

impl Token {
    pub(super) fn ident(&self) -> Option<&str> {
        match self {
            Self::Ident(name) => Some(name),
            _ => None,
        }
    }

    pub(super) fn is(&self, other: char) -> bool {
        *self == Self::Other(other)
    }
}

/// All pieces of a source file.
pub(super) fn tokens(source: &str) -> Vec<Token> {
    let chars: Vec<char> = source.chars().collect();
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < chars.len() {
        let (c, next) = (chars[at], chars.get(at + 1).copied().unwrap_or(' '));
        match c {
            '/' if next == '/' => at = end_of_line(&chars, at),
            '/' if next == '*' => at = end_of_comment(&chars, at),
            '"' => at = text(&chars, at + 1, 0, &mut tokens),
            'r' | 'b' | 'c' if raw_hashes(&chars, at).is_some() => {
                let (begin, hashes) = raw_hashes(&chars, at).unwrap_or((at + 1, 0));
                at = text(&chars, begin, hashes, &mut tokens);
            }
            '\'' => at = end_of_character(&chars, at),
            ':' if next == ':' => {
                tokens.push(Token::Path);
                at += 2;
            }
            _ if is_ident(c) => {
                let end = (at..chars.len()).find(|&k| !is_ident(chars[k])).unwrap_or(chars.len());
                tokens.push(Token::Ident(chars[at..end].iter().collect()));
                at = end;
            }
            _ => {
                if !c.is_whitespace() {
                    tokens.push(Token::Other(c));
                }
                at += 1;
            }
        }
    }
    tokens
}

fn is_ident(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn end_of_line(chars: &[char], at: usize) -> usize {
    (at..chars.len()).find(|&k| chars[k] == '\n').unwrap_or(chars.len())
}

/// Block comments nest.
fn end_of_comment(chars: &[char], at: usize) -> usize {
    let mut depth = 0;
    let mut at = at;
    while at + 1 < chars.len() {
        match (chars[at], chars[at + 1]) {
            ('/', '*') => depth += 1,
            ('*', '/') => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return at;
        }
    }
    chars.len()
}

/// Start of the text of a raw or byte string, and its count of hashes, one more than that if raw.
fn raw_hashes(chars: &[char], at: usize) -> Option<(usize, usize)> {
    if at > 0 && is_ident(chars[at - 1]) {
        return None;
    }
    let mut k = at;
    while matches!(chars.get(k), Some('r' | 'b' | 'c')) && k < at + 2 {
        k += 1;
    }
    let is_raw = chars[at..k].contains(&'r');
    let hashes = (k..chars.len()).take_while(|&k| chars[k] == '#').count();
    let begins = chars.get(k + hashes) == Some(&'"') && (is_raw || hashes == 0);
    begins.then_some((k + hashes + 1, if is_raw { hashes + 1 } else { 0 }))
}

/// Adds the text that begins at `at` and returns where the source goes on. `raw` is 0 where
/// backslashes escape, else one more than the hashes that end it.
fn text(chars: &[char], at: usize, raw: usize, tokens: &mut Vec<Token>) -> usize {
    let mut k = at;
    while k < chars.len() {
        if raw == 0 && chars[k] == '\\' {
            k += 2;
            continue;
        }
        let hashes = raw.saturating_sub(1);
        let is_closed = chars[k + 1..].iter().take_while(|&&c| c == '#').take(hashes).count();
        if chars[k] == '"' && is_closed == hashes {
            tokens.push(Token::Text(chars[at..k].iter().collect()));
            return k + 1 + hashes;
        }
        k += 1;
    }
    chars.len()
}

/// End of a character literal or a lifetime.
fn end_of_character(chars: &[char], at: usize) -> usize {
    if chars.get(at + 1) == Some(&'\\') {
        let closing = (at + 3..chars.len()).find(|&k| chars[k] == '\'');
        return closing.map_or(chars.len(), |k| k + 1);
    }
    if chars.get(at + 2) == Some(&'\'') {
        return at + 3;
    }
    (at + 1..chars.len()).find(|&k| !is_ident(chars[k])).unwrap_or(chars.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn idents(source: &str) -> Vec<String> {
        tokens(source).iter().filter_map(|token| token.ident().map(str::to_owned)).collect()
    }

    #[test]
    fn comments_strings_characters_and_lifetimes_are_no_identifiers() {
        assert_eq!(idents("a // b\n /* c /* d */ e */ f"), ["a", "f"]);
        assert_eq!(idents(r##"a "b \" c" r#"d " e"# b"f" g"##), ["a", "g"]);
        assert_eq!(idents(r"a 'b' '\'' '\u{1F600}' fn<'life> z"), ["a", "fn", "z"]);
    }

    #[test]
    fn paths_are_one_token() {
        let ident = |name: &str| Token::Ident(name.into());
        assert_eq!(tokens("a::b"), [ident("a"), Token::Path, ident("b")]);
    }
}
