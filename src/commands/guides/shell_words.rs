//! The words of a command line, as a shell passes them on.

/// The command lines of evpose in a command, as the words that the shell passes on: `cargo run … --`
/// stands for `evpose`, variables and patterns of file names are left as they are.
pub(super) fn evpose_calls(command: &str) -> Vec<Vec<String>> {
    simple_commands(command).into_iter().filter_map(evpose_words).collect()
}

/// The words from `evpose` on, if that is what they call.
fn evpose_words(words: Vec<String>) -> Option<Vec<String>> {
    let program = words.first()?;
    let is_cargo = program == "cargo" && words.get(1).is_some_and(|word| word == "run");
    let skipped = if is_cargo {
        words.iter().position(|word| word == "--")?
    } else if program == "evpose" || program.ends_with("/evpose") {
        0
    } else {
        return None;
    };
    let rest = words.into_iter().skip(skipped + 1);
    Some(["evpose".to_owned()].into_iter().chain(rest).collect())
}

/// Words of the first line of a command, cut at `&&`, `|`, `;` and `>`. Quotes are taken off.
fn simple_commands(command: &str) -> Vec<Vec<String>> {
    let mut commands = vec![Vec::new()];
    let mut word: Option<String> = None;
    let mut quote = None;
    let joined = command.replace("\\\n", " ");
    let mut letters = joined.chars().take_while(|&letter| letter != '\n');
    let end_word = |word: &mut Option<String>, commands: &mut Vec<Vec<String>>| {
        let Some(word) = word.take() else { return };
        if ["&&", "|", ";"].contains(&word.as_str()) {
            commands.push(Vec::new());
        } else if word == ">" {
            // A file is no program, whatever its name.
            commands.push(vec![word]);
        } else if let Some(words) = commands.last_mut() {
            words.push(word);
        }
    };
    while let Some(letter) = letters.next() {
        match (quote, letter) {
            (None, ' ') => end_word(&mut word, &mut commands),
            (None, '\'' | '"') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (Some(open), letter) if open == letter => quote = None,
            (None, '\\') => word.get_or_insert_default().extend(letters.next()),
            (_, letter) => word.get_or_insert_default().push(letter),
        }
    }
    end_word(&mut word, &mut commands);
    commands
}
