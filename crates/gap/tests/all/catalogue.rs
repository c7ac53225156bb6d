//! The search knows the effects of the registry by what their entries say: no name of one is written in
//! its code.

use std::fs;
use std::path::{Path, PathBuf};

use evpose_sensor::STAGES;

#[test]
fn no_code_of_the_search_spells_the_name_of_an_effect() {
    let mut spelt = Vec::new();
    for path in sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
        // The tables of what the search must know of them, which are checked against the registry; a
        // stage of formulas is called as the effect that acts there.
        // Nothing is searched in `camera`: it writes a sensor of the quantities in its own table.
        let is_table = path.ends_with("search_spec/effects.rs")
            || path.ends_with("search/formula_terms.rs")
            || path.parent().is_some_and(|folder| folder.ends_with("camera"));
        if is_table {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        for literal in literals(without_tests(&text)) {
            if STAGES.iter().any(|spec| spec.name == literal) {
                spelt.push(format!("{}: {literal:?}", path.display()));
            }
        }
    }
    assert!(spelt.is_empty(), "what it knows of them belongs in the table:\n{}", spelt.join("\n"));
}

/// Files of code, without those of tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_of_tests =
        |path: &Path| path.file_stem().is_some_and(|stem| stem == "tests" || stem == "testing");
    let found = entries.flat_map(|path| match path.is_dir() {
        true => sources(&path),
        false if is_of_tests(&path) => Vec::new(),
        false => vec![path],
    });
    found.collect()
}

/// A file up to its module of tests, which is the last item.
fn without_tests(text: &str) -> &str {
    text.split_once("#[cfg(test)]\nmod tests {").map_or(text, |(code, _)| code)
}

/// String literals of Rust code, outside of comments.
fn literals(code: &str) -> Vec<String> {
    let (mut found, mut rest) = (Vec::new(), code);
    while let Some(at) = rest.find(['"', '/', '\'']) {
        let from = &rest[at..];
        rest = if from.starts_with("//") {
            from.split_once('\n').map_or("", |(_, behind)| behind)
        } else if let Some(inside) = from.strip_prefix('"') {
            let mut is_escaped = false;
            let end = inside.find(|c| {
                let is_end = c == '"' && !is_escaped;
                is_escaped = c == '\\' && !is_escaped;
                is_end
            });
            let end = end.unwrap();
            found.push(inside[..end].to_owned());
            &inside[end + 1..]
        } else if from.starts_with("'\"'") || from.starts_with("'/'") {
            &from[3..]
        } else {
            &from[1..]
        };
    }
    found
}

#[test]
fn literals_are_found_and_comments_are_not() {
    let code =
        "let a = \"one\"; // not \"two\"\nf('\"', \"th\\\"ree\", b'/');\n/// \"four\"\n\"five\"";
    assert_eq!(literals(code), ["one", "th\\\"ree", "five"]);
    assert_eq!(without_tests("a\n#[cfg(test)]\nmod tests {\nb"), "a\n");
}
