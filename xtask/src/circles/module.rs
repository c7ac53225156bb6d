//! Modules of a file: items they define, names they bring in, paths their code names.

use std::collections::{BTreeMap, BTreeSet};

use super::lex::Token;

/// A path as written, split at `::`.
pub(super) type Path = Vec<String>;

/// A module, in a file of its own or inside one.
#[derive(Debug, Default)]
pub(super) struct Module {
    /// Items it defines.
    pub(super) items: BTreeSet<String>,
    /// Names brought in or offered again, and what they stand for.
    pub(super) uses: BTreeMap<String, Path>,
    /// Modules that are brought in whole.
    pub(super) globs: Vec<Path>,
    /// Paths that its code names: imports that are not re-exports, and paths of at least two parts.
    pub(super) named: BTreeSet<Path>,
    /// Modules in files of their own, with the file's path where one is given.
    pub(super) children: Vec<(String, Option<String>)>,
}

/// Reads the modules of a file, by their path below the file's own module.
pub(super) fn modules(tokens: &[Token]) -> BTreeMap<Path, Module> {
    let mut reader = Reader { tokens, at: 0, here: Vec::new(), modules: BTreeMap::new() };
    reader.modules.insert(Vec::new(), Module::default());
    reader.items();
    reader.modules
}

struct Reader<'t> {
    tokens: &'t [Token],
    at: usize,
    /// The module inside the file.
    here: Path,
    modules: BTreeMap<Path, Module>,
}

impl<'t> Reader<'t> {
    fn module(&mut self) -> &mut Module {
        self.modules.entry(self.here.clone()).or_default()
    }

    fn ident(&self, at: usize) -> Option<&str> {
        self.tokens.get(at).and_then(Token::ident)
    }

    fn is(&self, at: usize, other: char) -> bool {
        self.tokens.get(at).is_some_and(|token| token.is(other))
    }

    /// Reads until the brace that closes the module.
    fn items(&mut self) {
        let (mut depth, mut is_test, mut is_public) = (0, false, false);
        let mut file = None;
        while self.at < self.tokens.len() {
            if self.is(self.at, '#') {
                let attribute = self.attribute();
                let has = |name: &str| attribute.iter().any(|token| token.ident() == Some(name));
                is_test |= (has("cfg") && has("test") && !has("not"))
                    || matches!(attribute, [test] if test.ident() == Some("test"));
                if let [Token::Ident(path), Token::Other('='), Token::Text(text)] = attribute
                    && path == "path"
                {
                    file = Some(text.clone());
                }
                continue;
            }
            if is_test {
                self.skip_item();
                (is_test, is_public, file) = (false, false, None);
                continue;
            }
            match self.ident(self.at) {
                Some("pub") => is_public = true,
                Some("use") => {
                    self.at += 1;
                    self.use_tree(&mut Vec::new(), is_public);
                    is_public = false;
                    continue;
                }
                Some("mod") if self.ident(self.at + 1).is_some() => {
                    let name = self.ident(self.at + 1).unwrap_or_default().to_owned();
                    self.at += 3;
                    if self.is(self.at - 1, '{') {
                        self.here.push(name);
                        self.items();
                        self.here.pop();
                    } else {
                        self.module().children.push((name, file.take()));
                    }
                    is_public = false;
                    continue;
                }
                Some(
                    "fn" | "struct" | "enum" | "trait" | "type" | "const" | "static" | "union",
                ) => {
                    if depth == 0
                        && let Some(name) = self.defined_name()
                    {
                        self.module().items.insert(name);
                    }
                    is_public = false;
                }
                Some("macro_rules") => {
                    if let Some(name) = self.ident(self.at + 2).map(str::to_owned) {
                        self.module().items.insert(name);
                    }
                }
                Some(_) => {
                    self.path();
                    continue;
                }
                None if self.is(self.at, '{') => depth += 1,
                None if self.is(self.at, '}') => {
                    if depth == 0 {
                        self.at += 1;
                        return;
                    }
                    depth -= 1;
                }
                None => {}
            }
            self.at += 1;
        }
    }

    /// The name behind `fn`, `struct` and the like.
    fn defined_name(&self) -> Option<String> {
        let modifiers = ["fn", "unsafe", "extern", "async", "mut"];
        let is_modifier =
            |at: &usize| self.ident(*at).is_some_and(|name| modifiers.contains(&name));
        // `const fn name`, `static mut NAME`: the name comes behind the last of them.
        let at = self.at + 1 + (self.at + 1..).take_while(is_modifier).count();
        self.ident(at).filter(|&name| name != "_").map(str::to_owned)
    }

