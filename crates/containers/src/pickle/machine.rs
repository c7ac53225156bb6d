//! The stack machine for which pickles are programs.
//!
//! # Source
//! `pickletools` of CPython documents every opcode. Protocols 0 to 5, without buffers that are kept
//! outside of the pickle and without the registry of extension codes.

use crate::pickle::opcode as op;
use crate::pickle::program::{Program, Step, fault, utf8};
use crate::pickle::text::{escaped, quoted};
use crate::pickle::value::{Id, PickleValue};

/// A value on the stack, or the mark that opens a group of them.
#[derive(Clone, Copy)]
enum Item {
    Value(Id),
    Mark,
}

/// Maximal count of values of a pickle, and of its stack. Files of arrays have thousands; a file
/// that makes one with every byte would otherwise take a hundred times its length in memory.
const MAX_VALUES: usize = 1 << 21;

/// Maximal bytes of names of modules and classes that are copied from texts. A few dozen are usual.
const MAX_COPIED: usize = 1 << 20;

/// The state of a program while it runs.
pub(crate) struct Machine<'a> {
    pub(crate) program: Program<'a>,
    /// Every value made so far.
    pub(crate) nodes: Vec<PickleValue>,
    stack: Vec<Item>,
    memo: Vec<Option<Id>>,
    /// Bytes of texts that were copied into names.
    copied: usize,
}

impl<'a> Machine<'a> {
    /// The program that begins at byte `start`.
    pub(crate) fn new(bytes: &'a [u8], start: usize) -> Self {
        Self {
            program: Program { bytes, at: start },
            nodes: Vec::new(),
            stack: Vec::new(),
            memo: Vec::new(),
            copied: 0,
        }
    }

    /// Executes one opcode; returns the root at the last one.
    pub(crate) fn step(&mut self) -> Step<Option<Id>> {
        // One byte can make a value, which takes many times its memory.
        if self.nodes.len().max(self.stack.len()) > MAX_VALUES {
            return Err(fault(format!("more than {MAX_VALUES} values")));
        }
        let opcode = self.program.byte()?;
        if opcode == op::STOP {
            return self.pop().map(Some);
        }
        let is_known = self.stack_opcode(opcode)?
            || self.scalar_opcode(opcode)?
            || self.text_opcode(opcode)?
            || self.container_opcode(opcode)?
            || self.object_opcode(opcode)?
            || self.memo_opcode(opcode)?;
        if is_known { Ok(None) } else { Err(fault(format!("unknown opcode 0x{opcode:02x}"))) }
    }

