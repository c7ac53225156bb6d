//! Identifiers as words.

/// A line in lower case, with a space for every underscore and before every capital inside a word.
pub(super) fn spaced(line: &str) -> String {
    let mut spaced = String::with_capacity(line.len() + 16);
    let mut previous = ' ';
    for character in line.chars() {
        let begins_part = character.is_uppercase() && previous.is_lowercase();
        if begins_part {
            spaced.push(' ');
        }
        match character {
            '_' => spaced.push(' '),
            _ => spaced.extend(character.to_lowercase()),
        }
        previous = character;
    }
    spaced
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snake_and_camel_case_come_apart() {
        assert_eq!(spaced("MOST_EFFECTS of HowFar, Vec3"), "most effects of how far, vec3");
    }
}
