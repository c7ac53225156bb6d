//! Files of other programs, read as data: nothing is executed, and work and memory are bounded by
//! the length of a file or by a stated limit.
//!
//! * [`pickle`]: Python's pickles, with numpy's arrays in them.
//! * [`mat`]: MAT-files of MATLAB, version 5 to 7.2.
//! * [`cdf`]: NASA's Common Data Format, version 3.

pub mod cdf;
pub mod mat;
mod number;
pub mod pickle;
