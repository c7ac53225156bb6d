//! A pickle that was read: values that refer to each other by number.

use crate::pickle::PickleError;
use crate::pickle::machine::Machine;

/// A node of a [`Pickle`] by its number; lists and dictionaries may be shared, or contain
/// themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Id(pub(crate) usize);

/// One value.
#[derive(Debug, Clone, PartialEq)]
pub enum PickleValue {
    /// Nothing.
    None,
    /// A truth value.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// An integer of more than 64 bits: its little-endian bytes.
    LongInt(Vec<u8>),
    /// A real number.
    Float(f64),
    /// A text.
    Text(String),
    /// Bytes; in pickles of Python 2 also a text ([`Pickle::text`]).
    Bytes(Vec<u8>),
    /// A list.
    List(Vec<Id>),
    /// A tuple.
    Tuple(Vec<Id>),
    /// A dictionary in the order in which it was filled.
    Dict(Vec<(Id, Id)>),
    /// A name in a Python module: a class or a function.
    Global {
        /// Dotted path of the module.
        module: String,
        /// Its name in there.
        name: String,
    },
    /// A persistent object outside of the pickle, such as the values of a tensor.
    Persistent(Id),
    /// An object: a callable and its arguments, then what was put into it.
    Call {
        /// Class or function that is called.
        callable: Id,
        /// The tuple it would be given.
        arguments: Id,
        /// Entries that were set as in a dictionary.
        items: Vec<(Id, Id)>,
        /// Its attributes, or whatever else it restores itself from.
        state: Option<Id>,
    },
}

/// A pickle that was read.
#[derive(Debug)]
pub struct Pickle {
    nodes: Vec<PickleValue>,
    root: Id,
    end: usize,
}

impl Pickle {
    /// Reads the pickle that begins at byte `start`.
    ///
    /// # Errors
    /// What is wrong, and at which byte.
    pub fn read(bytes: &[u8], start: usize) -> Result<Self, PickleError> {
        let mut machine = Machine::new(bytes, start);
        loop {
            let offset = machine.program.at;
            match machine.step() {
                Ok(None) => {}
                Ok(Some(root)) => {
                    return Ok(Self { nodes: machine.nodes, root, end: machine.program.at });
                }
                Err(fault) => return Err(PickleError { byte: offset, ..fault }),
            }
        }
    }

    /// The pickled value.
    pub fn root(&self) -> Id {
        self.root
    }

    /// The value of this number.
    pub fn node(&self, id: Id) -> &PickleValue {
        &self.nodes[id.0]
    }

    /// Offset of the bytes behind the pickle.
    pub fn end(&self) -> usize {
        self.end
    }

    /// Every value, in the order in which they were made.
    pub fn nodes(&self) -> &[PickleValue] {
        &self.nodes
    }

    /// The entries of a dictionary, or of an object that was filled like one.
    pub fn entries(&self, id: Id) -> &[(Id, Id)] {
        match self.node(id) {
            PickleValue::Dict(items) | PickleValue::Call { items, .. } => items,
            _ => &[],
        }
    }

    /// The entry of a dictionary under a text.
    pub fn get(&self, id: Id, key: &str) -> Option<Id> {
        let entries = self.entries(id).iter();
        entries.rev().find(|(k, _)| self.spells(*k, key)).map(|(_, value)| *value)
    }

    /// Whether a value is this text. Compares lengths first, unlike a conversion.
    fn spells(&self, id: Id, text: &str) -> bool {
        match self.node(id) {
            PickleValue::Text(key) => key == text,
            PickleValue::Bytes(key) => key == text.as_bytes(),
            _ => false,
        }
    }

    /// A text, also one of Python 2.
    pub fn text(&self, id: Id) -> Option<&str> {
        match self.node(id) {
            PickleValue::Text(text) => Some(text),
            PickleValue::Bytes(bytes) => std::str::from_utf8(bytes).ok(),
            _ => None,
        }
    }

    /// The items of a list or tuple.
    pub fn sequence(&self, id: Id) -> Option<&[Id]> {
        match self.node(id) {
            PickleValue::List(items) | PickleValue::Tuple(items) => Some(items),
            _ => None,
        }
    }

    /// A count or a position.
    pub fn size(&self, id: Id) -> Option<usize> {
        match self.node(id) {
            PickleValue::Int(value) => usize::try_from(*value).ok(),
            _ => None,
        }
    }

    /// A list or tuple of counts.
    pub fn sizes(&self, id: Id) -> Option<Vec<usize>> {
        self.sequence(id)?.iter().map(|&id| self.size(id)).collect()
    }

    /// The function that is called at `id` (module and name), and its arguments.
    pub fn call(&self, id: Id) -> Option<(&str, &str, &[Id])> {
        let PickleValue::Call { callable, arguments, .. } = self.node(id) else { return None };
        let PickleValue::Global { module, name } = self.node(*callable) else { return None };
        Some((module, name, self.sequence(*arguments)?))
    }

    /// The class of an object (module and name), however it was to be made.
    pub fn class(&self, id: Id) -> Option<(&str, &str)> {
        let (module, name, arguments) = self.call(id)?;
        let makes_another = matches!(
            (module, name),
            ("copy_reg" | "copyreg", "_reconstructor" | "__newobj__" | "__newobj_ex__")
        );
        match (makes_another, arguments) {
            (true, [class, ..]) => match self.node(*class) {
                PickleValue::Global { module, name } => Some((module, name)),
                _ => None,
            },
            _ => Some((module, name)),
        }
    }

    /// The state that an object is restored from.
    pub fn state(&self, id: Id) -> Option<Id> {
        match self.node(id) {
            PickleValue::Call { state, .. } => *state,
            _ => None,
        }
    }

    /// An attribute of an object.
    pub fn attribute(&self, id: Id, name: &str) -> Option<Id> {
        let state = self.state(id)?;
        // With slots, a pair of dictionaries.
        let dictionary = match self.node(state) {
            PickleValue::Tuple(pair) => *pair.first()?,
            _ => state,
        };
        self.get(dictionary, name)
    }
}
