//! Paths and registries that pages name in code spans, as ARCHITECTURE.md does in its table of files touched.

use std::path::Path;

use crate::links::prose;

/// Folders whose paths are checked.
const FOLDERS: [&str; 7] =
    ["src/", "crates/", "configs/", "tests/", "xtask/", "examples/", "benchmarks/"];

/// Paths of a page that do not exist below `root`, and names behind the path of a file, as `STAGES` or `commands!`, that the
/// file does not hold.
pub(crate) fn absent(root: &Path, text: &str) -> Vec<String> {
    let mut absent = Vec::new();
    for (number, line) in prose(text) {
        let mut file = None;
        // Every second part between backticks is a code span.
        for span in line.split('`').skip(1).step_by(2) {
            let is_path = FOLDERS.iter().any(|folder| span.starts_with(folder));
            let is_constant = span.len() > 4 && span.chars().all(|c| c.is_uppercase() || c == '_');
            let is_there = if is_path {
                file = std::fs::read_to_string(root.join(span)).ok();
                root.join(span).exists()
            } else if is_constant || span.ends_with('!') {
                file.as_ref().is_none_or(|file| file.contains(span))
            } else {
                true
            };
            absent.extend((!is_there).then(|| format!("{number}: no `{span}`")));
        }
    }
    absent
}

#[cfg(test)]
mod tests {
    use std::fs::read_to_string;
    use std::path::Path;
    use std::process::Command;

    use regex::Regex;

    /// An entry of each kind, by what it is called in code: its module, its name in the registry, its type.
    const ENTRIES: [(&str, &str); 12] = [
        ("effect", "vignetting"),
        ("representation", "sae"),
        ("cleaner", "deflicker"),
        ("event format", "nmnist"),
        ("pose format", "hpe_core|hpe-core"),
        ("label format", "mpii_json|mpii-json"),
        ("backbone", "vgg|vgg11_bn"),
        ("probe", "log_intensity_step|LogIntensityStep"),
        ("condition", "night"),
        ("camera preset", "dvs-voltmeter"),
        ("command", "quantize"),
        ("benchmark", "sim"),
    ];
    /// Ends of the names of files that are tests.
    const TESTS: [&str; 3] = ["tests.rs", "laws.rs", "example.rs"];

    /// A file of Rust without comments and tests; nothing of others.
    fn code(path: &str) -> String {
        let text = read_to_string(Path::new("..").join(path)).unwrap_or_default();
        let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        let is_code = |line: &&str| path.ends_with(".rs") && !line.trim_start().starts_with("//");
        text.lines().filter(is_code).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn the_table_of_files_touched_has_their_counts() {
        let listed = ["-C", "..", "ls-files", "src", "crates", "configs"];
        let listed = Command::new("git").args(listed).output().unwrap().stdout;
        let listed = String::from_utf8(listed).unwrap();
        let is_test =
            |path: &&str| path.contains("/tests/") || TESTS.iter().any(|t| path.ends_with(t));
        let sources: Vec<_> =
            listed.lines().filter(|path| !is_test(path)).map(|path| (path, code(path))).collect();
        let page = read_to_string("../ARCHITECTURE.md").unwrap();
        for (kind, names) in ENTRIES {
            let own = Regex::new(&format!(r"/({names})(/mod)?\.(rs|toml)$")).unwrap();
            let used = if names.contains(char::is_uppercase) {
                format!(r"\b({names})\b")
            } else {
                format!(r#"\bmod ({names});|\b({names})::|"({names})"|/({names})\.toml""#)
            };
            let used = Regex::new(&used).unwrap();
            let knows = |(path, code): &&(&str, String)| own.is_match(path) || used.is_match(code);
            let files: Vec<_> = sources.iter().filter(knows).map(|(path, _)| path).collect();
            let row = page.lines().find_map(|line| line.strip_prefix(&format!("| {kind} | ")));
            let stated = row.unwrap().split(' ').next().unwrap();
            assert_eq!(stated, files.len().to_string(), "{kind}: {files:#?}");
        }
    }

    #[test]
    fn paths_and_names_that_are_not_there_are_seen() {
        // Tests run in the folder of the package.
        let absent = |text: &str| super::absent(Path::new(".."), text);
        assert_eq!(absent("`none/none.rs`, `crates/none`: `STAGES`"), ["1: no `crates/none`"]);
        let registry = "`crates/sensor/src/registry.rs`: ";
        assert!(absent(&format!("{registry}`STAGES`")).is_empty());
        assert_eq!(absent(&format!("{registry}`STAGE_NONE`")), ["1: no `STAGE_NONE`"]);
    }
}
