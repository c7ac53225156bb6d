//! The text of the configuration files in this directory: sensors, experiments, conditions,
//! randomisation.
//!
//! They are a crate, so that every crate that embeds some of them can be packaged by itself.
//!
//! ```
//! const IDEAL: &str = evpose_configs::text("sensor/ideal.toml");
//! assert!(IDEAL.starts_with('#'));
//! ```

macro_rules! files {
    ($($path:literal,)+) => {
        /// Paths in this directory, with `/`, and contents.
        pub const FILES: &[(&str, &str)] = &[$(($path, include_str!($path)),)+];
    };
}

files! {
    "baseline/dhp19-cnn.toml",
    "baseline/lift-mono.toml",
    "body/finetune-full.toml",
    "body/finetune.toml",
    "body/pretrain-full.toml",
    "body/pretrain.toml",
    "body/studio.toml",
    "body/wide.toml",
    "condition/dark-noisy.toml",
    "condition/dark.toml",
    "condition/lit.toml",
    "condition/night.toml",
    "condition/normal.toml",
    "condition/slow.toml",
    "hand/ablation.toml",
    "hand/eventhands.toml",
    "hand/joints.toml",
    "hand/quick.toml",
    "hand/wide.toml",
    "randomisation.toml",
    "sensor/davis240c.toml",
    "sensor/davis346.toml",
    "sensor/dvs-voltmeter.toml",
    "sensor/dvxplorer.toml",
    "sensor/esim.toml",
    "sensor/eventhands.toml",
    "sensor/evk4.toml",
    "sensor/ideal.toml",
    "sensor/v2e-clean.toml",
    "sensor/v2e-noisy.toml",
}

/// The contents of a file of [`FILES`].
///
/// # Panics
/// If there is none of this path; in a constant, that is an error of the compiler.
pub const fn text(path: &str) -> &'static str {
    let mut i = 0;
    while i < FILES.len() {
        if is_same(FILES[i].0.as_bytes(), path.as_bytes()) {
            return FILES[i].1;
        }
        i += 1;
    }
    panic!("no configuration file has this path");
}

/// `==` of slices, which constants cannot call.
const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use std::fs::read_dir;
    use std::path::Path;

    use super::*;

    #[test]
    fn every_toml_file_of_a_folder_is_listed() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for (path, contents) in FILES {
            assert_eq!(text(path), *contents);
        }
        for folder in ["baseline", "body", "condition", "hand", "sensor"] {
            for entry in read_dir(root.join(folder)).unwrap() {
                let path = format!("{folder}/{}", entry.unwrap().file_name().to_str().unwrap());
                assert!(FILES.iter().any(|(listed, _)| *listed == path), "{path}");
            }
        }
    }

    #[test]
    fn a_path_is_compared_to_its_end() {
        assert!(is_same(b"a/b", b"a/b"));
        assert!(!is_same(b"a/b", b"a/bc") && !is_same(b"a/bc", b"a/b") && !is_same(b"a", b"b"));
    }
}
