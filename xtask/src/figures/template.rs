//! A template: which files, and the text with places for their values.
//!
//! ```text
//! home = benches/accuracy/home.json /networks
//!
//! | `body` | {home/name=body/raw/auc .3} |
//! ```
//!
//! A place is `{FILE/PATH FORMAT}`, or `{FILE/PATH over FILE/PATH FORMAT}`; `or TEXT` before the format is
//! written where the value is absent.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use super::link;
use super::lookup::{self, Format};

/// Fields that say where a result comes from.
const ORIGIN: [&str; 5] = ["commit", "version", "date", "command", "machine"];

struct Source {
    alias: String,
    file: String,
    /// Path that those of places begin with.
    prefix: String,
}

pub(super) struct Template {
    sources: Vec<Source>,
    /// Stored results by file.
    stored: BTreeMap<String, Value>,
    text: String,
}

impl Template {
    pub(super) fn read(path: &str) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("reading {path}"))?;
        let (head, text) = text.split_once("\n\n").context("no empty line behind the files")?;
        let sources = head.lines().map(source).collect::<Result<Vec<_>>>()?;
        let mut stored = BTreeMap::new();
        for Source { file, .. } in &sources {
            let bytes = std::fs::read(file).with_context(|| format!("reading {file}"))?;
            let value: Value = serde_json::from_slice(&bytes).with_context(|| file.clone())?;
            // Nobody could measure a figure again whose commit, command or machine is unknown.
            let missing: Vec<_> = ORIGIN.iter().filter(|field| value[**field].is_null()).collect();
            ensure!(missing.is_empty(), "{file} does not say {missing:?}");
            stored.insert(file.clone(), value);
        }
        Ok(Self { sources, stored, text: text.to_owned() })
    }

    /// The files, each once.
    pub(super) fn files(&self) -> impl Iterator<Item = &str> {
        self.stored.keys().map(String::as_str)
    }

    /// The text for a page, and where its values come from.
    pub(super) fn expanded(&self, page: &str) -> Result<String> {
        let mut text = String::new();
        let mut rest = self.text.as_str();
        while let Some((before, behind)) = rest.split_once('{') {
            let (place, behind) = behind.split_once('}').context("a `{` without its `}`")?;
            text += before;
            text += &self.place(place).with_context(|| format!("{{{place}}}"))?;
            rest = behind;
        }
        text += rest;
        let origins: Vec<String> =
            self.stored.iter().map(|(file, value)| origin(page, file, value)).collect();
        Ok(format!("{}\n\n{}\n", text.trim_end(), origins.join("\n")))
    }

    fn place(&self, place: &str) -> Result<String> {
        // A place is read from its end, since the text behind `or` may hold spaces itself.
        let (place, format) = match place.rsplit_once(' ').map(|(a, b)| (a, Format::parse(b))) {
            Some((place, Some(format))) => (place, Some(format)),
            _ => (place, None),
        };
        let (place, absent) = match place.rsplit_once(" or ") {
            Some((place, absent)) => (place, Some(absent)),
            None => (place, None),
        };
        if let Some((above, below)) = place.split_once(" over ") {
            let number = |path| {
                let value = self.value(path)?.and_then(Value::as_f64);
                value.with_context(|| format!("{path}: no number"))
            };
            return format.context("no format")?.number(number(above)? / number(below)?);
        }
        match (self.value(place)?, absent) {
            (Some(value), _) => lookup::text(value, format),
            (None, Some(absent)) => Ok(absent.to_owned()),
            (None, None) => bail!("not stored"),
        }
    }

    fn value(&self, place: &str) -> Result<Option<&Value>> {
        let (alias, path) = place.split_once('/').context("no path")?;
        let source = self.sources.iter().find(|source| source.alias == alias);
        let source = source.with_context(|| format!("no file is called `{alias}`"))?;
        Ok(lookup::value(&self.stored[&source.file], &format!("{}/{path}", source.prefix)))
    }
}

/// A line `ALIAS = FILE PREFIX`.
fn source(line: &str) -> Result<Source> {
    let (alias, file) = line.split_once(" = ").with_context(|| format!("`{line}`: no file"))?;
    let (file, prefix) = file.split_once(' ').unwrap_or((file, ""));
    ensure!(file.starts_with("benches/"), "{file}: results are stored below benches/");
    Ok(Source { alias: alias.to_owned(), file: file.to_owned(), prefix: prefix.to_owned() })
}

/// A line that says where a result comes from.
fn origin(page: &str, file: &str, value: &Value) -> String {
    let part = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let machine = &value["machine"];
    let mut text = format!(
        "<sub>[{file}]({}): {}, {} threads, version {} at commit {}, {}",
        link(page, file),
        part(&machine["cpu"]),
        machine["threads"],
        part(&value["version"]),
        part(&value["commit"]),
        part(&value["date"]),
    );
    // Accuracy does not depend on what else the machine does.
    if let Some(load) = value["load_before"].as_f64().filter(|_| file.contains("/machines/")) {
        text += &format!("; load before it {load:.1}");
    }
    for more in [&machine["gpu"], &value["adapter"], &value["note"]] {
        if let Some(more) = more.as_str() {
            text += &format!("; {more}");
        }
    }
    if let Some(peers) = value["peers"].as_object() {
        for (name, version) in peers {
            text += &format!("; {name} {}", part(version));
        }
    }
    text + "</sub>"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn template(text: &str) -> Template {
        let stored = serde_json::json!({
            "machine": { "cpu": "a processor", "threads": 2 }, "commit": "0123", "version": "0.1.0",
            "date": "2026-01-02", "command": "evpose", "load_before": 1.25, "note": "a note",
            "cases": [{ "name": "or over, 2", "ms": 2.0, "limit": 1.5, "by": "ours" }],
        });
        let file = "benches/machines/a.json".to_owned();
        Template {
            sources: vec![source("a = benches/machines/a.json /cases").expect("a file")],
            stored: BTreeMap::from([(file, stored)]),
            text: text.to_owned(),
        }
    }

    #[test]
    fn places_are_filled_and_the_origin_is_named() {
        let text = "{a/0/by}: {a/name=or over, 2/ms .2} ms, {a/0/limit over a/0/ms %} %, {a/0/x or - .1}\n";
        let written = template(text).expanded("docs/guide/a.md").expect("text");
        assert!(written.starts_with("ours: 2.00 ms, 75 %, -\n\n<sub>["), "{written}");
        assert!(written.contains("](../../benches/machines/a.json): a processor, 2 threads"));
        assert!(written.contains("2026-01-02; load before it 1.2; a note</sub>"), "{written}");
    }

    #[test]
    fn what_is_not_stored_is_an_error() {
        for text in
            ["{a/0/x .1}", "{b/0/ms .1}", "{a/0/ms}", "{a/0/ms .1", "{a/0/by over a/0/ms .1}"]
        {
            assert!(template(text).expanded("README.md").is_err(), "{text}");
        }
        assert!(source("a = results/a.json").is_err());
    }
}