    /// Passes an attribute; returns what is inside its brackets.
    fn attribute(&mut self) -> &'t [Token] {
        let opening = (self.at..self.tokens.len()).find(|&at| self.is(at, '['));
        let begin = opening.unwrap_or(self.at);
        self.at = self.closing(begin);
        &self.tokens
            [(begin + 1).min(self.at)..self.at.saturating_sub(1).max(begin + 1).min(self.at)]
    }

    /// The place behind the bracket that closes the one at `begin`.
    fn closing(&self, begin: usize) -> usize {
        let mut depth = 0_usize;
        for at in begin..self.tokens.len() {
            match self.tokens[at] {
                Token::Other('{' | '[' | '(') => depth += 1,
                Token::Other('}' | ']' | ')') => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 {
                return at + 1;
            }
        }
        self.tokens.len()
    }

    /// Passes an item: to its semicolon, or the brace that closes it.
    fn skip_item(&mut self) {
        while self.at < self.tokens.len() && !self.is(self.at, ';') && !self.is(self.at, '}') {
            if self.is(self.at, ',') {
                break;
            }
            let is_block = self.is(self.at, '{');
            let opens = is_block || self.is(self.at, '(') || self.is(self.at, '[');
            self.at = if opens { self.closing(self.at) } else { self.at + 1 };
            if is_block {
                return;
            }
        }
        if !self.is(self.at, '}') {
            self.at += 1;
        }
    }

    /// Reads what follows `use`, up to its end.
    fn use_tree(&mut self, prefix: &mut Path, is_public: bool) {
        let length = prefix.len();
        loop {
            if let Some(name) = self.ident(self.at).map(str::to_owned) {
                self.at += 1;
                if name == "as" {
                    let renamed = self.ident(self.at).unwrap_or("_").to_owned();
                    self.at += 1;
                    self.bind(renamed, prefix.clone(), is_public);
                    break;
                }
                prefix.push(name);
                continue;
            }
            match self.tokens.get(self.at) {
                Some(Token::Path) => self.at += 1,
                Some(Token::Other('*')) => {
                    self.at += 1;
                    self.module().globs.push(prefix.clone());
                    break;
                }
                Some(Token::Other('{')) => {
                    self.at += 1;
                    while self.at < self.tokens.len() && !self.is(self.at, '}') {
                        self.use_tree(prefix, is_public);
                        if self.is(self.at, ',') {
                            self.at += 1;
                        }
                    }
                    self.at += 1;
                    break;
                }
                _ => {
                    // `use a::{self, b}` binds `a`.
                    let is_self =
                        prefix.len() > 1 && prefix.last().is_some_and(|last| last == "self");
                    if is_self {
                        prefix.pop();
                    }
                    if let Some(name) = prefix.last().cloned() {
                        self.bind(name, prefix.clone(), is_public);
                    }
                    break;
                }
            }
        }
        prefix.truncate(length);
        if prefix.is_empty() && self.is(self.at, ';') {
            self.at += 1;
        }
    }

    fn bind(&mut self, name: String, path: Path, is_public: bool) {
        let module = self.module();
        if !is_public {
            module.named.insert(path.clone());
        }
        module.uses.insert(name, path);
    }

    /// Reads a path in code.
    fn path(&mut self) {
        let mut path = vec![self.ident(self.at).unwrap_or_default().to_owned()];
        self.at += 1;
        while self.tokens.get(self.at) == Some(&Token::Path)
            && let Some(part) = self.ident(self.at + 1).map(str::to_owned)
        {
            path.push(part);
            self.at += 2;
        }
        if path.len() > 1 {
            self.module().named.insert(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::lex::tokens;
    use super::*;

    fn path(text: &str) -> Path {
        text.split("::").map(str::to_owned).collect()
    }

    fn root(source: &str) -> Module {
        modules(&tokens(source)).remove(&Vec::new()).unwrap()
    }

    #[test]
    fn items_imports_and_paths_are_read() {
        let module = root(
            "mod a; pub mod b; use crate::c::{self, D as E, f::*}; pub use a::Thing;
             pub const fn make() -> crate::g::H { super::k::<u8>() } #[derive(Debug)] pub struct S;",
        );
        assert_eq!(module.children, [("a".into(), None), ("b".into(), None)]);
        assert_eq!(module.items, ["S", "make"].map(str::to_owned).into());
        assert_eq!(module.uses["c"], path("crate::c"));
        assert_eq!(module.uses["E"], path("crate::c::D"));
        assert_eq!(module.uses["Thing"], path("a::Thing"));
        assert_eq!(module.globs, [path("crate::c::f")]);
        let named = ["crate::c", "crate::c::D", "crate::g::H", "super::k"];
        assert_eq!(module.named, named.map(path).into());
    }

    #[test]
    fn tests_do_not_count() {
        let module = root(
            "#[cfg(test)] mod tests { use super::A; fn b() {} } #[cfg(test)] mod laws;
             #[cfg(test)] impl X { fn y() { crate::z::w() } } #[cfg(not(test))] use crate::c;",
        );
        assert_eq!(module.named, [path("crate::c")].into());
        assert!(module.children.is_empty());
        assert!(module.items.is_empty());
    }

    #[test]
    fn modules_inside_a_file_have_a_scope_of_their_own() {
        let modules = modules(&tokens("mod inner { use super::A; mod file; struct B; } struct A;"));
        assert_eq!(modules[&path("inner")].uses["A"], path("super::A"));
        assert_eq!(modules[&path("inner")].children, [("file".into(), None)]);
        assert_eq!(modules[&Vec::new()].items, ["A".to_owned()].into());
    }

    #[test]
    fn a_path_attribute_places_a_module() {
        let module = root("#[path = \"elsewhere.rs\"] mod a;");
        assert_eq!(module.children, [("a".into(), Some("elsewhere.rs".into()))]);
    }
}
