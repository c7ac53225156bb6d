//! Tools and hardware that a step needs.

use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Something that not every machine has.
#[derive(Clone, Copy)]
pub(crate) enum Need {
    /// A nightly compiler beside the usual one.
    Nightly,
    /// The processor's unit for products of tiles.
    Amx,
    /// `cargo deny`, with the advisories that it fetched before.
    Deny,
    /// A variable of the environment, which names a library.
    Variable(&'static str),
}

impl Need {
    /// The reason for not running: a tool that is missing, and how to get it.
    pub(crate) fn missing(&self) -> Option<String> {
        let (is_there, what) = match self {
            Self::Nightly => {
                let mut cargo = Command::new("cargo");
                cargo.args(["+nightly", "--version"]).stdout(Stdio::null()).stderr(Stdio::null());
                let is_there = cargo.status().is_ok_and(|status| status.success());
                (is_there, "a nightly compiler: `rustup toolchain install nightly`".to_owned())
            }
            Self::Deny => {
                let mut cargo = Command::new("cargo");
                cargo.args(["deny", "--version"]).stdout(Stdio::null()).stderr(Stdio::null());
                let is_there = cargo.status().is_ok_and(|status| status.success());
                let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
                let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")));
                // The step runs offline, with what was fetched before.
                let has_advisories = home.is_some_and(|home| home.join("advisory-dbs").is_dir());
                let how = "`cargo install cargo-deny`, then `cargo deny fetch`";
                (is_there && has_advisories, format!("licences and known faults: {how}"))
            }
            Self::Amx => {
                let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
                let has = |flag: &&str| processor.split_whitespace().any(|word| word == *flag);
                let is_there = ["avx512f", "amx_int8", "amx_bf16"].iter().all(has);
                (is_there, "a processor with AMX".to_owned())
            }
            Self::Variable(name) => {
                (std::env::var_os(name).is_some(), format!("a library that ${name} names"))
            }
        };
        (!is_there).then(|| format!("needs {what}"))
    }
}