    /// Executes an opcode of the stack and of framing; false for one of another group.
    fn stack_opcode(&mut self, opcode: u8) -> Step<bool> {
        match opcode {
            // Neither says anything about values.
            op::PROTO => drop(self.program.byte()?),
            op::FRAME => drop(self.program.take(8)?),
            op::MARK => self.stack.push(Item::Mark),
            op::POP => drop(self.stack.pop()),
            op::POP_MARK => drop(self.pop_group()?),
            op::DUP => {
                let top = self.top()?;
                self.stack.push(Item::Value(top));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Executes an opcode that pushes a scalar; false for one of another group.
    fn scalar_opcode(&mut self, opcode: u8) -> Step<bool> {
        match opcode {
            op::NONE => self.push(PickleValue::None),
            op::NEWTRUE => self.push(PickleValue::Bool(true)),
            op::NEWFALSE => self.push(PickleValue::Bool(false)),
            op::BININT1 => self.integer(1)?,
            op::BININT2 => self.integer(2)?,
            op::BININT => {
                let bytes = self.program.array::<4>()?;
                self.push(PickleValue::Int(i64::from(i32::from_le_bytes(bytes))));
            }
            op::LONG1 => self.long(1)?,
            op::LONG4 => self.long(4)?,
            op::BINFLOAT => {
                // The only value of the format that is big-endian.
                let bytes = self.program.array()?;
                self.push(PickleValue::Float(f64::from_be_bytes(bytes)));
            }
            op::INT => self.decimal()?,
            op::LONG => self.decimal_long()?,
            op::FLOAT => {
                let line = self.program.line()?;
                let value =
                    line.trim().parse().map_err(|_| fault(format!("`{line}` is no number")))?;
                self.push(PickleValue::Float(value));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Executes an opcode that pushes text or bytes; false for one of another group.
    fn text_opcode(&mut self, opcode: u8) -> Step<bool> {
        match opcode {
            op::SHORT_BINUNICODE => self.text(1)?,
            op::BINUNICODE => self.text(4)?,
            op::BINUNICODE8 => self.text(8)?,
            op::SHORT_BINSTRING | op::SHORT_BINBYTES => self.raw(1)?,
            op::BINSTRING | op::BINBYTES => self.raw(4)?,
            op::BINBYTES8 | op::BYTEARRAY8 => self.raw(8)?,
            op::STRING => {
                let bytes = quoted(self.program.raw_line()?)?;
                self.push(PickleValue::Bytes(bytes));
            }
            op::UNICODE => {
                let text = escaped(self.program.raw_line()?)?;
                self.push(PickleValue::Text(text));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Executes an opcode of lists, tuples, sets and dictionaries; false for one of another group.
    fn container_opcode(&mut self, opcode: u8) -> Step<bool> {
        match opcode {
            // Sets are lists here, since nothing asks for members.
            op::EMPTY_LIST | op::EMPTY_SET => self.push(PickleValue::List(Vec::new())),
            op::EMPTY_TUPLE => self.push(PickleValue::Tuple(Vec::new())),
            op::EMPTY_DICT => self.push(PickleValue::Dict(Vec::new())),
            op::APPEND => {
                let value = self.pop()?;
                self.append(vec![value])?;
            }
            op::APPENDS | op::ADDITEMS => {
                let values = self.pop_group()?;
                self.append(values)?;
            }
            op::LIST => {
                let values = self.pop_group()?;
                self.push(PickleValue::List(values));
            }
            op::TUPLE => {
                let values = self.pop_group()?;
                self.push(PickleValue::Tuple(values));
            }
            // From the top of the stack, so the last comes first.
            count @ op::TUPLE1..=op::TUPLE3 => {
                let popped = (0..=count - op::TUPLE1).map(|_| self.pop());
                let mut values = popped.collect::<Step<Vec<_>>>()?;
                values.reverse();
                self.push(PickleValue::Tuple(values));
            }
            op::DICT => {
                let values = self.pop_group()?;
                self.push(PickleValue::Dict(pairs(&values)?));
            }
            op::SETITEM => {
                // The value lies on top of its key.
                let (value, key) = (self.pop()?, self.pop()?);
                self.insert(vec![(key, value)])?;
            }
            op::SETITEMS => {
                let values = self.pop_group()?;
                self.insert(pairs(&values)?)?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Executes an opcode of classes, instances and persistent objects; false for one of another
    /// group.
    fn object_opcode(&mut self, opcode: u8) -> Step<bool> {
        match opcode {
            op::GLOBAL => {
                let (module, name) = (self.program.line()?, self.program.line()?);
                self.push(PickleValue::Global { module, name });
            }
            op::STACK_GLOBAL => {
                // The name lies on top of its module.
                let (name, module) = (self.pop_text()?, self.pop_text()?);
                self.push(PickleValue::Global { module, name });
            }
            op::REDUCE | op::NEWOBJ => {
                let (arguments, callable) = (self.pop()?, self.pop()?);
                self.call(callable, arguments);
            }
            op::NEWOBJ_EX => {
                let (_keywords, arguments, callable) = (self.pop()?, self.pop()?, self.pop()?);
                self.call(callable, arguments);
            }
            // An instance in protocol 0: its class by name, its arguments on the stack.
            op::INST => {
                let (module, name) = (self.program.line()?, self.program.line()?);
                let arguments = self.pop_group()?;
                let (class, arguments) = (
                    self.add(PickleValue::Global { module, name }),
                    self.add(PickleValue::Tuple(arguments)),
                );
                self.call(class, arguments);
            }
            // An instance in protocol 1: its class and its arguments on the stack.
            op::OBJ => {
                let mut group = self.pop_group()?;
                if group.is_empty() {
                    return Err(fault("an instance without a class"));
                }
                let class = group.remove(0);
                let arguments = self.add(PickleValue::Tuple(group));
                self.call(class, arguments);
            }
            // The state of an object: its attributes.
            op::BUILD => {
                let value = self.pop()?;
                let object = self.top()?;
                if let PickleValue::Call { state, .. } = &mut self.nodes[object.0] {
                    *state = Some(value);
                }
            }
            op::PERSID => {
                let name = self.program.line()?;
                let name = self.add(PickleValue::Text(name));
                self.push(PickleValue::Persistent(name));
            }
            op::BINPERSID => {
                let id = self.pop()?;
                self.push(PickleValue::Persistent(id));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Executes an opcode of the memo; false for one of another group.
    fn memo_opcode(&mut self, opcode: u8) -> Step<bool> {
        match opcode {
            op::PUT | op::BINPUT | op::LONG_BINPUT => {
                let index = self.memo_index(opcode)?;
                self.memoize(index)?;
            }
            op::GET | op::BINGET | op::LONG_BINGET => {
                let index = self.memo_index(opcode)?;
                self.recall(index)?;
            }
            op::MEMOIZE => {
                // Its index is the count of those before it.
                let top = self.top()?;
                self.memo.push(Some(top));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Reads the index of a memo entry: in digits, in one byte or in four.
    fn memo_index(&mut self, opcode: u8) -> Step<usize> {
        match opcode {
            op::PUT | op::GET => self.program.decimal_index(),
            op::BINPUT | op::BINGET => self.program.integer(1),
            _ => self.program.integer(4),
        }
    }

    /// Pushes an integer in digits; two spellings are booleans.
    fn decimal(&mut self) -> Step<()> {
        let line = self.program.line()?;
        let no_integer = |_| fault(format!("`{line}` is no integer"));
        self.push(match line.as_str() {
            "00" => PickleValue::Bool(false),
            "01" => PickleValue::Bool(true),
            digits => PickleValue::Int(digits.trim().parse().map_err(no_integer)?),
        });
        Ok(())
    }

    /// Pushes a long integer in digits, as Python 2 prints it.
    fn decimal_long(&mut self) -> Step<()> {
        let line = self.program.line()?;
        let digits = line.trim().trim_end_matches('L');
        if let Ok(value) = digits.parse() {
            self.push(PickleValue::Int(value));
            return Ok(());
        }
        // The unsigned 64 bits that are beyond the signed ones.
        let value: u64 =
            digits.parse().map_err(|_| fault(format!("`{line}` is no integer of 64 bits")))?;
        let mut bytes = value.to_le_bytes().to_vec();
        bytes.push(0);
        self.push(PickleValue::LongInt(bytes));
        Ok(())
    }

    /// Adds a value without pushing it on the stack.
    fn add(&mut self, node: PickleValue) -> Id {
        self.nodes.push(node);
        Id(self.nodes.len() - 1)
    }

    fn call(&mut self, callable: Id, arguments: Id) {
        self.push(PickleValue::Call { callable, arguments, items: Vec::new(), state: None });
    }

    fn push(&mut self, node: PickleValue) {
        let id = self.add(node);
        self.stack.push(Item::Value(id));
    }

    fn integer(&mut self, width: usize) -> Step<()> {
        let value = self.program.integer(width)?;
        self.push(PickleValue::Int(value as i64));
        Ok(())
    }

    fn long(&mut self, width: usize) -> Step<()> {
        let length = self.program.integer(width)?;
        let bytes = self.program.take(length)?.to_vec();
        let negative = bytes.last().is_some_and(|last| last & 0x80 != 0);
        let mut extended = [if negative { 0xff } else { 0 }; 8];
        self.push(match bytes.len() {
            ..=8 => {
                extended[..bytes.len()].copy_from_slice(&bytes);
                PickleValue::Int(i64::from_le_bytes(extended))
            }
            _ => PickleValue::LongInt(bytes),
        });
        Ok(())
    }

    fn text(&mut self, width: usize) -> Step<()> {
        let length = self.program.integer(width)?;
        let text = utf8(self.program.take(length)?)?;
        self.push(PickleValue::Text(text));
        Ok(())
    }

    /// Pushes a byte string, in Python 2 also a text.
    fn raw(&mut self, width: usize) -> Step<()> {
        let length = self.program.integer(width)?;
        let bytes = self.program.take(length)?.to_vec();
        self.push(PickleValue::Bytes(bytes));
        Ok(())
    }

    fn top(&self) -> Step<Id> {
        match self.stack.last() {
            Some(Item::Value(id)) => Ok(*id),
            _ => Err(fault("a value was expected on the stack")),
        }
    }

    fn pop(&mut self) -> Step<Id> {
        let top = self.top()?;
        self.stack.pop();
        Ok(top)
    }

    /// Pops a copy of a text. One text can be named again and again, so that copies are limited.
    fn pop_text(&mut self) -> Step<String> {
        let id = self.pop()?;
        match &self.nodes[id.0] {
            PickleValue::Text(text) => {
                self.copied += text.len();
                if self.copied > MAX_COPIED {
                    return Err(fault(format!("more than {MAX_COPIED} bytes of names of classes")));
                }
                Ok(text.clone())
            }
            _ => Err(fault("a text was expected on the stack")),
        }
    }

    /// Pops the values above the last mark.
    fn pop_group(&mut self) -> Step<Vec<Id>> {
        let mark = self.stack.iter().rposition(|item| matches!(item, Item::Mark));
        let mark = mark.ok_or_else(|| fault("a group was closed that was not opened"))?;
        let group = self.stack.drain(mark..);
        let values = group.filter_map(|item| match item {
            Item::Value(id) => Some(id),
            Item::Mark => None,
        });
        Ok(values.collect())
    }

    fn append(&mut self, values: Vec<Id>) -> Step<()> {
        let list = self.top()?;
        match &mut self.nodes[list.0] {
            PickleValue::List(items) => items.extend(values),
            // A subclass of list, whose items nothing here reads.
            PickleValue::Call { .. } => {}
            _ => return Err(fault("items for something that is no list")),
        }
        Ok(())
    }

    fn insert(&mut self, entries: Vec<(Id, Id)>) -> Step<()> {
        let dictionary = self.top()?;
        match &mut self.nodes[dictionary.0] {
            PickleValue::Dict(items) | PickleValue::Call { items, .. } => items.extend(entries),
            _ => return Err(fault("entries for something that is no dictionary")),
        }
        Ok(())
    }

    fn memoize(&mut self, index: usize) -> Step<()> {
        let top = self.top()?;
        // Writers count up; an index beyond the values made so far would only allocate.
        if index > self.nodes.len() {
            return Err(fault(format!("value {index} is remembered out of turn")));
        }
        if index >= self.memo.len() {
            self.memo.resize(index + 1, None);
        }
        self.memo[index] = Some(top);
        Ok(())
    }

    fn recall(&mut self, index: usize) -> Step<()> {
        let id = self.memo.get(index).copied().flatten();
        let id = id.ok_or_else(|| fault(format!("value {index} was never stored")))?;
        self.stack.push(Item::Value(id));
        Ok(())
    }
}

fn pairs(values: &[Id]) -> Step<Vec<(Id, Id)>> {
    match values.as_chunks() {
        (pairs, []) => Ok(pairs.iter().map(|&[key, value]| (key, value)).collect()),
        _ => Err(fault("a key without a value")),
    }
}
