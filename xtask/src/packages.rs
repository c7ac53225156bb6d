//! `cargo xtask setup`: installs programs that tests run, where Debian's packages can be.
//!
//! Elsewhere the tests are ignored, with the reason.

use std::process::{Command, Stdio};

/// Packages, each with what is tested with it.
const PACKAGES: [(&str, &str); 4] = [
    ("chromium", "the page of `evpose live`"),
    ("libvulkan1", "networks on wgpu"),
    ("mesa-vulkan-drivers", "networks on wgpu, without a GPU"),
    ("valgrind", "counts of instructions"),
];

/// Installs what is missing, and says what could not be.
pub(crate) fn install(say: fn(&str)) {
    let missing: Vec<&str> =
        PACKAGES.iter().map(|(name, _)| *name).filter(|name| !is_installed(name)).collect();
    if missing.is_empty() {
        return;
    }
    say(&format!("== installing {}", missing.join(", ")));
    // A silent mirror must not hold up the tests, and another apt may hold the lock.
    let options = ["-qq", "-o", "Acquire::http::Timeout=60", "-o", "DPkg::Lock::Timeout=120"];
    let apt = |args: &[&str]| {
        let mut apt = Command::new("apt-get");
        apt.args(options).args(args).env("DEBIAN_FRONTEND", "noninteractive");
        apt.stdin(Stdio::null()).stdout(Stdio::null());
        apt.status().is_ok_and(|status| status.success())
    };
    // An old list may do.
    apt(&["update"]);
    for (name, tested) in PACKAGES.iter().filter(|(name, _)| missing.contains(name)) {
        if !apt(&["install", "--yes", "--no-install-recommends", name]) {
            say(&format!("{name} cannot be installed: tests of {tested} may be ignored"));
        }
    }
}

fn is_installed(package: &str) -> bool {
    let mut query = Command::new("dpkg-query");
    query.args(["--show", "--showformat=${db:Status-Status}", package]).stderr(Stdio::null());
    query.output().is_ok_and(|output| output.stdout == b"installed")
}
