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
    use std::path::Path;

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
