//! SHA-256 of files, as lines that `sha256sum` writes and reads.
//!
//! # Source
//! FIPS 180-4 for the digest; GNU coreutils for the line: 64 hexadecimal digits, a space, a space
//! or an asterisk, the name.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use sha2::{Digest as _, Sha256};

use crate::SimError;

/// Bytes per read: amortises system calls and stays in the L2 cache.
const CHUNK: usize = 1 << 18;

/// Name and SHA-256 digest of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FileDigest {
    /// File name without a directory.
    pub(super) name: String,
    /// 64 lower-case hexadecimal digits.
    pub(super) sha256: String,
}

impl FileDigest {
    /// Computes the digest of `directory/name`. `progress` receives the number of bytes of each
    /// read.
    pub(super) fn compute(
        directory: &Path,
        name: &str,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Self, SimError> {
        let path = directory.join(name);
        let failed = |source| SimError::file(&path, "read", source);
        let mut file = File::open(&path).map_err(failed)?;
        // Chunk by chunk: a recording of an hour does not fit into memory.
        let (mut hasher, mut chunk) = (Sha256::new(), vec![0; CHUNK]);
        loop {
            match file.read(&mut chunk).map_err(failed)? {
                0 => break,
                bytes => {
                    hasher.update(&chunk[..bytes]);
                    progress(bytes as u64);
                }
            }
        }
        let sha256 = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { name: name.to_owned(), sha256 })
    }

    /// The line of the list, with its line feed.
    pub(super) fn line(&self) -> String {
        format!("{}  {}\n", self.sha256, self.name)
    }

    /// Parses a line without its line feed, or returns its defect.
    pub(super) fn parse(line: &str) -> Result<Self, &'static str> {
        let (sha256, rest) = line.split_at_checked(64).ok_or("shorter than a digest")?;
        if !sha256.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return Err("does not begin with 64 hexadecimal digits");
        }
        let name = rest.strip_prefix("  ").or_else(|| rest.strip_prefix(" *"));
        let name = name.ok_or("no two spaces behind the digest")?;
        // A manifest from elsewhere must not make the verification read other directories.
        let plain = Path::new(name).file_name().is_some_and(|file| file == name);
        if !plain {
            return Err("the name is not that of a file in the same directory");
        }
        Ok(Self { name: name.to_owned(), sha256: sha256.to_ascii_lowercase() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digests_are_those_of_the_standard() {
        let directory = tempfile::tempdir().unwrap();
        // FIPS 180-4's examples: one block, none, and a million times `a`, more than one chunk.
        let long = "a".repeat(1_000_000);
        for (text, sha256) in [
            ("abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"),
            ("", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"),
            (long.as_str(), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"),
        ] {
            std::fs::write(directory.path().join("x"), text).unwrap();
            let digest = FileDigest::compute(directory.path(), "x", &|_| {}).unwrap();
            assert_eq!(digest.sha256, sha256);
            assert_eq!(FileDigest::parse(digest.line().trim_end()).unwrap(), digest);
        }
    }

    #[test]
    fn lines_that_are_none_and_names_elsewhere_are_refused() {
        let digest = "0".repeat(64);
        assert_eq!(FileDigest::parse(&format!("{digest} *0001.evc")).unwrap().name, "0001.evc");
        let no_digits = "g".repeat(70);
        for line in ["", "0123  x", &no_digits, &format!("{digest} x"), &format!("{digest}  ")] {
            assert!(FileDigest::parse(line).is_err(), "{line}");
        }
        for name in ["../0001.evc", "/etc/passwd", "a/b", "..", "a/"] {
            assert!(FileDigest::parse(&format!("{digest}  {name}")).is_err(), "{name}");
        }
    }
}
