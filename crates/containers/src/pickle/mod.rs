//! Python pickles read as data: nothing is imported, nothing is called.
//!
//! An object that a pickle would construct stays a node ([`PickleValue::Call`]) that names its class. A
//! file therefore loads although it also holds objects of a framework nobody has here. Work and
//! memory are bounded by the length of the input; values may be shared or contain themselves, so a
//! reader that follows them has to count its steps.
//!
//! * [`Pickle`]: protocols 0 to 5, with the byte strings of Python 2.
//! * [`Array`], [`Sparse`]: numpy's arrays, chumpy's constants and scipy's sparse matrices.
//!
//! ```
//! use evpose_containers::pickle::Pickle;
//!
//! // pickle.dumps({"a": 7}, protocol=0) of Python 2.
//! let pickle = Pickle::read(b"(dp0\nS'a'\np1\nI7\ns.", 0)?;
//! let seven = pickle.get(pickle.root(), "a").and_then(|id| pickle.size(id));
//! assert_eq!(seven, Some(7));
//! # Ok::<(), evpose_containers::pickle::PickleError>(())
//! ```

mod array;
mod constant;
mod element;
mod machine;
mod opcode;
mod program;
mod sparse;
#[cfg(test)]
mod tests;
mod text;
mod value;

pub use array::{Array, ArrayError};
pub use element::Element;
pub use sparse::Sparse;
pub use value::{Id, Pickle, PickleValue};

/// A pickle that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("pickle, byte {byte}: {reason}")]
pub struct PickleError {
    /// The instruction that fails.
    pub byte: usize,
    /// Why.
    pub reason: String,
}
