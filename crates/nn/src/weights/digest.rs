//! The SHA-256 of a checkpoint, at the end of its file.
//!
//! A file is Burn's container, [`TAG`] and 64 hexadecimal digits: the digest of all bytes before the tag. Burn's
//! readers ignore what follows the last tensor, so that they open these files too. A file without a digest opens if
//! it is one of [`SHIPPED`], or if a `SHA256SUMS` in its directory has a line of its name and its digest.
//! Every opening checks it: nothing is remembered of it.

use std::path::Path;

use burn::tensor::Bytes;
use sha2::{Digest as _, Sha256};

use super::mapped::map;
use crate::NnError;

/// Text before the digits.
const TAG: &[u8] = b"\nsha256 ";
const LENGTH: usize = TAG.len() + 64;
/// Lists of digests, as `sha256sum` writes them, of files that carry none.
const SUMS: &str = "SHA256SUMS";

/// The four networks that shipped before checkpoints had a digest.
const SHIPPED: [&str; 4] = [
    "fd5a58ac5318fbe7ea1ce8146b6eabad66065b5dffde93ce15fdc3c3ddf63199",
    "6c7f1e8d31cc5a02e921da0f6c34e7f881a2528aa810405a33a5ad2baad82a45",
    "2c4d0f2ffcfea0d73c34423970dc2e4e14661780e84c37671ea257dbd761acde",
    "eeaf614159295510d6ac8f5b3666dcef48bed4e8ba995c01163356dd7ed03727",
];

/// The bytes of a container with their digest.
pub fn with_digest(container: &[u8]) -> Vec<u8> {
    [container, TAG, sha256(container).as_bytes()].concat()
}

/// The bytes of the file at `path`, mapped where the system can, once their digest is found to be right.
///
/// # Errors
/// [`NnError::Io`] if it cannot be read, [`NnError::Damaged`] if its digest is another, or if it has none and
/// none is known of it.
pub fn read_checked(path: &Path) -> Result<Bytes, NnError> {
    let bytes = map(path).map_err(|source| NnError::Io { path: path.to_owned(), source })?;
    let damaged = |reason: String| NnError::Damaged { path: path.to_owned(), reason };
    let stated = bytes.len().checked_sub(LENGTH).and_then(|end| {
        let digits = bytes[end..].strip_prefix(TAG)?;
        Some((end, digits))
    });
    match stated {
        Some((end, digits)) if sha256(&bytes[..end]).as_bytes() == digits => Ok(bytes),
        Some(_) => {
            Err(damaged("its contents are not those that its SHA-256 was made of".to_owned()))
        }
        None if is_vouched_for(path, &sha256(&bytes)) => Ok(bytes),
        None => Err(damaged(format!(
            "it does not end with its SHA-256: its end is lost, or it was written before checkpoints had one. If it \
             is intact, say so with `sha256sum '{}' >> {SUMS}` in its directory",
            path.file_name().unwrap_or_default().display()
        ))),
    }
}

/// Whether a digest is known of a file that carries none.
fn is_vouched_for(path: &Path, digest: &str) -> bool {
    // A list that cannot be read vouches for nothing; names in it may be of any bytes.
    let sums = || std::fs::read(path.with_file_name(SUMS)).unwrap_or_default();
    let is_of_this = |line: &str| {
        let (stated, name) = line.split_once(' ')?;
        // A blank or, of binary mode, a star; the folder may be named.
        let name = name.strip_prefix([' ', '*'])?;
        let name = name.strip_prefix("./").unwrap_or(name);
        Some(stated == digest && path.file_name()?.to_string_lossy() == name)
    };
    SHIPPED.contains(&digest)
        || String::from_utf8_lossy(&sums()).lines().any(|line| is_of_this(line) == Some(true))
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_flip_of_any_bit_and_no_cut_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.bpk");
        let whole = with_digest(b"tensors and metadata");
        let read = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read_checked(&path)
        };
        assert_eq!(&*read(&whole).unwrap(), whole);
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let error = read(&flipped).unwrap_err().to_string();
            assert!(error.contains("model.bpk: damaged: "), "{bit}: {error}");
        }
        assert!((0..whole.len()).all(|length| read(&whole[..length]).is_err()));
        assert!(read(&[&whole[..], b"\n"].concat()).is_err());
    }

    #[test]
    fn a_list_beside_a_file_without_digest_vouches_for_it_alone() {
        let folder = tempfile::tempdir().unwrap();
        let [path, other] = ["old.bpk", "other.bpk"].map(|name| folder.path().join(name));
        std::fs::write(&path, "abc").unwrap();
        let message = read_checked(&path).unwrap_err().to_string();
        assert!(message.contains("`sha256sum 'old.bpk' >> SHA256SUMS`"), "{message}");
        // FIPS 180-4's example.
        let digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        std::fs::write(folder.path().join(SUMS), format!("{digest}  old.bpk\n")).unwrap();
        assert_eq!(&*read_checked(&path).unwrap(), b"abc");
        // Binary mode, by a path, among names of other bytes.
        let list = [b"0 \xff\n", format!("{digest} *./old.bpk\n").as_bytes()].concat();
        std::fs::write(folder.path().join(SUMS), list).unwrap();
        assert_eq!(&*read_checked(&path).unwrap(), b"abc");
        std::fs::write(&other, "abc").unwrap();
        assert!(read_checked(&other).is_err());
        std::fs::write(&path, "abd").unwrap();
        assert!(read_checked(&path).is_err());
    }
}
