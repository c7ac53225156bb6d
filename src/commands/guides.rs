//! README.md, the guides and the examples of `--help`: every command line in them is understood,
//! down to the keys of `--set`. That they run is another test's, `guides` of the integration tests.

use std::path::Path;

use clap::{ArgMatches, Command, CommandFactory as _};
use evpose_cli::configs;
use evpose_cli::tasks::task_of_config;
use evpose_task::baseline::BaselineConfig;
use evpose_task::body::BodyConfig;
use evpose_task::hand::HandConfig;

use crate::Args;
use console::{commands, pages};
use shell_words::evpose_calls;

#[path = "../../tests/integration/guides/console.rs"]
mod console;
mod shell_words;

/// Parses a command line as the program does, and reads its config with the changes of `--set`.
fn check(words: &[String]) -> Result<(), String> {
    let matches = Args::command().try_get_matches_from(words).map_err(|e| e.to_string())?;
    let mut names = vec![];
    let mut leaf = &matches;
    while let Some((name, inner)) = leaf.subcommand() {
        names.push(name);
        leaf = inner;
    }
    let Some(overrides) = texts(leaf, "overrides") else { return Ok(()) };
    let configs = match names.as_slice() {
        ["ablate" | "compare", "body"] => {
            ["pretrain", "finetune"].map(|id| text(leaf, id)).to_vec()
        }
        ["gap", "payoff"] => vec![text(leaf, "config").or(Some("quick".to_owned()))],
        _ => vec![text(leaf, "config")],
    };
    // Files that the page makes are the other test's.
    let here = |config: &String| {
        let is_name = configs::CONFIGS.find(config).is_some();
        is_name || !config.ends_with(".toml") || Path::new(config).exists()
    };
    for config in configs.into_iter().flatten().filter(here) {
        let read = task_of_config(&config).and_then(|task| match task.name() {
            "body" => configs::load_for_simulation::<BodyConfig>(&config, &overrides).map(drop),
            "baseline" => configs::load::<BaselineConfig>(&config, &overrides).map(drop),
            _ => configs::load_for_simulation::<HandConfig>(&config, &overrides).map(drop),
        });
        read.map_err(|error| format!("{error:#}"))?;
    }
    Ok(())
}

/// Values of an argument that is a list of texts; none if the command has no such argument.
fn texts(matches: &ArgMatches, id: &str) -> Option<Vec<String>> {
    let values = matches.try_get_many::<String>(id).ok()?;
    Some(values.into_iter().flatten().cloned().collect())
}

fn text(matches: &ArgMatches, id: &str) -> Option<String> {
    texts(matches, id).and_then(|values| values.into_iter().next())
}

/// Commands in the text behind the options of `--help`, with the command whose help it is.
fn help_examples(command: &Command, name: &str, examples: &mut Vec<(String, String)>) {
    for help in [command.get_after_help(), command.get_after_long_help()].into_iter().flatten() {
        let help = help.to_string();
        let lines = help.lines().map(|line| match line.trim_start().strip_prefix("evpose ") {
            Some(rest) => format!("$ evpose {rest}\n"),
            None => format!("{line}\n"),
        });
        let page = format!("```console\n{}```\n", lines.collect::<String>());
        examples.extend(commands(&page).into_iter().map(|one| (name.to_owned(), one.text)));
    }
    for inner in command.get_subcommands() {
        help_examples(inner, &format!("{name} {}", inner.get_name()), examples);
    }
}

#[test]
fn every_command_of_the_pages_is_understood() {
    let mut count = 0;
    let mut lies = Vec::new();
    for (page, text) in pages() {
        for command in commands(&text) {
            for words in evpose_calls(&command.text) {
                count += 1;
                if let Err(message) = check(&words) {
                    lies.push(format!("{page}:{}: {}\n{message}", command.line, command.text));
                }
            }
        }
    }
    // A lower bound, or a change of the pages' format would make this check nothing.
    assert!(count > 120, "{count} commands");
    assert!(lies.is_empty(), "{}", lies.join("\n"));
}

