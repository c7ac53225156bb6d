//! The commands of a page: lines that begin with `$ ` in its ```` ```console ```` blocks.

use std::fs;
use std::path::Path;

/// A command as a page has it.
#[derive(Debug, Clone)]
pub(crate) struct PageCommand {
    /// Line of the page, from 1.
    pub(crate) line: usize,
    /// Number of its block in the page, from 1.
    pub(crate) block: usize,
    /// Text that a reader types: continued lines and here-documents included, comments taken off.
    pub(crate) text: String,
}

/// README.md and the guides, by their path in the repository, in the order of their names.
pub(crate) fn pages() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let guides = fs::read_dir(root.join("docs/guide")).expect("docs/guide");
    let mut names: Vec<String> = guides
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".md"))
        .map(|name| format!("docs/guide/{name}"))
        .collect();
    names.push("README.md".to_owned());
    names.sort();
    let read = |name: String| {
        let text = fs::read_to_string(root.join(&name)).expect("a page that can be read");
        (name, text)
    };
    names.into_iter().map(read).collect()
}

/// The commands of a page, in its order.
pub(crate) fn commands(page: &str) -> Vec<PageCommand> {
    let mut commands = Vec::new();
    let mut lines = page.lines().enumerate();
    let (mut is_console, mut block) = (false, 0);
    while let Some((index, line)) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            is_console = language == "console";
            block += usize::from(is_console);
            continue;
        }
        let Some(command) = line.strip_prefix("$ ").filter(|_| is_console) else { continue };
        let mut text = without_comment(command).to_owned();
        while text.ends_with('\\') {
            let Some((_, next)) = lines.next() else { break };
            text.push('\n');
            text.push_str(without_comment(next));
        }
        if let Some((_, end)) = command.split_once("<<") {
            let end = end.trim_matches('\'');
            for (_, next) in lines.by_ref() {
                text.push('\n');
                text.push_str(next);
                if next == end {
                    break;
                }
            }
        }
        commands.push(PageCommand { line: index + 1, block, text });
    }
    commands
}

/// A line without the comment at its end: a `#` outside quotes that follows a space.
fn without_comment(line: &str) -> &str {
    let mut quote = None;
    let mut before = ' ';
    for (at, letter) in line.char_indices() {
        match (quote, letter) {
            (None, '#') if before == ' ' => return line[..at].trim_end(),
            (None, '\'' | '"') => quote = Some(letter),
            (Some(open), letter) if open == letter => quote = None,
            _ => {}
        }
        before = letter;
    }
    line.trim_end()
}
