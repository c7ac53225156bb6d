//! ROS 2 bags in SQLite: a table of topics, and one of messages in the order of their arrival.
//!
//! The tables are read from the pages of the file, without SQLite's C library: memory is bounded and
//! damage has its place. A page is a node of a tree; its cells are rows, and what of a row does not fit
//! goes on in a chain of pages.
//!
//! # Source
//! <https://www.sqlite.org/fileformat2.html>; <https://github.com/ros2/rosbag2>, `rosbag2_storage_sqlite3`

use super::fields::{Reason, Serialisation};
use super::file::{Bytes, Fault, MessageFile, MessageVisitor, NextUnit, Topic, add_topic};
use crate::Input;

/// How the files begin.
pub(super) const MAGIC: &[u8] = b"SQLite format 3\0";
/// Bytes of the header of a file, which the first page begins with.
const HEAD: usize = 100;
/// Types of pages of tables.
const INNER: u8 = 5;
const LEAF: u8 = 13;
/// Places of units are so far apart, so that marks of a seek are a few pages of rows apart.
const APART: u64 = 1 << 20;

/// Takes a row: its number, and its values.
type RowVisitor<'a> = dyn FnMut(i64, &[Value<'_>]) -> Result<(), Reason> + 'a;

/// A ROS 2 bag in SQLite.
pub(super) struct Sqlite {
    bytes: Bytes,
    /// Bytes of a page, and of them those in use.
    page: u64,
    usable: usize,
    buffer: Vec<u8>,
    row: Vec<u8>,
    /// Pages with rows of messages.
    leaves: Vec<u32>,
    /// Ends the messages, behind those of the leaves.
    fault: Option<Fault>,
}

/// A value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Value<'a> {
    Other,
    Whole(i64),
    Bytes(&'a [u8]),
}

impl Value<'_> {
    fn text(self) -> String {
        match self {
            Self::Bytes(bytes) => String::from_utf8_lossy(bytes).into_owned(),
            _ => String::new(),
        }
    }
}

impl Sqlite {
    pub(super) fn new(input: Input) -> Self {
        let (buffer, row, leaves) = (Vec::new(), Vec::new(), Vec::new());
        let bytes = Bytes::new(input);
        Self { bytes, page: 0, usable: 0, buffer, row, leaves, fault: None }
    }

    /// Finds the tables; returns the topics and the count of messages of each, by number.
    fn read_tables(&mut self, topics: &mut Vec<Topic>) -> Result<(), Fault> {
        self.bytes.read((0, 0), HEAD as u64, &mut self.buffer)?;
        let size = u16::from_be_bytes([self.buffer[16], self.buffer[17]]);
        self.page = if size == 1 { 1 << 16 } else { u64::from(size) };
        self.usable = (self.page as usize).saturating_sub(usize::from(self.buffer[20]));
        // SQLite allows no page below 512 bytes, and none with fewer than 480 usable ones.
        if self.page < 512 || self.usable < 480 {
            return Err(Fault::damage(0, "no size of pages of SQLite"));
        }
        let (mut of_topics, mut of_messages) = (0, 0);
        self.rows(1, &mut |_, values| {
            // The table of tables: type, name, table, first page.
            if let [kind, name, _, Value::Whole(page), ..] = values
                && kind.text() == "table"
            {
                let page = u32::try_from(*page).unwrap_or(0);
                match name.text().as_str() {
                    "topics" => of_topics = page,
                    "messages" => of_messages = page,
                    _ => {}
                }
            }
            Ok(())
        })?;
        if of_topics == 0 || of_messages == 0 {
            let reason = "an SQLite database without the tables of a ROS 2 bag: it holds no events";
            return Err(Fault::Stranger(reason.into()));
        }
        self.rows(of_topics, &mut |id, values| {
            if let [_, name, kind, ..] = values {
                let (name, kind) = (name.text(), kind.text());
                let (serialisation, ids) = (Serialisation::Cdr, vec![id as u32]);
                topics.push(Topic { name, kind, serialisation, ids, messages: 0 });
            }
            Ok(())
        })?;
        // Behind a fault, the leaves before it count all the same.
        let mut leaves = Vec::new();
        let mut fault = self.find_leaves(of_messages, &mut leaves).err();
        for page in &leaves {
            let read = self.leaf(*page, false, &mut |_, values| {
                if let [_, Value::Whole(id), ..] = values {
                    let is_its = |topic: &&mut Topic| topic.ids.contains(&(*id as u32));
                    topics.iter_mut().find(is_its).into_iter().for_each(|t| t.messages += 1);
                }
                Ok(())
            });
            if let Err(ends) = read {
                fault = Some(ends);
                break;
            }
        }
        self.leaves = leaves;
        fault.map_or(Ok(()), Err)
    }

