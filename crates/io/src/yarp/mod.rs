//! Logs of YARP's data dumper, as event-driven, bimvee and hpe-core write and read them.
//!
//! A `data.log` is text, one bottle a line: its number, its time in seconds, a name, and its
//! content.
//!
//! * `12 0.024000 AE (300000 4721 300012 8825 …)`: pairs of a time in ticks and a word, in decimal.
//!   Bottles `LAE` have a third value for each event, a label, and `FLOW` a third and a fourth, a
//!   velocity; these are skipped.
//! * `12 0.024000 AE 1998 "…"`: the same in binary, behind the length of the bottle in microseconds
//!   (some programs leave it out), four bytes a value and the lowest first, in quotes; `\0`, `\n`,
//!   `\r`, `\"` and `\\` stand for a byte each. Words may come without times, and events have the
//!   time of their bottle then. They are taken to come with times where every second value of the
//!   first bottles ascends.
//! * Bottles of other names (skin, motion, sound, frames) are skipped and counted; those of
//!   skeletons, `SKLT`, are read by [`read_skeletons`].
//!
//! A `binaryevents.log` is nothing but pairs of four bytes each, time and word, the lowest byte
//! first. Nothing marks it: it is recognised by times in order and words that are events.
//!
//! | bits of a word | 24-bit codec (text, `binaryevents.log`) | newer codec (packed bottles) |
//! |---|---|---|
//! | 0 | 0 is ON | 0 is ON |
//! | 1-11 | column (10 bits, the eleventh is 0) | column |
//! | 12-21 | row | row |
//! | 22 | channel: 0 left, 1 right | channel |
//! | 23 and up | 0; else frames, skin, motion or sound | type, skin, then a corner, then 0 |
//!
//! Words whose upper bits are not those of an event are skipped and counted. A corner is an event.
//!
//! * **Cameras**: the channel is the camera, 0 left and 1 right. Without
//!   [`OpenOptions::camera`](crate::OpenOptions::camera) the lowest of the first events is read,
//!   and those of the other are counted.
//! * **Ticks** are 0.08 µs, the clock of the cameras' interface, or 1 µs. bimvee wrote the former,
//!   and so is eH3.6M; now it writes and reads the latter by default, so that hpe-core reads eH3.6M
//!   with `ts_scaler 12.5` and DHP19 with 1. A `data.log` decides by itself: the times of its
//!   bottles are seconds, and the ticks that pass between them are compared. Where that decides
//!   nothing, as in any `binaryevents.log`, ticks are taken to be those of the interface, which
//!   fills such files, and a remark says so; [`OpenOptions::tick_us`](crate::OpenOptions::tick_us)
//!   overrules all of it.
//! * **Wrap-around**: ticks that fall by more than half of a period have wrapped around. The period
//!   is the power of two above the largest stamp so far, at least 2^24, since interfaces of 24 to
//!   32 bits are in use.
//! * **Beginning**: times stay as they are in the file. The original readers move the first event
//!   to 0; skeletons beside it are on the clock of the file, though, so that would part them.
//! * A log does not state its sensor.
//!
//! Of all this only skeletons are written, by [`write_skeletons`].

mod binary;
mod bottle;
mod log;
mod skeleton;
mod skeleton_writer;
mod ticks;
mod word;

pub use skeleton::{JOINTS, YarpSkeleton, read_skeletons, read_skeletons_from};
pub use skeleton_writer::{CoordinateFormat, write_skeletons};

pub(crate) use binary::FORMAT as BINARY;
pub(crate) use log::FORMAT as LOG;

#[cfg(test)]
mod tests;
