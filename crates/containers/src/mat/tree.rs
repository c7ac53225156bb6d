//! Arrays as a tree of small nodes over the bytes of a variable: values and text are not copied.
//!
//! A structure of a million scalar fields takes a node for each and nothing more.

use std::collections::HashMap;

use crate::mat::MatError;
use crate::mat::class::{MatClass, Storage};
use crate::mat::element::{Element, MATRIX, Reader};

/// Maximal depth of nested arrays; reading recurses once a level.
pub(crate) const DEPTH_LIMIT: usize = 64;
/// Maximal count of structures without any field: they take no bytes, so that only a limit bounds
/// loops over them.
const FIELDLESS_LIMIT: usize = 1 << 16;

const INT32: u32 = 5;
const UINT32: u32 = 6;
const COMPLEX: u32 = 0x800;
const LOGICAL: u32 = 0x200;

/// Content of an array.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Content {
    /// Values or text, as bytes from `start` on.
    Data { storage: Storage, start: usize, length: usize },
    /// Arrays: links from `first` on, and the index of their set of names in structures.
    Arrays { first: usize, names: usize },
    /// No element.
    Nothing,
    /// Content of a class that is not read.
    Unread,
}

/// An array of the tree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    /// Index of the array that holds it; itself at the root.
    pub(crate) parent: u32,
    /// Its index among the arrays of the parent.
    pub(crate) slot: u32,
    pub(crate) rows: u32,
    pub(crate) columns: u32,
    /// One more than the index of its further dimensions behind these two; zero without any.
    pub(crate) more: u32,
    pub(crate) class: MatClass,
    pub(crate) is_logical: bool,
    pub(crate) is_complex: bool,
    pub(crate) content: Content,
}

/// All arrays of a variable; the first is the variable itself.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    pub(crate) links: Vec<u32>,
    pub(crate) names: Vec<Vec<String>>,
    pub(crate) more_dimensions: Vec<Vec<u32>>,
}

impl Tree {
    /// Count of elements of an array.
    pub(crate) fn count(&self, node: &Node) -> usize {
        if matches!(node.content, Content::Nothing) {
            return 0;
        }
        // Reading has checked that the product does not overflow.
        let two = node.rows as usize * node.columns as usize;
        self.more(node).iter().fold(two, |count, &size| count * size as usize)
    }

    pub(crate) fn more(&self, node: &Node) -> &[u32] {
        match node.more {
            0 => &[],
            index => &self.more_dimensions[index as usize - 1],
        }
    }
}

/// Reads the name and the arrays of a variable.
pub(crate) fn read_tree(reader: Reader<'_>, element: &Element) -> Result<(String, Tree), MatError> {
    let mut builder = Builder { reader, tree: Tree::default(), known_names: HashMap::new() };
    let (_, name) = builder.matrix(element, 0, 0, 0)?;
    Ok((name, builder.tree))
}

struct Builder<'a> {
    reader: Reader<'a>,
    tree: Tree,
    /// Indices of sets of names by the length of a name and their bytes: most structures share one
    /// set.
    known_names: HashMap<(usize, &'a [u8]), usize>,
}

impl<'a> Builder<'a> {
    fn malformed<T>(&self, at: usize, reason: impl Into<String>) -> Result<T, MatError> {
        Err(self.reader.origin.malformed(at, reason))
    }

