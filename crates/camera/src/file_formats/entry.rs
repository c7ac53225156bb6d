//! Entries of YAML and XML files, in their order.

use std::collections::HashMap;
use std::fmt;

use roxmltree::{Document, Node};
use saphyr::{LoadableYamlNode as _, MarkedYaml, Scalar, YamlData};

use super::invalid;
use crate::CalibrationError;

/// Levels of blocks in YAML: as many as the parser allows of brackets.
const MAX_DEPTH: usize = 255;

/// A scalar of a file, or a list of scalars.
pub(super) struct Entry {
    /// Keys of the entries around it, with dots between them, and with indices where several share one:
    /// `cameras[1].camera`.
    pub(super) above: String,
    pub(super) key: String,
    /// From 1.
    line: usize,
    /// Rows of a matrix one after the other.
    pub(super) words: Vec<String>,
}

impl Entry {
    fn new(path: &[&str], line: usize, words: Vec<String>) -> Self {
        // Values of OpenCV's and ROS's matrices are in an entry below the matrix.
        let path = path.strip_suffix(&["data"]).unwrap_or(path);
        let (key, above) = path.split_last().unwrap_or((&"", &[]));
        Self { above: above.join("."), key: (*key).to_owned(), line, words }
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let dot = if self.above.is_empty() { "" } else { "." };
        write!(f, "line {}: {}{dot}{}", self.line, self.above, self.key)
    }
}

/// The entries of the first document of YAML.
pub(super) fn of_yaml(text: &str) -> Result<Vec<Entry>, CalibrationError> {
    // OpenCV's directive has a colon that YAML refuses. As a comment it keeps its line.
    let text = text.replacen("%YAML:", "#YAML:", 1);
    // The parser descends for each level of blocks, of which each is a column to the right.
    let depth = |line: &str| line.len() - line.trim_start_matches([' ', '-', '?', ':']).len();
    if text.lines().any(|line| depth(line) > MAX_DEPTH) {
        return Err(invalid(format!("more than {MAX_DEPTH} levels")));
    }
    let documents = MarkedYaml::load_from_str(&text).map_err(invalid)?;
    let mut entries = Vec::new();
    if let Some(root) = documents.first() {
        add_yaml(root, &[], 1, &mut entries);
    }
    Ok(entries)
}

fn add_yaml(node: &MarkedYaml<'_>, path: &[&str], line: usize, entries: &mut Vec<Entry>) {
    match &node.data {
        YamlData::Mapping(below) => {
            for (key, value) in below {
                let name = scalars(key).concat();
                add_yaml(value, &[path, &[&name]].concat(), key.span.start.line(), entries);
            }
        }
        YamlData::Tagged(_, node) => add_yaml(node, path, line, entries),
        // Cameras in a list, as rpg's programs write them: an index keeps their keys apart.
        YamlData::Sequence(nodes) if nodes.iter().all(|node| node.data.is_mapping()) => {
            let (list, above) = path.split_last().unwrap_or((&"", &[]));
            for (k, node) in nodes.iter().enumerate() {
                add_yaml(node, &[above, &[&format!("{list}[{k}]")]].concat(), line, entries);
            }
        }
        _ => entries.push(Entry::new(path, line, scalars(node))),
    }
}

fn scalars(node: &MarkedYaml<'_>) -> Vec<String> {
    match &node.data {
        YamlData::Sequence(nodes) => nodes.iter().flat_map(scalars).collect(),
        YamlData::Tagged(_, node) => scalars(node),
        YamlData::Value(Scalar::String(word)) => vec![word.to_string()],
        YamlData::Value(Scalar::Integer(number)) => vec![number.to_string()],
        YamlData::Value(Scalar::FloatingPoint(number)) => vec![number.to_string()],
        YamlData::Value(Scalar::Boolean(value)) => vec![value.to_string()],
        _ => vec![],
    }
}

/// The entries of XML, without its root.
pub(super) fn of_xml(text: &str) -> Result<Vec<Entry>, CalibrationError> {
    let document = Document::parse(text).map_err(invalid)?;
    // Elements of one name beside each other are a list, as OpenCV's `_`: an index keeps them apart.
    let (mut names, mut counts) = (HashMap::new(), HashMap::new());
    let mut entries = Vec::new();
    for element in document.descendants().filter(Node::is_element) {
        let tag = element.tag_name().name();
        let count = counts.entry((element.parent().map(|around| around.id()), tag)).or_insert(0);
        let name = if *count == 0 { tag.to_owned() } else { format!("{tag}[{count}]") };
        *count += 1;
        names.insert(element.id(), name);
        // A comment divides a text.
        let texts = element.children().filter(Node::is_text).filter_map(|node| node.text());
        let words: Vec<_> = texts.flat_map(str::split_whitespace).map(str::to_owned).collect();
        // An element around others has no words of its own.
        if !words.is_empty() {
            let around = element.ancestors().filter_map(|around| names.get(&around.id()));
            let mut path: Vec<&str> = around.map(String::as_str).collect();
            path.pop();
            path.reverse();
            let line = document.text_pos_at(element.range().start).row as usize;
            entries.push(Entry::new(&path, line, words));
        }
    }
    Ok(entries)
}
