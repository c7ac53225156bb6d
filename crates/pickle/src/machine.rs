//! The stack machine for which pickles are programs.
//!
//! # Source
//! `pickletools` of CPython documents every opcode. Protocols 0 to 5, without buffers that are kept
//! outside of the pickle and without the registry of extension codes.

use crate::text::{escaped, quoted};
use crate::value::{Id, Node};

/// A value on the stack, or the mark that opens a group of them.
#[derive(Clone, Copy)]
enum Item {
    Value(Id),
    Mark,
}

/// Values of a pickle, and of its stack. Files of numbers have thousands; a file that makes one with
/// every byte would otherwise take a hundred times its length in memory.
const MOST_VALUES: usize = 1 << 21;

/// Bytes of names of modules and classes that are copied from texts. A few dozen are usual.
const MOST_COPIED: usize = 1 << 20;

/// A program and how far it has run.
pub(crate) struct Machine<'a> {
    bytes: &'a [u8],
    /// The next byte.
    pub(crate) at: usize,
    /// Every value made so far.
    pub(crate) nodes: Vec<Node>,
    stack: Vec<Item>,
    memo: Vec<Option<Id>>,
    /// Bytes of texts that were copied into names.
    copied: usize,
}

type Step<T> = Result<T, String>;

impl<'a> Machine<'a> {
    /// The program that begins at byte `start`.
    pub(crate) fn new(bytes: &'a [u8], start: usize) -> Self {
        Self { bytes, at: start, nodes: Vec::new(), stack: Vec::new(), memo: Vec::new(), copied: 0 }
    }

    /// Executes one opcode; the root at the last one.
    pub(crate) fn step(&mut self) -> Step<Option<Id>> {
        if self.nodes.len().max(self.stack.len()) > MOST_VALUES {
            return Err(format!("more than {MOST_VALUES} values"));
        }
        match self.byte()? {
            0x80 => drop(self.byte()?),
            0x95 => drop(self.take(8)?),
            b'.' => return self.pop().map(Some),
            b'(' => self.stack.push(Item::Mark),
            b'0' => drop(self.stack.pop()),
            b'1' => drop(self.pop_group()?),
            b'2' => {
                let top = self.top()?;
                self.stack.push(Item::Value(top));
            }
            b'N' => self.push(Node::None)?,
            0x88 => self.push(Node::Bool(true))?,
            0x89 => self.push(Node::Bool(false))?,
            b'K' => self.integer(1)?,
            b'M' => self.integer(2)?,
            b'J' => {
                let bytes = self.array::<4>()?;
                self.push(Node::Int(i64::from(i32::from_le_bytes(bytes))))?;
            }
            0x8a => self.long(1)?,
            0x8b => self.long(4)?,
            b'G' => {
                let bytes = self.array()?;
                self.push(Node::Float(f64::from_be_bytes(bytes)))?;
            }
            0x8c => self.text(1)?,
            b'X' => self.text(4)?,
            0x8d => self.text(8)?,
            b'U' | b'C' => self.raw(1)?,
            b'T' | b'B' => self.raw(4)?,
            0x8e | 0x96 => self.raw(8)?,
            b']' | 0x8f => self.push(Node::List(Vec::new()))?,
            b')' => self.push(Node::Tuple(Vec::new()))?,
            b'}' => self.push(Node::Dict(Vec::new()))?,
            b'a' => {
                let value = self.pop()?;
                self.append(vec![value])?;
            }
            b'e' | 0x90 => {
                let values = self.pop_group()?;
                self.append(values)?;
            }
            b'l' => {
                let values = self.pop_group()?;
                self.push(Node::List(values))?;
            }
            b't' => {
                let values = self.pop_group()?;
                self.push(Node::Tuple(values))?;
            }
            count @ 0x85..=0x87 => {
                let mut values =
                    (0..=count - 0x85).map(|_| self.pop()).collect::<Step<Vec<_>>>()?;
                values.reverse();
                self.push(Node::Tuple(values))?;
            }
            b'd' => {
                let values = self.pop_group()?;
                self.push(Node::Dict(pairs(&values)?))?;
            }
            b's' => {
                let (value, key) = (self.pop()?, self.pop()?);
                self.insert(vec![(key, value)])?;
            }
            b'u' => {
                let values = self.pop_group()?;
                self.insert(pairs(&values)?)?;
            }
            b'c' => {
                let (module, name) = (self.line()?, self.line()?);
                self.push(Node::Global { module, name })?;
            }
            0x93 => {
                let (name, module) = (self.pop_text()?, self.pop_text()?);
                self.push(Node::Global { module, name })?;
            }
            b'R' | 0x81 => {
                let (arguments, callable) = (self.pop()?, self.pop()?);
                self.call(callable, arguments)?;
            }
            0x92 => {
                let (_keywords, arguments, callable) = (self.pop()?, self.pop()?, self.pop()?);
                self.call(callable, arguments)?;
            }
            // An instance in protocol 0: its class by name, its arguments on the stack.
            b'i' => {
                let (module, name) = (self.line()?, self.line()?);
                let arguments = self.pop_group()?;
                let (class, arguments) =
                    (self.add(Node::Global { module, name }), self.add(Node::Tuple(arguments)));
                self.call(class, arguments)?;
            }
            // An instance in protocol 1: its class and its arguments on the stack.
            b'o' => {
                let mut group = self.pop_group()?;
                if group.is_empty() {
                    return Err("an instance without a class".to_owned());
                }
                let class = group.remove(0);
                let arguments = self.add(Node::Tuple(group));
                self.call(class, arguments)?;
            }
            // The state of an object: its attributes.
            b'b' => {
                let value = self.pop()?;
                let object = self.top()?;
                if let Node::Call { state, .. } = &mut self.nodes[object.0] {
                    *state = Some(value);
                }
            }
            b'I' => self.decimal()?,
            b'L' => self.decimal_long()?,
            b'F' => {
                let line = self.line()?;
                let value = line.trim().parse().map_err(|_| format!("`{line}` is no number"))?;
                self.push(Node::Float(value))?;
            }
            b'S' => {
                let bytes = quoted(self.raw_line()?)?;
                self.push(Node::Bytes(bytes))?;
            }
            b'V' => {
                let text = escaped(self.raw_line()?)?;
                self.push(Node::Text(text))?;
            }
            b'P' => {
                let name = self.line()?;
                let name = self.add(Node::Text(name));
                self.push(Node::Persistent(name))?;
            }
            b'p' => {
                let place = self.place()?;
                self.remember_at(place)?;
            }
            b'g' => {
                let place = self.place()?;
                self.recall(place)?;
            }
            b'Q' => {
                let id = self.pop()?;
                self.push(Node::Persistent(id))?;
            }
            b'q' => {
                let place = self.number(1)?;
                self.remember_at(place)?;
            }
            b'r' => {
                let place = self.number(4)?;
                self.remember_at(place)?;
            }
            0x94 => {
                let top = self.top()?;
                self.memo.push(Some(top));
            }
            b'h' => {
                let place = self.number(1)?;
                self.recall(place)?;
            }
            b'j' => {
                let place = self.number(4)?;
                self.recall(place)?;
            }
            other => return Err(format!("unknown opcode 0x{other:02x}")),
        }
        Ok(None)
    }

