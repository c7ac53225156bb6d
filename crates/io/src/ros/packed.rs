//! A file of a folder that the recorder packed as a whole: it is unpacked while it is read, so that of a
//! long recording one file at a time is in memory.

use std::path::PathBuf;

use super::file::{Fault, MessageFile, MessageVisitor, NextUnit, Topic};
use crate::source::unpacked;
use crate::{Input, IoError};

/// A packed file of messages.
pub(super) struct Packed {
    path: PathBuf,
    kind: &'static str,
    begin: u64,
    /// None while another file is read.
    file: Option<Box<dyn MessageFile>>,
}

impl Packed {
    pub(super) fn new(path: PathBuf) -> Self {
        Self { path, kind: "packed file of ROS", begin: 0, file: None }
    }

    fn unpack(&self) -> Result<Box<dyn MessageFile>, Fault> {
        let unpacked = Input::file(&self.path).and_then(unpacked).and_then(super::message_file);
        unpacked.map_err(|error| match error {
            IoError::File { source, .. } => Fault::Read(source),
            IoError::Damaged { byte, reason, .. } => Fault::Damage { byte, reason },
            other => Fault::Stranger(other.to_string().into()),
        })
    }
}

impl MessageFile for Packed {
    fn kind(&self) -> &'static str {
        self.kind
    }

    fn topics(&mut self) -> (Vec<Topic>, Option<Fault>) {
        match self.unpack() {
            Ok(mut file) => {
                (self.kind, self.begin) = (file.kind(), file.begin());
                file.topics()
            }
            Err(fault) => (Vec::new(), Some(fault)),
        }
    }

    fn begin(&self) -> u64 {
        self.begin
    }

    fn unit(&mut self, at: u64, ids: &[u32], take: &mut MessageVisitor<'_>) -> NextUnit {
        let mut file = match self.file.take() {
            Some(file) => file,
            None => {
                let mut file = self.unpack()?;
                // A database finds the pages of its messages on the way.
                file.topics();
                file
            }
        };
        let next = file.unit(at, ids, take)?;
        // Behind its last unit, its memory is free for the next file.
        self.file = next.map(|_| file);
        Ok(next)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::{OpenOptions, Restarts, open_as};

    #[test]
    fn packed_files_of_a_folder_are_unpacked_while_they_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let root = env!("CARGO_MANIFEST_DIR");
        let bytes =
            fs::read(format!("{root}/tests/golden/ros/evt3-sqlite/evt3-sqlite.db3")).unwrap();
        let bytes = zrip::compress(&bytes, 3).unwrap();
        let names = ["bag_0.db3.zstd", "bag_1.db3.zstd"];
        for name in names {
            fs::write(folder.path().join(name), &bytes).unwrap();
        }
        let [first, second] = names.map(|name| format!("    - {name}\n"));
        let metadata = format!("bag:\n  relative_file_paths:\n{first}{second}");
        fs::write(folder.path().join("metadata.yaml"), metadata).unwrap();
        let sorted = OpenOptions { restarts: Restarts::Sort, ..OpenOptions::default() };
        assert_eq!(open_as(folder.path(), &sorted).unwrap().stream.len(), 1200);

        let path = folder.path().join(names[1]);
        let mut packed = Packed::new(path.clone());
        let (topics, fault) = packed.topics();
        assert!(fault.is_none() && packed.file.is_none());
        let events = topics.iter().find(|topic| topic.name == "/cam/events").unwrap();
        let (mut at, mut messages, mut is_held) = (Some(packed.begin()), 0, Vec::new());
        while let Some(here) = at {
            let mut count = |_: &[u8]| {
                messages += 1;
                Ok(())
            };
            at = packed.unit(here, &events.ids, &mut count).map_err(|_| ()).unwrap();
            is_held.push(packed.file.is_some());
        }
        assert_eq!((messages, is_held.pop()), (events.messages, Some(false)));
        assert!(!is_held.is_empty() && is_held.iter().all(|held| *held));

        fs::write(&path, &bytes[..bytes.len() - 7]).unwrap();
        let error = open_as(folder.path(), &sorted).unwrap_err().to_string();
        assert!(error.contains("bag_1.db3.zstd") && error.contains("Zstandard"), "{error}");
    }
}
