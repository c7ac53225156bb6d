//! `cargo xtask circles`: refuses large circles of imports between the files of a crate.
//!
//! A file imports another if its code, tests apart, names an item that the other defines, in a
//! `use` or by a path. Re-exports are followed to the definition and are no imports themselves: a
//! `lib.rs` that offers everything does not tie a crate together. What a file takes from the file
//! that declares it as a module does not count either: a registry may list its entries and define
//! the type of them.

mod components;
mod module;
mod resolve;

use std::path::Path;

use anyhow::{Result, bail};

use crate::files;
use resolve::CrateFiles;

/// Files that may import each other in a circle. More of them can only be understood, compiled in
/// the head and moved together.
const MAX_CIRCLE: usize = 4;

/// Prints the largest circle of each crate, and every circle of the crates that are named.
///
/// # Errors
/// If a circle is larger than [`MAX_CIRCLE`], or a file cannot be read.
pub(crate) fn run(args: &[String], say: fn(&str)) -> Result<()> {
    let mut refused = 0;
    say("files  largest circle  crate");
    for root in roots(&files::tracked()?) {
        let place = files::place(&root);
        let is_named = args.iter().any(|arg| place.ends_with(&format!("/{arg}")) || *arg == place);
        if !args.is_empty() && !is_named {
            continue;
        }
        let tree = CrateFiles::read(Path::new(&root))?;
        let imports = tree.imports();
        let circles = components::circles(tree.paths.len(), &imports);
        let largest = circles.iter().map(Vec::len).max().unwrap_or(0);
        say(&format!("{:>5}  {largest:>14}  {root}", tree.paths.len()));
        for circle in circles.iter().filter(|circle| is_named || circle.len() > MAX_CIRCLE) {
            refused += usize::from(circle.len() > MAX_CIRCLE);
            say(&format!("  {} files import each other:", circle.len()));
            for ((from, to), names) in &imports {
                if circle.contains(from) && circle.contains(to) {
                    let names: Vec<&str> = names.iter().map(String::as_str).collect();
                    let (from, to) = (&tree.paths[*from], &tree.paths[*to]);
                    say(&format!(
                        "    {} -> {}: {}",
                        from.display(),
                        to.display(),
                        names.join(", ")
                    ));
                }
            }
        }
    }
    // All circles are printed before the run fails.
    if refused > 0 {
        bail!("{refused} circles of more than {MAX_CIRCLE} files");
    }
    Ok(())
}

/// Root files of all crates.
fn roots(tracked: &[String]) -> Vec<String> {
    let is_root = |path: &&String| {
        let mut behind = path.split('/').skip_while(|part| *part != "src").skip(1);
        matches!((behind.next(), behind.next()), (Some("lib.rs" | "main.rs"), None))
    };
    // The fuzz targets lie outside the workspace.
    tracked.iter().filter(is_root).filter(|path| !path.starts_with("fuzz")).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_the_first_files_of_crates() {
        let tracked = ["crates/io/src/lib.rs", "crates/io/src/evt/lib.rs", "src/main.rs"];
        let tracked =
            [&tracked[..], &["benchmarks/gap/pixel/src/lib.rs", "tests/integration/main.rs"]]
                .concat();
        let tracked: Vec<String> = tracked.into_iter().map(str::to_owned).collect();
        let expected = ["crates/io/src/lib.rs", "src/main.rs", "benchmarks/gap/pixel/src/lib.rs"];
        assert_eq!(roots(&tracked), expected);
    }
}
