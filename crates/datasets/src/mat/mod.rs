//! MAT-files of MATLAB, version 5 to 7.2.
//!
//! * [`MatFile`]: a file in memory, its variables by name.
//! * [`MatValue`]: what a variable, a field or an element is, by name and number; its errors say where.
//! * [`MatError`]: which byte of the file is wrong, or which field is not what is expected.
//!
//! What is read: numbers of all classes and their truth values, text, cell arrays and structures, in
//! either order of bytes, compressed or not. Sparse matrices, objects and handles of functions are passed
//! over and named when they are asked for.
//!
//! # Source
//! The MathWorks: *MAT-File Format* (R2018a).

mod class;
mod element;
mod error;
mod file;
mod text;
mod tree;
mod value;

pub use class::MatClass;
pub use error::{MatError, MatPosition};
pub use file::MatFile;
pub use value::MatValue;
