//! Drivers of GPUs on Linux, by their files: what is missing where no device is.

use std::path::{Path, PathBuf};

/// Folders of shared libraries, beside those of `LD_LIBRARY_PATH`.
const LIBRARIES: [&str; 9] = [
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib64",
    "/usr/lib",
    "/usr/local/lib",
    "/lib/x86_64-linux-gnu",
    "/lib64",
    "/lib",
    "/usr/lib/wsl/lib",
];

/// Folders of the files in which Vulkan's drivers describe themselves.
#[cfg(feature = "wgpu")]
const VULKAN_DRIVERS: [&str; 3] =
    ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];

/// Whether a shared library is in one of the usual folders.
pub(super) fn has_library(name: &str) -> bool {
    let given = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let given: Vec<PathBuf> = std::env::split_paths(&given).collect();
    let mut folders = LIBRARIES.iter().map(Path::new).chain(given.iter().map(PathBuf::as_path));
    folders.any(|folder| folder.join(name).exists())
}

/// The reason why Vulkan has no device, and the remedy.
#[cfg(feature = "wgpu")]
pub(super) fn missing_vulkan() -> String {
    const LOADER: &str = "libvulkan.so.1";
    const REMEDY: &str = "install the GPU's driver, or mesa-vulkan-drivers (Debian's name), which \
                          also computes on the CPU";
    // In the order in which a start can fail: loader, variables, drivers.
    if !has_library(LOADER) {
        return format!("no Vulkan loader ({LOADER}): {REMEDY}");
    }
    // The loader reads these variables instead of its folders.
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        if let Some(files) = std::env::var_os(variable) {
            return format!(
                "the Vulkan drivers of ${variable} ({}) have no device",
                files.display()
            );
        }
    }
    let drivers: Vec<String> = VULKAN_DRIVERS.iter().flat_map(|folder| files(folder)).collect();
    if drivers.is_empty() {
        let folders = VULKAN_DRIVERS.join(", ");
        return format!("the Vulkan loader has no driver in {folders}: {REMEDY}");
    }
    let drivers = drivers.join(", ");
    format!(
        "the Vulkan drivers {drivers} have no device here; `vulkaninfo --summary` says more, and \
         mesa-vulkan-drivers (Debian's name) also computes on the CPU"
    )
}

/// Names of the files in a folder, sorted.
#[cfg(feature = "wgpu")]
fn files(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
