//! Networks that come with the program, by name.

use std::path::{Path, PathBuf};

/// Their directory.
const CHECKPOINTS: &str = "checkpoints";

/// The file of a checkpoint: `hand` and the like are names in the `checkpoints` directory, here or
/// above the program; everything else is a path.
pub fn checkpoint_path(given: &Path) -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    let here = Path::new("");
    path_below(given, std::iter::once(here).chain(program.ancestors().skip(1)))
}

fn path_below<'a>(given: &Path, directories: impl Iterator<Item = &'a Path>) -> PathBuf {
    let is_name = given.components().count() == 1 && given.extension().is_none();
    if given.exists() || !is_name {
        return given.to_owned();
    }
    let file = Path::new(CHECKPOINTS).join(given).with_extension("bpk");
    let mut files = directories.map(|directory| directory.join(&file));
    files.find(|file| file.exists()).unwrap_or_else(|| given.to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_name_is_found_above_and_a_path_stays() {
        let root = tempfile::tempdir().unwrap();
        let bin = root.path().join("target/release");
        std::fs::create_dir_all(&bin).unwrap();
        std::fs::create_dir(root.path().join(CHECKPOINTS)).unwrap();
        let shipped = root.path().join(CHECKPOINTS).join("some-network.bpk");
        std::fs::write(&shipped, "").unwrap();
        let found = |given: &str| path_below(Path::new(given), bin.ancestors());
        assert_eq!(found("some-network"), shipped);
        assert_eq!(found("no-such-network"), Path::new("no-such-network"));
        assert_eq!(found("runs/some-network"), Path::new("runs/some-network"));
        assert_eq!(found("some-network.bpk"), Path::new("some-network.bpk"));
    }
}
