//! The stored counts: `tests/instructions/counts.toml`.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

/// Under which counts are comparable.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Conditions {
    pub(crate) compiler: String,
    /// Vector instructions under valgrind, which does not know AVX-512.
    pub(crate) level: String,
    /// Whether crates were compiled incrementally: in more units, between which less is inlined.
    pub(crate) is_incremental: bool,
    pub(crate) system: String,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct StoredCounts {
    pub(crate) conditions: Conditions,
    pub(crate) counts: BTreeMap<String, u64>,
}

impl StoredCounts {
    pub(crate) fn read() -> Result<Self> {
        let text = std::fs::read_to_string(path()).context("reading the stored counts")?;
        toml::from_str(&text).context("the stored counts")
    }

    pub(crate) fn write(&self) -> Result<()> {
        std::fs::write(path(), toml::to_string(self)?).context("writing the counts")
    }
}

fn path() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/instructions/counts.toml")
}