    fn byte(&mut self) -> Step<u8> {
        Ok(self.array::<1>()?[0])
    }

    fn take(&mut self, count: usize) -> Step<&'a [u8]> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.get(..count).ok_or("the file ends here")?;
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Step<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    /// A little-endian number of `width` bytes.
    fn number(&mut self, width: usize) -> Step<usize> {
        let mut bytes = [0; 8];
        bytes[..width].copy_from_slice(self.take(width)?);
        usize::try_from(u64::from_le_bytes(bytes)).map_err(|_| "too large a number".to_owned())
    }

    /// Up to the end of the line, which is passed over.
    fn raw_line(&mut self) -> Step<&'a [u8]> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|&b| b == b'\n').ok_or("the file ends in a line")?;
        self.at += length + 1;
        // Written on Windows in text mode.
        Ok(rest[..length].strip_suffix(b"\r").unwrap_or(&rest[..length]))
    }

    fn line(&mut self) -> Step<String> {
        utf8(self.raw_line()?)
    }

    /// A place among the remembered values, in digits.
    fn place(&mut self) -> Step<usize> {
        let line = self.line()?;
        line.trim().parse().map_err(|_| format!("`{line}` is no place of a value"))
    }

    /// An integer in digits; two spellings are truth values.
    fn decimal(&mut self) -> Step<()> {
        let line = self.line()?;
        match line.as_str() {
            "00" => self.push(Node::Bool(false)),
            "01" => self.push(Node::Bool(true)),
            digits => {
                let value = digits.trim().parse();
                self.push(Node::Int(value.map_err(|_| format!("`{digits}` is no integer"))?))
            }
        }
    }

    /// A long integer in digits, as Python 2 prints it.
    fn decimal_long(&mut self) -> Step<()> {
        let line = self.line()?;
        let digits = line.trim().trim_end_matches('L');
        if let Ok(value) = digits.parse() {
            return self.push(Node::Int(value));
        }
        // The unsigned 64 bits that are beyond the signed ones.
        let value: u64 =
            digits.parse().map_err(|_| format!("`{line}` is no integer of 64 bits"))?;
        let mut bytes = value.to_le_bytes().to_vec();
        bytes.push(0);
        self.push(Node::LongInt(bytes))
    }

    /// A value that is not on the stack.
    fn add(&mut self, node: Node) -> Id {
        self.nodes.push(node);
        Id(self.nodes.len() - 1)
    }

    fn call(&mut self, callable: Id, arguments: Id) -> Step<()> {
        self.push(Node::Call { callable, arguments, items: Vec::new(), state: None })
    }

    fn push(&mut self, node: Node) -> Step<()> {
        let id = self.add(node);
        self.stack.push(Item::Value(id));
        Ok(())
    }

    fn integer(&mut self, width: usize) -> Step<()> {
        let value = self.number(width)?;
        self.push(Node::Int(value as i64))
    }

    fn long(&mut self, width: usize) -> Step<()> {
        let length = self.number(width)?;
        let bytes = self.take(length)?.to_vec();
        let negative = bytes.last().is_some_and(|last| last & 0x80 != 0);
        let mut extended = [if negative { 0xff } else { 0 }; 8];
        self.push(match bytes.len() {
            ..=8 => {
                extended[..bytes.len()].copy_from_slice(&bytes);
                Node::Int(i64::from_le_bytes(extended))
            }
            _ => Node::LongInt(bytes),
        })
    }

    fn text(&mut self, width: usize) -> Step<()> {
        let length = self.number(width)?;
        let text = utf8(self.take(length)?)?;
        self.push(Node::Text(text))
    }

    /// A byte string: in Python 2 also a text.
    fn raw(&mut self, width: usize) -> Step<()> {
        let length = self.number(width)?;
        let bytes = self.take(length)?.to_vec();
        self.push(Node::Bytes(bytes))
    }

    fn top(&self) -> Step<Id> {
        match self.stack.last() {
            Some(Item::Value(id)) => Ok(*id),
            _ => Err("a value was expected on the stack".to_owned()),
        }
    }

    fn pop(&mut self) -> Step<Id> {
        let top = self.top()?;
        self.stack.pop();
        Ok(top)
    }

    /// A copy of a text. One text can be named again and again: copies count.
    fn pop_text(&mut self) -> Step<String> {
        let id = self.pop()?;
        match &self.nodes[id.0] {
            Node::Text(text) => {
                self.copied += text.len();
                if self.copied > MOST_COPIED {
                    return Err(format!("more than {MOST_COPIED} bytes of names of classes"));
                }
                Ok(text.clone())
            }
            _ => Err("a text was expected on the stack".to_owned()),
        }
    }

    /// The values above the last mark.
    fn pop_group(&mut self) -> Step<Vec<Id>> {
        let mark = self.stack.iter().rposition(|item| matches!(item, Item::Mark));
        let group = self.stack.drain(mark.ok_or("a group was closed that was not opened")?..);
        let values = group.filter_map(|item| match item {
            Item::Value(id) => Some(id),
            Item::Mark => None,
        });
        Ok(values.collect())
    }

    fn append(&mut self, values: Vec<Id>) -> Step<()> {
        let list = self.top()?;
        match &mut self.nodes[list.0] {
            Node::List(items) => items.extend(values),
            // A subclass of list, whose items nothing here reads.
            Node::Call { .. } => {}
            _ => return Err("items for something that is no list".to_owned()),
        }
        Ok(())
    }

    fn insert(&mut self, entries: Vec<(Id, Id)>) -> Step<()> {
        let dictionary = self.top()?;
        match &mut self.nodes[dictionary.0] {
            Node::Dict(items) | Node::Call { items, .. } => items.extend(entries),
            _ => return Err("entries for something that is no dictionary".to_owned()),
        }
        Ok(())
    }

    fn remember_at(&mut self, place: usize) -> Step<()> {
        let top = self.top()?;
        // Writers count up; a place beyond what was ever pushed is not theirs.
        if place > self.nodes.len() {
            return Err(format!("value {place} is remembered out of turn"));
        }
        if place >= self.memo.len() {
            self.memo.resize(place + 1, None);
        }
        self.memo[place] = Some(top);
        Ok(())
    }

    fn recall(&mut self, place: usize) -> Step<()> {
        let id = self.memo.get(place).copied().flatten();
        self.stack.push(Item::Value(id.ok_or_else(|| format!("value {place} was never stored"))?));
        Ok(())
    }
}

fn utf8(bytes: &[u8]) -> Step<String> {
    String::from_utf8(bytes.to_vec()).map_err(|_| "a text that is not UTF-8".to_owned())
}

fn pairs(values: &[Id]) -> Step<Vec<(Id, Id)>> {
    match values.as_chunks() {
        (pairs, []) => Ok(pairs.iter().map(|&[key, value]| (key, value)).collect()),
        _ => Err("a key without a value".to_owned()),
    }
}
