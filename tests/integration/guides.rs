//! The commands of README.md and the guides run as a reader would type them, with small inputs and
//! few steps: those of a page in order, each block from the page's directory. That all of them are
//! understood, flags, names and keys of `--set`, is tested in `src/commands/guides.rs`. Outputs that a page
//! prints are compared with what the program says, of commands that run as they stand there;
//! `cargo xtask guides [PAGE]` writes what it says now into the pages.
#![cfg(unix)]

mod changes;
mod console;
mod inputs;
mod outputs;

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use changes::{Change, FROM_PAGE, RULES, WORDS};
use console::{PageCommand, PageOutput, commands, pages};
use inputs::Inputs;

use crate::harness::{GAPBENCH, Sandbox};

/// Pages whose commands take seconds.
const QUICK: [&str; 1] = ["docs/guide/files.md"];

/// The program: `$EVPOSE_PROGRAM`, such as one that is installed, or the one built for the tests.
fn program() -> PathBuf {
    std::env::var_os("EVPOSE_PROGRAM").map_or(env!("CARGO_BIN_EXE_evpose").into(), PathBuf::from)
}

/// A command of a page as the test runs it.
struct Small {
    text: String,
    /// Why it is not run.
    skipped: Option<&'static str>,
    /// Exit codes that are answers.
    answers: Vec<i32>,
}

impl Small {
    fn is_unchanged(&self, command: &PageCommand) -> bool {
        self.skipped.is_none() && self.text == command.text
    }
}

/// A command of a page, made small.
fn small(page: &str, command: &PageCommand) -> Small {
    let rules = RULES.iter().filter(|rule| rule.is_of(page, &command.text));
    let mut small = Small { text: command.text.clone(), skipped: None, answers: vec![0] };
    for rule in rules {
        match rule.change {
            Change::Skip(reason) => small.skipped = Some(reason),
            Change::Answers(codes) => small.answers = codes.to_vec(),
            Change::Append(words) => {
                small.text.push(' ');
                small.text += words;
            }
            Change::Replace(from, to) => {
                // A rule for text that the page no longer has would do nothing.
                assert!(small.text.contains(from), "{page}:{}: no `{from}`", command.line);
                small.text = small.text.replace(from, to);
            }
        }
    }
    for (word, changes) in WORDS {
        let set: Vec<String> = changes.iter().map(|change| format!("--set '{change}'")).collect();
        small.text = small.text.replace(word, &set.join(" "));
    }
    small
}

/// The commands of a page as a script of bash, which says which line failed.
fn script(page: &str, text: &str) -> String {
    let functions = "evpose() { \"$EVPOSE\" \"$@\"; }\ngapbench() { \"$GAPBENCH\" \"$@\"; }\n";
    let mut script = format!("{functions}here=$PWD\n");
    let mut block = 0;
    for command in commands(text) {
        let small = small(page, &command);
        if small.skipped.is_some() {
            continue;
        }
        // Each block begins in the page's directory: readers open a new terminal.
        if block != command.block {
            block = command.block;
            script += "cd \"$here\"\n";
        }
        let answers: Vec<String> = small.answers.iter().map(i32::to_string).collect();
        let _ = write!(
            // `$?` of the command before is set again, as readers may print it.
            script,
            "echo '== line {}' | tee /dev/stderr\n(exit ${{code:-0}})\n{}\ncode=$?\ncase $code in\n  {}) ;;\n  *) echo \
             \"line {}: exit code $code\" >&2; exit 1 ;;\nesac\n",
            command.line,
            small.text,
            answers.join("|"),
            command.line
        );
    }
    script
}

fn first_block<'a>(text: &'a str, language: &str) -> &'a str {
    let start = format!("```{language}\n");
    let behind = text.split_once(&start).map(|(_, behind)| behind).unwrap();
    behind.split_once("```").map(|(block, _)| block).unwrap()
}

/// The output of a page's commands.
struct Said {
    stdout: String,
    stderr: String,
}

impl Said {
    /// The output of the command in a line of the page.
    fn of(&self, line: usize) -> String {
        let of = |all: &str| {
            let behind =
                all.split_once(&format!("== line {line}\n")).map_or("", |(_, behind)| behind);
            behind.split_once("== line ").map_or(behind, |(said, _)| said).to_owned()
        };
        of(&self.stdout) + &of(&self.stderr)
    }
}

/// The output of every command of a page that runs as it stands there, as the page has it, and what it said.
fn printed(page: &str, text: &str, said: &Said) -> Vec<(PageOutput, String)> {
    commands(text)
        .into_iter()
        .filter(|command| small(page, command).is_unchanged(command))
        .flat_map(|command| {
            let said = said.of(command.line);
            command.output.into_iter().map(move |output| (output, said.clone()))
        })
        .collect()
}

/// Whether outputs are written into the pages.
fn writes_pages() -> bool {
    std::env::var_os("EVPOSE_WRITE_PAGES").is_some()
}