    /// Reads an array with all nested ones; returns its index and its name.
    fn matrix(
        &mut self,
        element: &Element,
        parent: u32,
        slot: u32,
        depth: usize,
    ) -> Result<(u32, String), MatError> {
        if element.kind != MATRIX {
            let reason = format!("an array is expected, this is of type {}", element.kind);
            return self.malformed(element.tag, reason);
        }
        if depth > DEPTH_LIMIT {
            let at = self.reader.origin.position(element.tag);
            return Err(MatError::TooDeep { at, limit: DEPTH_LIMIT });
        }
        let Ok(id) = u32::try_from(self.tree.nodes.len()) else {
            return self.malformed(element.tag, "more than 2³² arrays");
        };
        let mut node = Node {
            parent,
            slot,
            rows: 0,
            columns: 0,
            more: 0,
            class: MatClass::F64,
            is_logical: false,
            is_complex: false,
            content: Content::Nothing,
        };
        // Its index first, since nested arrays refer to it.
        self.tree.nodes.push(node);
        if element.length == 0 {
            return Ok((id, String::new()));
        }
        let mut parts = self.reader.within(element.start, element.end());
        let flags = self.flags(&mut parts)?;
        let Some(class) = MatClass::from_code(flags as u8) else {
            return self.malformed(element.start, format!("no array is of class {}", flags as u8));
        };
        node.class = class;
        node.is_logical = flags & LOGICAL != 0;
        node.is_complex = flags & COMPLEX != 0;
        let mut count = 0;
        // An opaque object has no sizes.
        if class != MatClass::Opaque {
            count = self.dimensions(&mut parts, &mut node)?;
        }
        let name = self.name(&mut parts)?;
        node.content = match class {
            _ if !class.is_read() => Content::Unread,
            MatClass::Cell => self.arrays(&mut parts, id, count, 0, depth)?,
            MatClass::Struct => self.structures(&mut parts, id, count, depth)?,
            _ => self.data(&mut parts, class, count)?,
        };
        self.tree.nodes[id as usize] = node;
        Ok((id, name))
    }

    fn flags(&self, parts: &mut Reader<'a>) -> Result<u32, MatError> {
        let element = parts.element("flags of an array")?;
        match (element.kind, parts.data(&element).first_chunk()) {
            (UINT32, Some(&bytes)) if element.length == 8 => Ok(parts.order.u32(bytes)),
            _ => self.malformed(element.tag, "flags of an array are expected: two uint32"),
        }
    }

    /// Reads the dimensions of an array into `node` and returns the count of elements.
    fn dimensions(&mut self, parts: &mut Reader<'a>, node: &mut Node) -> Result<usize, MatError> {
        let element = parts.element("the size of an array")?;
        let sizes = integers(parts, &element);
        let (Some(&[rows, columns, ref more @ ..]), INT32 | UINT32) =
            (sizes.as_deref(), element.kind)
        else {
            return self
                .malformed(element.tag, "the size of an array is expected: two or more int32");
        };
        // Sizes are signed in the format.
        if let Some(size) = sizes.iter().flatten().find(|&&size| size > i32::MAX as u32) {
            return self.malformed(element.tag, format!("a size of {}", *size as i32));
        }
        let count = |sizes: &[u32]| {
            sizes.iter().try_fold(1_usize, |count, &size| count.checked_mul(size as usize))
        };
        // Without those that are zero, so that no partial product overflows.
        let nonzero: Vec<u32> = sizes.iter().flatten().copied().filter(|&size| size > 0).collect();
        let Some(full) = count(&nonzero) else {
            return self.malformed(element.tag, "more elements than can be counted");
        };
        (node.rows, node.columns) = (rows, columns);
        if !more.is_empty() {
            self.tree.more_dimensions.push(more.to_vec());
            node.more = self.tree.more_dimensions.len() as u32;
        }
        let is_empty = sizes.iter().flatten().any(|&size| size == 0);
        Ok(if is_empty { 0 } else { full })
    }

    fn name(&self, parts: &mut Reader<'a>) -> Result<String, MatError> {
        let element = parts.element("the name of an array")?;
        match std::str::from_utf8(parts.data(&element)) {
            Ok(name) if matches!(element.kind, 1 | 2 | 16) => Ok(name.to_owned()),
            _ => self.malformed(element.tag, "the name of an array is expected: int8"),
        }
    }

