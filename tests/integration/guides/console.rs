//! The commands of a page: lines that begin with `$ ` in its ```` ```console ```` blocks. Lines behind a command are
//! its output, and so is the ```` ```text ```` block behind a console block, of the program's last command there.

use std::fs;
use std::path::Path;

#[derive(Debug, Clone)]
pub(crate) struct PageCommand {
    pub(crate) line: usize,
    /// Number of its block in the page, from 1.
    pub(crate) block: usize,
    /// Text that a reader types: continued lines and here-documents included, comments taken off.
    pub(crate) text: String,
    /// Output as the page prints it: the place in the page, and the lines.
    pub(crate) output: Vec<PageOutput>,
}

/// Lines of a page, one after another.
#[derive(Debug, Clone)]
pub(crate) struct PageOutput {
    /// The first of them, from 1.
    pub(crate) line: usize,
    pub(crate) lines: Vec<String>,
}

impl PageCommand {
    fn print(&mut self, line: usize, text: &str) {
        match self.output.last_mut() {
            Some(output) if output.line + output.lines.len() == line => {
                output.lines.push(text.to_owned());
            }
            _ => self.output.push(PageOutput { line, lines: vec![text.to_owned()] }),
        }
    }
}

/// README.md and the pages of `docs` and `docs/guide`, by their path in the repository, in the order of their names.
pub(crate) fn pages() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut names = vec!["README.md".to_owned()];
    for folder in ["docs", "docs/guide"] {
        let entries = fs::read_dir(root.join(folder)).expect("a folder of pages");
        let files = entries.map(|entry| entry.expect("an entry").file_name());
        let pages = files.map(|name| format!("{folder}/{}", name.to_string_lossy()));
        names.extend(pages.filter(|name| name.ends_with(".md")));
    }
    // In a fixed order, whatever the file system's.
    names.sort();
    let read = |name: String| {
        let text = fs::read_to_string(root.join(&name)).expect("a page that can be read");
        (name, text)
    };
    names.into_iter().map(read).collect()
}

pub(crate) fn commands(page: &str) -> Vec<PageCommand> {
    let mut commands: Vec<PageCommand> = Vec::new();
    let mut lines = page.lines().enumerate();
    let (mut is_console, mut is_text, mut block) = (false, false, 0);
    while let Some((index, line)) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            // A text that is not behind a console block, or has commands itself, is no output.
            is_text = language == "text" && commands.last().is_some_and(|last| last.block == block);
            is_console = language == "console";
            block += usize::from(is_console || !language.is_empty() && !is_text);
            continue;
        }
        if is_text || is_console && !line.starts_with("$ ") {
            let of_block = |command: &&mut PageCommand| {
                command.block == block && (is_console || command.text.starts_with("evpose"))
            };
            is_text &= !line.starts_with("$ ");
            if let Some(command) =
                commands.iter_mut().rev().find(of_block).filter(|_| is_text || is_console)
            {
                command.print(index + 1, line);
            }
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
        commands.push(PageCommand { line: index + 1, block, text, output: Vec::new() });
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
