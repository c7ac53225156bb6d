//! Recordings of ROS: messages by topics, of which one holds events, and others may hold images.
//!
//! | file | messages |
//! |---|---|
//! | MCAP | of ROS 2 (CDR), or of ROS 1 |
//! | bag of ROS 1 | without gaps, in chunks packed by LZ4 or bzip2 |
//! | SQLite database of ROS 2 | CDR |
//! | folder of ROS 2 with `metadata.yaml` | of the files that it names, which follow each other |
//!
//! Events are of `event_camera_msgs/EventPacket` (encodings `evt3`, `mono`, `libcaer`, `libcaer_cmp`),
//! `dvs_msgs/EventArray` or `prophesee_event_msgs/EventArray`. Times are those of the sensor as messages
//! have them; where they are of the calendar, they count from the first event.

mod bag;
mod fields;
mod file;
pub(crate) mod folder;
mod images;
mod mcap;
mod message;
mod packed;
mod place;
mod source;
mod sqlite;
mod writer;

use file::{MessageFile, NamedFile};
pub use images::{Images, images};
use packed::Packed;
use source::RosSource;

use crate::open::{Format, no_labels};
use crate::{EventSource, Input, IoError, OpenOptions};

/// The registry's entry of MCAP.
pub(crate) const MCAP: Format = Format {
    name: "mcap",
    summary: "MCAP of ROS 2 and ROS 1: EventPacket (evt3, mono, libcaer) and EventArray",
    endings: &[".mcap"],
    probe: |head| head.starts_with(mcap::MAGIC),
    open,
    create: Some(writer::create),
    labels: no_labels,
};

/// The registry's entry of bags of ROS 1.
pub(crate) const BAG: Format = Format {
    name: "rosbag",
    summary: "ROS 1 bags with EventPacket or EventArray",
    endings: &[".bag"],
    probe: |head| head.starts_with(bag::MAGIC),
    open,
    create: None,
    labels: no_labels,
};

/// The registry's entry of bags of ROS 2 in SQLite.
pub(crate) const SQLITE: Format = Format {
    name: "rosbag2",
    summary: "ROS 2 bags in SQLite with EventPacket or EventArray",
    endings: &[".db3"],
    probe: |head| head.starts_with(sqlite::MAGIC),
    open,
    create: None,
    labels: no_labels,
};

/// Names of the formats of ROS.
pub const NAMES: [&str; 3] = [MCAP.name, BAG.name, SQLITE.name];

fn open(input: Input, options: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    Ok(Box::new(open_source(input, options)?))
}

fn open_source(input: Input, options: &OpenOptions) -> Result<RosSource, IoError> {
    let path = input.path.clone();
    RosSource::open(open_files(input)?, &path, options)
}

/// Opens a file, or those of a folder.
fn open_files(input: Input) -> Result<Vec<NamedFile>, IoError> {
    let path = input.path.clone();
    // The first file of a folder is open and unpacked, under the name of the folder.
    let of_folder = if path.is_dir() { folder::files(&path)? } else { Vec::new() };
    let name = of_folder.first().unwrap_or(&path).clone();
    let mut files = vec![(name.clone(), message_file(Input { path: name, ..input })?)];
    for path in of_folder.into_iter().skip(1) {
        let mut input = Input::file(&path)?;
        let is_packed = !is_known(&input.head(sqlite::MAGIC.len())?);
        let file =
            if is_packed { Box::new(Packed::new(path.clone())) } else { message_file(input)? };
        files.push((path, file));
    }
    Ok(files)
}

fn is_known(head: &[u8]) -> bool {
    [mcap::MAGIC, bag::MAGIC, sqlite::MAGIC].iter().any(|magic| head.starts_with(magic))
}

/// A file by what it begins with.
fn message_file(mut input: Input) -> Result<Box<dyn MessageFile>, IoError> {
    let head = input.head(sqlite::MAGIC.len())?;
    Ok(if head.starts_with(mcap::MAGIC) {
        Box::new(mcap::Mcap::new(input))
    } else if head.starts_with(bag::MAGIC) {
        Box::new(bag::Bag::new(input))
    } else {
        folder::check_merged(&input.path)?;
        Box::new(sqlite::Sqlite::new(input))
    })
}

#[cfg(test)]
mod made;
#[cfg(test)]
mod tests;
