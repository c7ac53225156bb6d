//! Helpers that tests of files share.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Names and bytes of the files of a folder.
pub(crate) fn tree(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    files.map(|path| (name(&path), fs::read(&path).unwrap())).collect()
}