    /// Visits all rows of a table.
    fn rows(&mut self, root: u32, visit: &mut RowVisitor<'_>) -> Result<(), Fault> {
        let mut leaves = Vec::new();
        self.find_leaves(root, &mut leaves)?;
        leaves.into_iter().try_for_each(|page| self.leaf(page, true, visit))
    }

    /// Appends the leaves below a page, in the order of their rows. A damaged page stands for one: its
    /// fault is met where its rows are read.
    fn find_leaves(&mut self, root: u32, leaves: &mut Vec<u32>) -> Result<(), Fault> {
        // The pages that are next, the last one first; no page of a tree is met twice.
        let (mut ahead, mut left) = (vec![root], self.bytes.length / self.page + 1);
        while let Some(page) = ahead.pop() {
            let begin = self.load(page).map(|(_, begin)| begin);
            let circle = || Fault::damage(0, "pages that lead to each other");
            left = left.checked_sub(1).ok_or_else(circle)?;
            match begin.ok().and_then(|begin| self.children(begin)) {
                Some(children) => ahead.extend(children),
                None => leaves.push(page),
            }
        }
        Ok(())
    }

    /// Pages below the loaded one, the last one first; none if it is a leaf or damaged.
    fn children(&self, begin: usize) -> Option<Vec<u32>> {
        let number = |place: usize| {
            let four = self.buffer.get(place..).and_then(<[u8]>::first_chunk);
            four.map(|four| u32::from_be_bytes(*four))
        };
        let cells = (0..self.cells(begin)?).rev().map(|k| number(self.pointer(begin + 12, k)?));
        let children = [number(begin + 8)].into_iter().chain(cells).collect();
        if self.buffer[begin] == INNER { children } else { None }
    }

    /// Count of cells of the loaded page.
    fn cells(&self, begin: usize) -> Option<usize> {
        let two = self.buffer.get(begin + 3..)?.first_chunk()?;
        Some(u16::from_be_bytes(*two).into())
    }

    /// Reads a page; returns its place, and where in it the node begins.
    fn load(&mut self, page: u32) -> Result<(u64, usize), Fault> {
        let at = u64::from(page.wrapping_sub(1)) * self.page;
        self.bytes.read((at, at), self.page, &mut self.buffer)?;
        Ok((at, if page == 1 { HEAD } else { 0 }))
    }

    /// Place of a cell in the page.
    fn pointer(&self, begin: usize, cell: usize) -> Option<usize> {
        let two = self.buffer.get(begin + 2 * cell..)?.first_chunk()?;
        Some(u16::from_be_bytes(*two).into())
    }

    /// Visits the rows of a leaf; unless `is_whole`, with the values that the page itself has.
    fn leaf(&mut self, page: u32, is_whole: bool, visit: &mut RowVisitor<'_>) -> Result<(), Fault> {
        let (at, begin) = self.load(page)?;
        let damage = |reason: Reason| Fault::damage(at, reason);
        let outside = || damage("a row outside of its page".into());
        if self.buffer[begin] != LEAF {
            return Err(damage("a page that is none of a table".into()));
        }
        for cell in 0..self.cells(begin).ok_or_else(outside)? {
            // Chains of pages take the buffer.
            if cell > 0 && is_whole {
                self.load(page)?;
            }
            let cell = self.pointer(begin + 8, cell).and_then(|place| self.buffer.get(place..));
            let mut cell = cell.ok_or_else(outside)?;
            let (length, id) = varint(&mut cell).zip(varint(&mut cell)).ok_or_else(outside)?;
            let local = self.local(length);
            let here = cell.get(..local).ok_or_else(outside)?;
            self.row.clear();
            self.row.extend_from_slice(here);
            if length > local as u64 && is_whole {
                let next = cell.get(local..).and_then(<[u8]>::first_chunk);
                let next = u32::from_be_bytes(*next.ok_or_else(outside)?);
                self.chain(next, length, at)?;
            }
            let values = values(&self.row, is_whole).ok_or_else(outside)?;
            visit(id.cast_signed(), &values).map_err(damage)?;
        }
        Ok(())
    }

