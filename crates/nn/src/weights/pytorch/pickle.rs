//! Python pickles read as data: nothing is imported, nothing is called.
//!
//! What a pickle would construct stays a node that says so ([`Node::Call`]), whatever class it
//! names. A checkpoint therefore loads although it also holds objects of a training framework
//! nobody has here. Work and memory are bounded by the length of the input.

use super::machine::Machine;

/// A node of a [`Pickle`] by its number; lists and dictionaries may be shared, or contain themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Id(pub(super) usize);

/// One value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    None,
    Bool(bool),
    Int(i64),
    /// An integer of more than 64 bits: its little-endian bytes.
    LongInt(Vec<u8>),
    Float(f64),
    Text(String),
    Bytes(Vec<u8>),
    List(Vec<Id>),
    Tuple(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    /// A name in a Python module: a class or a function.
    Global {
        module: String,
        name: String,
    },
    /// Something kept outside of the pickle, such as the numbers of a tensor.
    Persistent(Id),
    /// An object: a callable and its arguments, then what was put into it.
    Call {
        callable: Id,
        arguments: Id,
        items: Vec<(Id, Id)>,
    },
}

/// A pickle that was read.
#[derive(Debug)]
pub(super) struct Pickle {
    nodes: Vec<Node>,
    root: Id,
    /// Where the bytes behind it begin.
    pub(super) end: usize,
}

impl Pickle {
    /// Reads the pickle that begins at byte `start`.
    ///
    /// # Errors
    /// What is wrong, and at which byte.
    pub(super) fn read(bytes: &[u8], start: usize) -> Result<Self, String> {
        let mut machine = Machine::new(bytes, start);
        loop {
            let offset = machine.at;
            match machine.step() {
                Ok(None) => {}
                Ok(Some(root)) => return Ok(Self { nodes: machine.nodes, root, end: machine.at }),
                Err(reason) => return Err(format!("pickle, byte {offset}: {reason}")),
            }
        }
    }

    pub(super) fn root(&self) -> Id {
        self.root
    }

    pub(super) fn node(&self, id: Id) -> &Node {
        &self.nodes[id.0]
    }

    /// Every value, in the order in which they were made.
    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The entries of a dictionary, or of an object that was filled like one.
    pub(super) fn entries(&self, id: Id) -> &[(Id, Id)] {
        match self.node(id) {
            Node::Dict(items) | Node::Call { items, .. } => items,
            _ => &[],
        }
    }

    /// The entry of a dictionary under a text.
    pub(super) fn get(&self, id: Id, key: &str) -> Option<Id> {
        let entries = self.entries(id).iter();
        entries.rev().find(|(k, _)| self.text(*k) == Some(key)).map(|(_, value)| *value)
    }

    pub(super) fn text(&self, id: Id) -> Option<&str> {
        match self.node(id) {
            Node::Text(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn sequence(&self, id: Id) -> Option<&[Id]> {
        match self.node(id) {
            Node::List(items) | Node::Tuple(items) => Some(items),
            _ => None,
        }
    }

    /// A count or a position.
    pub(super) fn size(&self, id: Id) -> Option<usize> {
        match self.node(id) {
            Node::Int(value) => usize::try_from(*value).ok(),
            _ => None,
        }
    }

    /// A tuple of counts.
    pub(super) fn sizes(&self, id: Id) -> Option<Vec<usize>> {
        self.sequence(id)?.iter().map(|&id| self.size(id)).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_dictionary_reads_as_python_wrote_it() {
        // pickle.dumps({"a": [1, -2, 3.5, None], "b": (True, 2**40)}, protocol=2)
        let bytes =
            b"\x80\x02}q\x00(X\x01\x00\x00\x00aq\x01]q\x02(K\x01J\xfe\xff\xff\xffG@\x0c\x00\x00\
\x00\x00\x00\x00NeX\x01\x00\x00\x00bq\x03\x88\x8a\x06\x00\x00\x00\x00\x00\x01\x86q\x04u.tail";
        let pickle = Pickle::read(bytes, 0).unwrap();
        assert_eq!(&bytes[pickle.end..], b"tail");
        let value = |id: &Id| pickle.node(*id).clone();
        let list = pickle.sequence(pickle.get(pickle.root(), "a").unwrap()).unwrap();
        let list: Vec<_> = list.iter().map(value).collect();
        assert_eq!(list, [Node::Int(1), Node::Int(-2), Node::Float(3.5), Node::None]);
        let tuple = pickle.sequence(pickle.get(pickle.root(), "b").unwrap()).unwrap();
        let tuple: Vec<_> = tuple.iter().map(value).collect();
        assert_eq!(tuple, [Node::Bool(true), Node::Int(1 << 40)]);
    }

    #[test]
    fn unknown_classes_are_kept_unopened() {
        // A subclass of dict, filled with one entry and given a state; then its class as a key.
        let bytes =
            b"\x80\x02}(X\x01\x00\x00\x00hcsome.where\nThing\n)\x81X\x01\x00\x00\x00kK\x07s}bcsome\
.where\nThing\nK\x01u.";
        let pickle = Pickle::read(bytes, 0).unwrap();
        let thing = pickle.get(pickle.root(), "h").unwrap();
        assert_eq!(pickle.get(thing, "k").and_then(|id| pickle.size(id)), Some(7));
    }

    #[test]
    fn errors_name_the_byte() {
        let error = |bytes: &[u8]| Pickle::read(bytes, 0).unwrap_err();
        assert_eq!(error(b"\x80\x02K"), "pickle, byte 2: the file ends here");
        assert_eq!(error(b"\x80\x02\xff"), "pickle, byte 2: unknown opcode 0xff");
        assert_eq!(error(b"h\x05"), "pickle, byte 0: value 5 was never stored");
        assert_eq!(error(b"X\xff\xff\xff\x7f"), "pickle, byte 0: the file ends here");
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Pickle::read(&bytes, 0);
        }

        #[test]
        fn no_program_of_valid_opcodes_makes_the_reader_panic(
            ops in prop::collection::vec(prop::sample::select(&b"(012N\x88K\x01]})ae\x85\x86ltdsuRbQq\x00h\x00."[..]), 0..80),
        ) {
            let _ = Pickle::read(&ops, 0);
        }
    }
}
