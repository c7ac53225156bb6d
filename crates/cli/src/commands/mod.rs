//! One file or folder per command: its arguments, and `run`.
//!
//! Every `run` fails where an argument or a file is not what it should be, where a device is
//! missing, or where a result cannot be written; [`BadInput`](crate::bad_input::BadInput) is among
//! the causes of what the user can correct.

mod account;
pub mod average;
pub mod calibrate;
pub mod check;
pub mod check_labels;
mod checkpoint_info;
pub mod clean;
pub mod convert;
mod data_set;
pub mod demo;
mod devices;
pub mod eval;
pub mod events;
pub mod export;
pub mod gap;
pub mod infer;
pub mod info;
pub mod live;
mod opening;
pub mod prepare;
pub mod quantize;
pub mod represent;
pub mod sensor;
pub mod simulate;
pub mod train;
pub mod view;