/// Runs the commands of a page, and compares their outputs with the page, or writes them into it.
fn check(page: &str, text: &str, inputs: &Inputs) -> Result<(), String> {
    let said = run(page, text, inputs)?;
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut wrong = Vec::new();
    // From the end, so that lines before stay where they are.
    for (output, said) in printed(page, text, &said).into_iter().rev() {
        let PageOutput { line, lines: on_page } = output;
        if !writes_pages() {
            wrong.extend(
                outputs::compare(&on_page, &said)
                    .err()
                    .map(|wrong| format!("{page}:{line}: {wrong}")),
            );
            continue;
        }
        match outputs::renewed(&on_page, &said) {
            Ok(now) => drop(lines.splice(line - 1..line - 1 + on_page.len(), now)),
            Err(problem) => wrong.push(format!("{page}:{line}: {problem}")),
        }
    }
    if writes_pages() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
        fs::write(path, lines.join("\n") + "\n").unwrap();
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

/// Runs the commands of a page; what they said last if one fails.
fn run(page: &str, text: &str, inputs: &Inputs) -> Result<Said, String> {
    let sandbox = Sandbox::new();
    let directory = sandbox.path("reader");
    fs::create_dir(&directory).unwrap();
    inputs.put(page, &directory);
    for (_, name, language) in FROM_PAGE.iter().filter(|(of, ..)| page.ends_with(of)) {
        fs::write(directory.join(name), first_block(text, language)).unwrap();
    }
    let script = script(page, text);
    let mut command = Command::new("bash");
    if script.contains("\ngapbench ") {
        // It is built for the pages that run it.
        command.env("GAPBENCH", &*GAPBENCH);
    }
    let output = command
        .args(["-c", &script])
        .current_dir(&directory)
        .env("EVPOSE", program())
        .env("EVPOSE_DATA", sandbox.path("data-directory"))
        // No terminal: questions of the program must not wait.
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let said = text(&output.stderr);
    if output.status.success() {
        return Ok(Said { stdout: text(&output.stdout), stderr: said });
    }
    let last = said.rfind("== line").map_or(said.as_str(), |at| &said[at..]);
    Err(format!("{page}: {last}"))
}

/// Runs pages, and says of each that fails where.
fn run_pages(is_chosen: impl Fn(&str) -> bool) {
    let pages: Vec<(String, String)> =
        pages().into_iter().filter(|(page, _)| is_chosen(page)).collect();
    let names: Vec<&str> = pages.iter().map(|(page, _)| page.as_str()).collect();
    let inputs = Inputs::of(&names);
    let failures: Vec<String> =
        pages.iter().filter_map(|(page, text)| check(page, text, &inputs).err()).collect();
    assert!(!pages.is_empty() && failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn quick_pages_run() {
    run_pages(|page| QUICK.contains(&page));
}

#[test]
#[ignore = "half an hour with optimisation: trainings, and searches for missing effects"]
fn all_pages_run() {
    let only = std::env::var("EVPOSE_PAGE").unwrap_or_default();
    run_pages(|page| page.contains(&only));
}

#[test]
fn every_rule_is_about_a_command_of_a_page() {
    let commands: Vec<(String, String)> = pages()
        .into_iter()
        .flat_map(|(page, text)| {
            commands(&text).into_iter().map(move |command| (page.clone(), command.text))
        })
        .collect();
    for rule in RULES {
        let matched = commands.iter().any(|(page, command)| rule.is_of(page, command));
        assert!(matched, "{}: no command has `{}`", rule.page, rule.command);
    }
}

#[test]
fn commands_that_are_not_run_are_few() {
    let (mut run, mut skipped) = (0, Vec::new());
    for (page, text) in pages() {
        for command in commands(&text) {
            match small(&page, &command).skipped {
                Some(reason) => skipped.push(format!("{page}:{}: {reason}", command.line)),
                None => run += 1,
            }
        }
    }
    assert!(run > 4 * skipped.len(), "{run} run, not these:\n{}", skipped.join("\n"));
}

#[test]
fn a_page_that_fails_is_seen() {
    let inputs = Inputs::of(&[]);
    let page = |second: &str| format!("```console\n$ mkdir a && cd a\n$ {second}\n```\n");
    let block = "```console\n$ evpose sensor show davis346\n```\n";
    assert_eq!(check("", &(page("ls ../a") + block), &inputs), Ok(()));
    let message = check("", &(page("evpose info nofile") + block), &inputs).unwrap_err();
    assert!(message.contains("line 3") && message.contains("nofile"), "{message}");
}

#[test]
fn a_page_that_prints_another_output_is_seen() {
    let inputs = Inputs::of(&[]);
    let page = |code: i32, offset: &str, name: &str| {
        format!(
            "```console\n$ true\n$ echo $?\n{code}\n$ evpose sensor show ideal\n...\n      dark_offset  {offset} \
             white …\n```\n\nSo:\n\n```text\n{name}: The ideal event pixel: …\n...\n```\n"
        )
    };
    assert_eq!(check("", &page(0, "0.001", "ideal"), &inputs), Ok(()));
    // One thing differs from what the program prints, each time.
    for (code, offset, name, line) in
        [(1, "0.001", "ideal", ":4:"), (0, "0.003", "ideal", ":6:"), (0, "0.001", "idea", ":13:")]
    {
        let message = check("", &page(code, offset, name), &inputs).unwrap_err();
        assert!(message.starts_with(line) && !message.contains('\n'), "{message}");
    }
}
