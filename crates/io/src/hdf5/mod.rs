//! HDF5 recordings: their datasets decide which of the usual layouts they have.
//!
//! * Prophesee's (Metavision): `/CD/events`, a table of `x y p t`, chunks packed by its ECF.
//! * DSEC's and others of the Robotics and Perception Group: `events/{t,x,y,p}`, times counted from
//!   `t_offset`, chunks packed by Blosc.
//! * Tables of h5py: columns of the usual names (`events/{ts,xs,ys,ps}`), one array of four columns
//!   (v2e's and eH3.6M's `events`), or one of named fields; MVSEC's and M3ED's two cameras.
//!
//! The structure of a file is read by `hdf5-reader`; chunks of events are read and unpacked here,
//! one at a time and each where it stands in the file, so that damage has a place, and so that a
//! chunk may hold fewer events than it has room for, as the last one of Prophesee's files does.
//!
//! Files are written in the layout of DSEC: columns `events/{t,x,y,p}` of chunks with a checksum, times counted
//! from `t_offset` (0 unless the clock began long before the recording), `ms_to_idx`, and the size of
//! the sensor as attributes `width` and `height`. Any program that reads HDF5 reads them.
//!
//! Without the Cargo feature `hdf5`, such files are known but neither read nor written.

#[cfg(feature = "hdf5")]
mod b2nd;
#[cfg(feature = "hdf5")]
mod blosc;
#[cfg(feature = "hdf5")]
mod blosc2;
#[cfg(feature = "hdf5")]
mod blosclz;
#[cfg(feature = "hdf5")]
mod bytes;
#[cfg(feature = "hdf5")]
mod chunk_index;
#[cfg(feature = "hdf5")]
mod ecf;
#[cfg(feature = "hdf5")]
mod filters;
#[cfg(feature = "hdf5")]
mod layout;
#[cfg(feature = "hdf5")]
mod lzf;
#[cfg(feature = "hdf5")]
mod ms_index;
#[cfg(feature = "hdf5")]
mod number;
#[cfg(feature = "hdf5")]
mod object;
#[cfg(feature = "hdf5")]
mod shuffle;
#[cfg(feature = "hdf5")]
mod source;
#[cfg(feature = "hdf5")]
mod table;
#[cfg(feature = "hdf5")]
mod writer;

#[cfg(feature = "hdf5")]
use source::open;

use crate::open::{Create, Format, no_labels};

/// How the data of every HDF5 file begin.
const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Offsets at which the signature may stand: a user block may precede it.
const PLACES: [usize; 4] = [0, 512, 1024, 2048];

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "hdf5",
    summary: "HDF5 of Prophesee (ECF), DSEC (Blosc), RVT, v2e, MVSEC and h5py; events/{t,x,y,p}",
    endings: &[".h5", ".hdf5"],
    probe: |head| {
        PLACES.iter().any(|&at| head.get(at..).is_some_and(|rest| rest.starts_with(SIGNATURE)))
    },
    open,
    create: CREATE,
    labels: no_labels,
};

#[cfg(feature = "hdf5")]
const CREATE: Option<Create> = Some(writer::create);
#[cfg(not(feature = "hdf5"))]
const CREATE: Option<Create> = None;

/// Says how to get a program that reads such files.
#[cfg(not(feature = "hdf5"))]
fn open(
    input: crate::Input,
    _: &crate::OpenOptions,
) -> Result<Box<dyn crate::EventSource>, crate::IoError> {
    let path = input.path;
    Err(crate::IoError::NeedsFeature { path, format: "HDF5", feature: "hdf5" })
}

#[cfg(test)]
mod tests;
