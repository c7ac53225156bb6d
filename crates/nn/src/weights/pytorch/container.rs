//! The two containers of `torch.save`: a pickle that describes tensors, and their storages.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::{Cursor, Read};

use evpose_containers::pickle::{Pickle, PickleValue};
use zip::ZipArchive;

use super::view::element_sizes;
use crate::weights::strict::TensorError;

/// Begins a zip archive.
const ZIP_MAGIC: &[u8] = b"PK\x03\x04";
/// The integer that is the first pickle of a file of PyTorch 1.5 and earlier, little-endian.
const LEGACY_MAGIC: [u8; 10] = [0x6c, 0xfc, 0x9c, 0x46, 0xf9, 0x20, 0x6a, 0xa8, 0x50, 0x19];

/// Refused: bytes would have to be swapped, and no such file is known.
const BIG_ENDIAN: &str = "written on a big-endian machine";

/// A file of `torch.save`: its pickle and the storages of its tensors.
pub(super) struct Container {
    /// The saved object, with persistent ids in place of storages.
    pub(super) pickle: Pickle,
    storages: BTreeMap<String, Vec<u8>>,
}

impl Container {
    /// Reads either container.
    ///
    /// # Errors
    /// A description of the damage.
    pub(super) fn read(bytes: Vec<u8>) -> Result<Self, TensorError> {
        if bytes.starts_with(ZIP_MAGIC) { Self::zip(bytes) } else { Self::legacy(&bytes) }
    }

    /// `NAME/data.pkl` and, for each storage, `NAME/data/KEY`.
    fn zip(bytes: Vec<u8>) -> Result<Self, TensorError> {
        // torch.save does not compress: entries larger than their archive are a bomb.
        // Shared by all entries, as many small bombs are one large.
        let mut budget = bytes.len() as u64;
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(TensorError::of)?;
        let names = archive.file_names().map(|name| name.map(Cow::into_owned));
        let names: Vec<String> = names.collect::<Result<_, _>>().map_err(TensorError::of)?;
        let mut read = |name: &str| -> Result<Vec<u8>, TensorError> {
            let damaged = |error: &dyn Display| TensorError::of(format!("{name}: {error}"));
            let entry = archive.by_name(name).map_err(|error| damaged(&error))?;
            let mut content = Vec::new();
            // One byte more than allowed shows that there was more.
            let read = entry.take(budget + 1).read_to_end(&mut content);
            let read = read.map_err(|error| damaged(&error))? as u64;
            let rest = budget.checked_sub(read);
            let bomb = || TensorError::of(format!("{name} unpacks to more than the archive"));
            budget = rest.ok_or_else(bomb)?;
            Ok(content)
        };
        // The root folder may have any name.
        let root = names.iter().find_map(|name| name.strip_suffix("data.pkl"));
        let root = root.ok_or("a zip archive without data.pkl")?.to_owned();
        // Archives of older PyTorch versions do not state the byte order.
        let order = format!("{root}byteorder");
        if names.contains(&order) && read(&order)? != b"little" {
            return Err(BIG_ENDIAN.into());
        }
        let pickle = pickle(&read(&format!("{root}data.pkl"))?, 0)?;
        let prefix = format!("{root}data/");
        let mut storages = BTreeMap::new();
        for name in &names {
            if let Some(key) = name.strip_prefix(&prefix) {
                storages.insert(key.to_owned(), read(name)?);
            }
        }
        Ok(Self { pickle, storages })
    }

    /// Five pickles (a magic number, the protocol, the machine, the object, the storage keys), then
    /// for each key the count of elements and the elements.
    fn legacy(bytes: &[u8]) -> Result<Self, TensorError> {
        let magic = Pickle::read(bytes, 0)
            .map_err(|error| TensorError::of(format!("no PyTorch file: {error}")))?;
        if !matches!(magic.node(magic.root()), PickleValue::LongInt(magic) if *magic == LEGACY_MAGIC)
        {
            return Err("a pickle that torch.save did not write".into());
        }
        let protocol = pickle(bytes, magic.end())?;
        let machine = pickle(bytes, protocol.end())?;
        // Elements are read as they are stored, so the byte order has to be that of this reader.
        let order = machine.get(machine.root(), "little_endian");
        if order.is_some_and(|order| *machine.node(order) != PickleValue::Bool(true)) {
            return Err(BIG_ENDIAN.into());
        }
        let saved = pickle(bytes, machine.end())?;
        let keys = pickle(bytes, saved.end())?;
        // The storages state counts of elements; their types are only in the pickle.
        let sizes = element_sizes(&saved);
        let mut storages = BTreeMap::new();
        let mut at = keys.end();
        for &key in keys.sequence(keys.root()).ok_or("no list of storages")? {
            let key = keys.text(key).ok_or("a storage without a name")?;
            let size = sizes.get(key);
            let size =
                size.ok_or_else(|| TensorError::of(format!("storage {key} of unknown type")))?;
            let end = bytes.len();
            let cut = || TensorError::of(format!("the file ends at byte {end} in storage {key}"));
            let (head, rest) = bytes[at..].split_first_chunk().ok_or_else(cut)?;
            let length = usize::try_from(i64::from_le_bytes(*head)).ok();
            // A damaged count must not ask for more than the file has.
            let length = length.and_then(|count| count.checked_mul(*size)).ok_or_else(cut)?;
            let content = rest.get(..length).ok_or_else(cut)?;
            storages.insert(key.to_owned(), content.to_vec());
            at += head.len() + length;
        }
        Ok(Self { pickle: saved, storages })
    }

    /// The bytes of a storage.
    pub(super) fn storage(&self, key: &str) -> Option<&[u8]> {
        self.storages.get(key).map(Vec::as_slice)
    }
}

fn pickle(bytes: &[u8], start: usize) -> Result<Pickle, TensorError> {
    Pickle::read(bytes, start).map_err(TensorError::of)
}