#[test]
fn every_example_of_the_help_is_understood() {
    let mut examples = Vec::new();
    help_examples(&Args::command(), "evpose", &mut examples);
    // A lower bound, or a change of the help's format would make this check nothing.
    assert!(examples.len() > 60, "{}", examples.len());
    let lies: Vec<String> = examples
        .iter()
        .filter_map(|(name, example)| {
            let calls = evpose_calls(example);
            let lie = calls.iter().find_map(|words| check(words).err());
            let lie = lie.or_else(|| calls.is_empty().then(|| "calls nothing".to_owned()));
            lie.map(|message| format!("{name} --help: {example}\n{message}"))
        })
        .collect();
    assert!(lies.is_empty(), "{}", lies.join("\n"));
}

#[test]
fn a_page_that_lies_is_seen() {
    let lies = [
        "evpose simluate quick --out data",
        "evpose simulate quick --out data --no-such-flag",
        "evpose simulate quick",
        "evpose simulate quik --out data",
        "evpose train quick --data d --set training.stepz=5",
        "evpose train body-wide --set augmentation.most=5",
        "evpose infer --checkpoint hand --events rec.raw --out p.csv --mode fast",
        "evpose gap payoff gap --data d --out o --set simulation.speed=1",
        "cargo run --release -- bench infr",
    ];
    for lie in lies {
        let calls = evpose_calls(lie);
        assert_eq!(calls.len(), 1, "{lie}");
        assert!(check(&calls[0]).is_err(), "{lie}");
    }
}

#[test]
fn a_page_is_read_as_a_shell_reads_it() {
    let page = "```console\n$ evpose simulate x --set 'a=[\"b\", \"c\"]' \\\n    --out y   # a note\n\
                seen 3\n$ cat > f <<'END'\n$ not a command\nEND\n$ a && evpose info \"b#0\" | less\n```\n\
                $ outside\n";
    let found = commands(page);
    let lines: Vec<usize> = found.iter().map(|command| command.line).collect();
    assert_eq!(lines, [2, 5, 8]);
    assert!(found.iter().all(|command| command.block == 1));
    assert!(found[1].text.ends_with("\nEND") && evpose_calls(&found[1].text).is_empty());
    let words = |index: usize| evpose_calls(&found[index].text).remove(0).join("|");
    assert_eq!(words(0), "evpose|simulate|x|--set|a=[\"b\", \"c\"]|--out|y");
    assert_eq!(words(2), "evpose|info|b#0");
}

fn all_commands(command: &Command, name: &str, visit: &mut impl FnMut(&str, &Command)) {
    visit(name, command);
    for inner in command.get_subcommands() {
        all_commands(inner, &format!("{name} {}", inner.get_name()), visit);
    }
}

#[test]
fn help_names_every_embedded_config() {
    let mut command = Args::command();
    for name in ["simulate", "train"] {
        let inner = command.find_subcommand_mut(name).expect("a command");
        let help = inner.render_long_help().to_string();
        for config in configs::CONFIGS.names() {
            assert!(help.contains(&format!("`{config}`")), "{name} --help does not name {config}");
        }
    }
}

/// Lines of help are wrapped at 100 columns: one that is broken by hand as well leaves a short rest.
#[test]
fn help_is_broken_by_hand_or_wrapped_and_not_both() {
    let mut faults = Vec::new();
    all_commands(&Args::command(), "evpose", &mut |name, command| {
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let lines: Vec<&str> = help.lines().collect();
        for (k, line) in lines.iter().enumerate().filter(|(_, line)| line.chars().count() > 100) {
            let is_prose = |line: &&&str| !line.is_empty() && !line.starts_with(' ');
            let is_broken = lines.get(k + 1).filter(is_prose).is_some();
            if is_broken || line.trim_start().starts_with("evpose ") {
                faults.push(format!("{name} --help: {line}"));
            }
        }
    });
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
