//! Photographs of persons as networks for events are first trained on: one pipeline for every set.
//!
//! The reader of a set ([`mpii`](crate::mpii), [`lsp`](crate::lsp)) hands its annotations over; each
//! person is cut out of its photograph, in the style of an EROS or in grey ([`StillStyle`]), and
//! one annotation file and a report are written ([`Converted`], [`SkipReason`]).

mod convert;
mod image_file;
mod label;
mod options;
mod person;
mod report;
mod sides;
mod window;

pub(crate) use convert::{StillSet, convert};
pub(crate) use image_file::write as write_image;
pub use options::{CropFormat, StillOptions, StillStyle};
pub(crate) use person::{Joint, Person, PersonFault, Photograph};
pub use report::{Converted, SkipReason, Skipped};
pub(crate) use sides::leave_out_exchanged;