    /// Bytes of a row that stand in its page.
    fn local(&self, length: u64) -> usize {
        let (usable, most) = (self.usable as u64, self.usable as u64 - 35);
        let least = (usable - 12) * 32 / 255 - 23;
        let some = least + length.saturating_sub(least) % (usable - 4);
        (if length <= most {
            length
        } else if some <= most {
            some
        } else {
            least
        }) as usize
    }

    /// Appends what of a row stands in other pages.
    fn chain(&mut self, mut next: u32, length: u64, row: u64) -> Result<(), Fault> {
        // Before memory is asked for.
        if length > self.bytes.length {
            return Err(Fault::damage(row, "a row longer than the file"));
        }
        while (self.row.len() as u64) < length {
            if next == 0 {
                return Err(Fault::damage(row, "a row ends before its length"));
            }
            self.load(next)?;
            next = self.buffer.first_chunk().map_or(0, |four| u32::from_be_bytes(*four));
            let rest = (length - self.row.len() as u64).min(self.usable as u64 - 4) as usize;
            self.row.extend_from_slice(&self.buffer[4..4 + rest]);
        }
        Ok(())
    }
}

impl MessageFile for Sqlite {
    fn kind(&self) -> &'static str {
        "bag of ROS 2 in SQLite"
    }

    fn topics(&mut self) -> (Vec<Topic>, Option<Fault>) {
        let (mut all, mut topics) = (Vec::new(), Vec::new());
        let fault = self.read_tables(&mut all).err();
        self.fault = fault.as_ref().map(Fault::again);
        all.into_iter().for_each(|topic| add_topic(&mut topics, topic));
        (topics, fault)
    }

    fn begin(&self) -> u64 {
        0
    }

    fn unit(&mut self, at: u64, ids: &[u32], take: &mut MessageVisitor<'_>) -> NextUnit {
        let Some(page) = self.leaves.get((at / APART) as usize).copied() else {
            return self.fault.as_ref().map_or(Ok(None), |fault| Err(fault.again()));
        };
        self.leaf(page, true, &mut |_, values| match values {
            [_, Value::Whole(id), _, Value::Bytes(data), ..] if ids.contains(&(*id as u32)) => {
                take(data)
            }
            _ => Ok(()),
        })?;
        Ok(Some(at + APART))
    }
}

/// Takes a number of one to nine bytes.
fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for k in 0..9 {
        let byte = *bytes.split_off_first()?;
        // The ninth byte holds eight bits, the others seven.
        if k == 8 {
            return Some(value << 8 | u64::from(byte));
        }
        value = value << 7 | u64::from(byte & 0x7F);
        if byte < 0x80 {
            break;
        }
    }
    Some(value)
}

/// The values of a row; of one that goes on elsewhere, those up to there unless it `is_whole`.
fn values(row: &[u8], is_whole: bool) -> Option<Vec<Value<'_>>> {
    let mut head = row;
    let length = usize::try_from(varint(&mut head)?).ok()?;
    let mut types = row.get(row.len() - head.len()..length)?;
    let (mut body, mut values) = (&row[length..], Vec::new());
    while !types.is_empty() {
        let kind = varint(&mut types)?;
        let length = match kind {
            0 | 8 | 9 => 0,
            1..=4 => kind as usize,
            5 => 6,
            6 | 7 => 8,
            _ => usize::try_from(kind.checked_sub(12)? / 2).ok()?,
        };
        // What a row lacks that is not read whole is in other pages.
        let Some(bytes) = body.split_off(..length) else {
            return (!is_whole).then_some(values);
        };
        values.push(match kind {
            0 | 7 => Value::Other,
            // Of these types the type itself is the value, 0 or 1.
            8 | 9 => Value::Whole(kind as i64 - 8),
            1..=6 => {
                let first = bytes[0].cast_signed();
                let rest = bytes[1..].iter();
                Value::Whole(rest.fold(first.into(), |value, byte| value << 8 | i64::from(*byte)))
            }
            _ => Value::Bytes(bytes),
        });
    }
    Some(values)
}
