//! The stack machine for which pickles are programs.
//!
//! # Source
//! `pickletools` of CPython documents every opcode. Protocols 2 to 4, without those opcodes that
//! only protocol 0 writes.

use super::pickle::{Id, Node};

/// A value on the stack, or the mark that opens a group of them.
#[derive(Clone, Copy)]
enum Item {
    Value(Id),
    Mark,
}

/// A program and how far it has run.
pub(super) struct Machine<'a> {
    bytes: &'a [u8],
    /// The next byte.
    pub(super) at: usize,
    /// Every value made so far.
    pub(super) nodes: Vec<Node>,
    stack: Vec<Item>,
    memo: Vec<Option<Id>>,
}

type Step<T> = Result<T, String>;

impl<'a> Machine<'a> {
    /// The program that begins at byte `start`.
    pub(super) fn new(bytes: &'a [u8], start: usize) -> Self {
        Self { bytes, at: start, nodes: Vec::new(), stack: Vec::new(), memo: Vec::new() }
    }

    /// Executes one opcode; the root at the last one.
    pub(super) fn step(&mut self) -> Step<Option<Id>> {
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
            0x8e => self.raw(8)?,
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
                self.push(Node::Call { callable, arguments, items: Vec::new() })?;
            }
            0x92 => {
                let (_keywords, arguments, callable) = (self.pop()?, self.pop()?, self.pop()?);
                self.push(Node::Call { callable, arguments, items: Vec::new() })?;
            }
            // The state of an object: its attributes, of which nothing here depends.
            b'b' => drop(self.pop()?),
            b'Q' => {
                let id = self.pop()?;
                self.push(Node::Persistent(id))?;
            }
            b'q' => self.remember_at(1)?,
            b'r' => self.remember_at(4)?,
            0x94 => {
                let top = self.top()?;
                self.memo.push(Some(top));
            }
            b'h' => self.recall(1)?,
            b'j' => self.recall(4)?,
            other => return Err(format!("unknown opcode 0x{other:02x}")),
        }
        Ok(None)
    }

    fn byte(&mut self) -> Step<u8> {
        Ok(self.array::<1>()?[0])
    }

    fn take(&mut self, count: usize) -> Step<&[u8]> {
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

    fn line(&mut self) -> Step<String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|&b| b == b'\n').ok_or("the file ends in a name")?;
        let text = utf8(self.take(length)?)?;
        self.at += 1;
        Ok(text)
    }

    fn push(&mut self, node: Node) -> Step<()> {
        self.nodes.push(node);
        self.stack.push(Item::Value(Id(self.nodes.len() - 1)));
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

    /// A byte string: the text of Python 2 where it is text.
    fn raw(&mut self, width: usize) -> Step<()> {
        let length = self.number(width)?;
        let bytes = self.take(length)?.to_vec();
        self.push(match String::from_utf8(bytes) {
            Ok(text) => Node::Text(text),
            Err(error) => Node::Bytes(error.into_bytes()),
        })
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

    fn pop_text(&mut self) -> Step<String> {
        let id = self.pop()?;
        match &self.nodes[id.0] {
            Node::Text(text) => Ok(text.clone()),
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

    fn remember_at(&mut self, width: usize) -> Step<()> {
        let (place, top) = (self.number(width)?, self.top()?);
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

    fn recall(&mut self, width: usize) -> Step<()> {
        let place = self.number(width)?;
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
