//! MAT-files of MATLAB, version 5 to 7.2, read from their bytes.
//!
//! * [`MatFile`]: a file in memory, its variables by name.
//! * [`MatValue`]: a variable, a field or an element, reached by name and index; its errors carry
//!   the path.
//! * [`MatError`]: the byte of the file that is wrong, or the field that does not hold what is
//!   expected.
//!
//! Numeric arrays of all classes, logical arrays, text, cell arrays and structures are read, in
//! either byte order, compressed or not. Sparse matrices, objects and function handles are skipped,
//! and reported when their values are asked for.
//!
//! ```
//! use evpose_containers::mat::MatFile;
//!
//! // scipy.io.savemat(…, {"points": {"point": [{"x": 1, "y": 2, …}, …], …}, …})
//! # let bytes = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/mat/kinds.mat"));
//! let file = MatFile::parse(bytes)?;
//! let points = file.variable("points")?.field("point")?;
//! assert_eq!(points.len(), 2);
//! assert_eq!(points.index(0)?.field("y")?.scalar()?, 2.0);
//! let error = points.index(0)?.field("z").unwrap_err();
//! assert_eq!(error.to_string(), "points.point(1) has no field `z`: it has `x`, `y`, `note`");
//! # Ok::<(), evpose_containers::mat::MatError>(())
//! ```
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
