//! Access to values by field, index and type.

use std::fmt::Write;

use crate::mat::class::Storage;
use crate::mat::file::Variable;
use crate::mat::text::text_of;
use crate::mat::tree::{Content, Node};
use crate::mat::{MatClass, MatError};
use crate::number::Number;

/// A value of a MAT-file: an array, or one element of an array.
///
/// A small reference, copied at will. It knows its path, which every error carries.
#[derive(Debug, Clone, Copy)]
pub struct MatValue<'a> {
    variable: &'a Variable,
    node: u32,
    element: Option<usize>,
}

impl<'a> MatValue<'a> {
    pub(crate) fn root(variable: &'a Variable) -> Self {
        Self { variable, node: 0, element: None }
    }

    fn node(&self) -> &'a Node {
        &self.variable.tree.nodes[self.node as usize]
    }

    fn content(&self) -> Result<Content, MatError> {
        match self.node().content {
            Content::Unread => {
                Err(MatError::Unsupported { path: self.path(), class: self.class() })
            }
            content => Ok(content),
        }
    }

    /// MATLAB's class of the array.
    pub fn class(&self) -> MatClass {
        self.node().class
    }

    /// Whether the array is `logical`.
    pub fn is_logical(&self) -> bool {
        self.node().is_logical
    }

    /// Dimensions of the array, rows and columns first.
    pub fn dimensions(&self) -> Vec<usize> {
        if self.element.is_some() {
            return vec![1, 1];
        }
        let node = self.node();
        let more = self.variable.tree.more(node);
        [node.rows, node.columns].iter().chain(more).map(|&size| size as usize).collect()
    }

    /// Count of elements; characters of text are elements.
    pub fn len(&self) -> usize {
        match self.element {
            Some(_) => 1,
            None => self.variable.tree.count(self.node()),
        }
    }

    /// Whether it has no element, like unset fields in MATLAB.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the element at `index`, counted from zero in column-major order: the content of a
    /// cell, or a 1×1 array of any other class.
    ///
    /// # Errors
    /// If `index` is out of range, or the class is not read.
    pub fn index(&self, index: usize) -> Result<Self, MatError> {
        let content = self.content()?;
        if index >= self.len() {
            let (path, length) = (self.path(), self.len());
            return Err(MatError::NoElement { path, position: index + 1, length });
        }
        // The only element of an element is itself.
        let element = self.element.unwrap_or(index);
        Ok(match content {
            Content::Arrays { first, .. } if self.class() == MatClass::Cell => {
                let node = self.variable.tree.links[first + element];
                Self { node, element: None, ..*self }
            }
            _ => Self { element: Some(element), ..*self },
        })
    }

    /// Iterates over all elements, each as [`Self::index`] returns it.
    ///
    /// # Errors
    /// If the class is not read.
    pub fn elements(&self) -> Result<impl Iterator<Item = Self> + use<'a>, MatError> {
        self.content()?;
        let array = *self;
        Ok((0..array.len()).filter_map(move |index| array.index(index).ok()))
    }

    /// Names of the fields of a structure; empty for other classes.
    pub fn field_names(&self) -> &'a [String] {
        match (self.class(), self.node().content) {
            (MatClass::Struct, Content::Arrays { names, .. }) => &self.variable.tree.names[names],
            _ => &[],
        }
    }

    /// Returns the field `name` of a 1×1 structure.
    ///
    /// # Errors
    /// If it is no 1×1 structure, or has no such field.
    pub fn field(&self, name: &str) -> Result<Self, MatError> {
        self.field_if_any(name)?.ok_or_else(|| MatError::NoField {
            path: self.path(),
            field: name.to_owned(),
            known: list(self.field_names().iter().map(String::as_str)),
        })
    }

    /// Returns the field `name` if the structure has it and it is not empty.
    ///
    /// # Errors
    /// If it is no 1×1 structure.
    pub fn filled_field(&self, name: &str) -> Result<Option<Self>, MatError> {
        Ok(self.field_if_any(name)?.filter(|value| !value.is_empty()))
    }

    fn field_if_any(&self, name: &str) -> Result<Option<Self>, MatError> {
        let (MatClass::Struct, 1) = (self.class(), self.len()) else {
            return self.not("one structure");
        };
        let Content::Arrays { first, names } = self.content()? else { return Ok(None) };
        let names = &self.variable.tree.names[names];
        let Some(field) = names.iter().position(|known| known == name) else { return Ok(None) };
        let slot = self.element.unwrap_or(0) * names.len() + field;
        let node = self.variable.tree.links[first + slot];
        Ok(Some(Self { node, element: None, ..*self }))
    }

    /// Returns the value of a real 1×1 array. Integers beyond 2⁵³ are rounded.
    ///
    /// # Errors
    /// If it is not exactly one real number.
    pub fn scalar(&self) -> Result<f64, MatError> {
        self.one("one real number").map(Number::as_f64)
    }

    /// Returns the value of a 1×1 array as an integer.
    ///
    /// # Errors
    /// If it is not exactly one value, or that is no integer of 64 bits.
    pub fn integer(&self) -> Result<i64, MatError> {
        self.one("one integer")?.as_i64().map_or_else(|| self.not("one integer"), Ok)
    }

    /// Returns all values in column-major order. Integers beyond 2⁵³ are rounded.
    ///
    /// # Errors
    /// If they are no real numbers.
    pub fn values(&self) -> Result<Vec<f64>, MatError> {
        Ok(self.stored("real numbers")?.map(Number::as_f64).collect())
    }

    /// Returns all values as integers, in column-major order.
    ///
    /// # Errors
    /// If one is no integer of 64 bits.
    pub fn integers(&self) -> Result<Vec<i64>, MatError> {
        let values = self.stored("integers")?;
        values.map(|value| value.as_i64().map_or_else(|| self.not("integers"), Ok)).collect()
    }

    /// Returns text of one line or none.
    ///
    /// # Errors
    /// If it is no text, has several lines, or is no valid Unicode.
    pub fn text(&self) -> Result<String, MatError> {
        const LINE: &str = "one line of text";
        let node = self.node();
        if self.class() != MatClass::Char || self.element.is_some() {
            return self.not(LINE);
        }
        match self.content()? {
            Content::Data { storage, start, length } if node.rows == 1 => {
                let bytes = &self.variable.bytes[start..start + length];
                text_of(bytes, storage, self.variable.order).map_or_else(|| self.not(LINE), Ok)
            }
            Content::Nothing => Ok(String::new()),
            _ => self.not(LINE),
        }
    }

    fn one(&self, expected: &'static str) -> Result<Number, MatError> {
        let mut values = self.stored(expected)?;
        match (values.next(), values.next()) {
            (Some(value), None) => Ok(value),
            _ => self.not(expected),
        }
    }

    fn stored(
        &self,
        expected: &'static str,
    ) -> Result<impl Iterator<Item = Number> + use<'a>, MatError> {
        let class = self.class();
        if matches!(class, MatClass::Cell | MatClass::Struct | MatClass::Char)
            || self.node().is_complex
        {
            return self.not(expected);
        }
        let (storage, bytes): (Storage, &'a [u8]) = match self.content()? {
            Content::Data { storage, start, length } => {
                let bytes = &self.variable.bytes[start..start + length];
                let size = storage.size();
                let element = |element: usize| &bytes[element * size..(element + 1) * size];
                (storage, self.element.map_or(bytes, element))
            }
            // Of an empty array nothing is stored.
            _ => (Storage::U8, &[]),
        };
        let order = self.variable.order;
        Ok(bytes.chunks_exact(storage.size()).map(move |bytes| storage.decode(bytes, order)))
    }

    /// The error for a value of another kind than expected.
    fn not<T>(&self, expected: &'static str) -> Result<T, MatError> {
        self.content()?;
        Err(MatError::Kind { path: self.path(), expected, actual: self.description() })
    }

    fn description(&self) -> String {
        let sizes: Vec<String> = self.dimensions().iter().map(ToString::to_string).collect();
        let complex = if self.node().is_complex { "complex " } else { "" };
        format!("{} of {complex}{}", self.class(), sizes.join("×"))
    }

    /// Path of the value in MATLAB's notation, counted from one: `RELEASE.annolist(12).annorect`.
    pub fn path(&self) -> String {
        let tree = &self.variable.tree;
        let mut steps = Vec::new();
        let mut id = self.node;
        // The root has no parent; its name is the variable's.
        while id != 0 {
            let node = &tree.nodes[id as usize];
            steps.push((&tree.nodes[node.parent as usize], node.slot as usize));
            id = node.parent;
        }
        let mut path = self.variable.name.clone();
        // Writing to a string cannot fail.
        for (array, slot) in steps.into_iter().rev() {
            match array.content {
                Content::Arrays { names, .. } if array.class == MatClass::Struct => {
                    let names = &tree.names[names];
                    if tree.count(array) > 1 {
                        let _ = write!(path, "({})", slot / names.len() + 1);
                    }
                    let _ = write!(path, ".{}", names[slot % names.len()]);
                }
                _ => {
                    let _ = write!(path, "{{{}}}", slot + 1);
                }
            }
        }
        // A single value needs no index.
        if let Some(element) = self.element.filter(|_| tree.count(self.node()) > 1) {
            let _ = write!(path, "({})", element + 1);
        }
        path
    }
}

/// Formats names for an error message.
pub(crate) fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