    fn data(
        &self,
        parts: &mut Reader<'a>,
        class: MatClass,
        count: usize,
    ) -> Result<Content, MatError> {
        if count == 0 {
            return Ok(Content::Nothing);
        }
        let element = parts.element("the values of an array")?;
        let storage = Storage::from_code(element.kind)
            .filter(|storage| class == MatClass::Char || !storage.is_text());
        let Some(storage) = storage.filter(|storage| fits(class, *storage)) else {
            let reason = format!("{class} stored as type {}", element.kind);
            return self.malformed(element.tag, reason);
        };
        // Some files of MATLAB have texts of blanks of which nothing is stored.
        if class == MatClass::Char && element.length == 0 {
            return Ok(Content::Nothing);
        }
        // Letters of UTF-8 take as many bytes as they need, one at least.
        let is_whole = match storage {
            Storage::Utf8 => count <= element.length,
            _ => count.checked_mul(storage.size()) == Some(element.length),
        };
        if !is_whole {
            let reason =
                format!("{count} elements are expected, there are {} bytes", element.length);
            return self.malformed(element.tag, reason);
        }
        Ok(Content::Data { storage, start: element.start, length: element.length })
    }

    fn structures(
        &mut self,
        parts: &mut Reader<'a>,
        id: u32,
        count: usize,
        depth: usize,
    ) -> Result<Content, MatError> {
        let element = parts.element("the length of names of fields")?;
        // All names have the same room, padded with zeros.
        let room = match (element.kind, integers(parts, &element).as_deref()) {
            (INT32, Some(&[room])) if room > 0 && room <= i32::MAX as u32 => room as usize,
            _ => return self.malformed(element.tag, "the length of names of fields is expected"),
        };
        let element = parts.element("names of fields")?;
        let bytes = parts.data(&element);
        // Nested structures repeat the names of those before them; each set is stored once.
        let names = match self.known_names.get(&(room, bytes)) {
            Some(&names) => names,
            None => {
                let Some(names) = names_of(bytes, room) else {
                    let reason = format!("names of fields of {room} bytes each are expected");
                    return self.malformed(element.tag, reason);
                };
                self.tree.names.push(names);
                self.known_names.insert((room, bytes), self.tree.names.len() - 1);
                self.tree.names.len() - 1
            }
        };
        let fields = self.tree.names[names].len();
        // A few bytes could state billions of them.
        if fields == 0 && count > FIELDLESS_LIMIT {
            return self.malformed(element.tag, format!("{count} structures without any field"));
        }
        let Some(arrays) = count.checked_mul(fields) else {
            return self.malformed(element.tag, "more fields than can be counted");
        };
        self.arrays(parts, id, arrays, names, depth)
    }

    fn arrays(
        &mut self,
        parts: &mut Reader<'a>,
        id: u32,
        count: usize,
        names: usize,
        depth: usize,
    ) -> Result<Content, MatError> {
        let left = parts.end - parts.at;
        // Each array has a tag of eight bytes, which bounds the count before anything is allocated.
        if count > left / 8 {
            return self.malformed(parts.at, format!("{count} arrays cannot be in {left} bytes"));
        }
        // Links of one array lie next to each other, though nested arrays come between.
        let first = self.tree.links.len();
        self.tree.links.resize(first + count, 0);
        for slot in 0..count {
            let element = parts.element("an array")?;
            let (child, _) = self.matrix(&element, id, slot as u32, depth + 1)?;
            self.tree.links[first + slot] = child;
        }
        Ok(Content::Arrays { first, names })
    }
}

/// Decodes integers of 32 bits; none if the length is no multiple of four bytes.
fn integers(reader: &Reader<'_>, element: &Element) -> Option<Vec<u32>> {
    let (words, rest) = reader.data(element).as_chunks::<4>();
    rest.is_empty().then(|| words.iter().map(|&word| reader.order.u32(word)).collect())
}

fn names_of(bytes: &[u8], room: usize) -> Option<Vec<String>> {
    if !bytes.len().is_multiple_of(room) {
        return None;
    }
    let name = |bytes: &[u8]| {
        let name = bytes.split(|&byte| byte == 0).next()?;
        std::str::from_utf8(name).ok().map(str::to_owned)
    };
    bytes.chunks_exact(room).map(name).collect()
}

/// Whether values of a class may be stored as this type: integers are never stored as floats.
fn fits(class: MatClass, storage: Storage) -> bool {
    matches!(class, MatClass::F32 | MatClass::F64)
        || !matches!(storage, Storage::F32 | Storage::F64)
}
