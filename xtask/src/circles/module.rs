//! Modules of a file: items they define, names they bring in, paths their code names.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use syn::visit::{self, Visit};
use syn::{
    Attribute, Expr, ExprLit, Ident, ImplItem, Item, ItemMod, Lit, UseRename, UseTree, Visibility,
};

/// A path as written, split at `::`.
pub(super) type Path = Vec<String>;

/// A module, in a file of its own or inside one.
#[derive(Debug, Default)]
pub(super) struct Module {
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
///
/// # Errors
/// If the source is no Rust.
pub(super) fn modules(source: &str) -> syn::Result<BTreeMap<Path, Module>> {
    let mut reader = Reader { here: Vec::new(), depth: 0, modules: BTreeMap::new() };
    reader.module();
    reader.visit_file(&syn::parse_file(source)?);
    Ok(reader.modules)
}

struct Reader {
    /// The module inside the file.
    here: Path,
    /// Items around the one that is read, modules apart.
    depth: usize,
    modules: BTreeMap<Path, Module>,
}

impl Reader {
    fn module(&mut self) -> &mut Module {
        self.modules.entry(self.here.clone()).or_default()
    }

    fn name(&mut self, path: Path) {
        if path.len() > 1 {
            self.module().named.insert(path);
        }
    }

    fn use_tree(&mut self, prefix: &[String], tree: &UseTree, is_public: bool) {
        let with = |name: &Ident| match name.to_string() {
            // `use a::{self, b}` binds `a`.
            name if name == "self" => prefix.to_vec(),
            name => [prefix, &[name]].concat(),
        };
        match tree {
            UseTree::Path(path) => self.use_tree(&with(&path.ident), &path.tree, is_public),
            UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.use_tree(prefix, tree, is_public));
            }
            UseTree::Glob(_) => self.module().globs.push(prefix.to_vec()),
            UseTree::Name(name) => {
                let path = with(&name.ident);
                self.bind(path.last().cloned().unwrap_or_default(), path, is_public);
            }
            UseTree::Rename(UseRename { ident, rename, .. }) => {
                self.bind(rename.to_string(), with(ident), is_public);
            }
        }
    }

    fn bind(&mut self, name: String, path: Path, is_public: bool) {
        let module = self.module();
        if !is_public {
            module.named.insert(path.clone());
        }
        module.uses.insert(name, path);
    }

    /// Paths among the tokens of a macro, which `syn` does not parse.
    fn tokens(&mut self, tokens: TokenStream) {
        let (mut path, mut colons) = (Path::new(), 0);
        for token in tokens {
            let is_colon = matches!(&token, TokenTree::Punct(mark) if mark.as_char() == ':');
            // Only two colons join names to a path.
            let goes_on = is_colon || (colons == 2 && matches!(token, TokenTree::Ident(_)));
            if !goes_on {
                self.name(std::mem::take(&mut path));
            }
            colons = if is_colon { colons + 1 } else { 0 };
            match token {
                TokenTree::Ident(name) => path.push(name.to_string()),
                TokenTree::Group(group) => self.tokens(group.stream()),
                _ => {}
            }
        }
        self.name(path);
    }
}

impl Visit<'_> for Reader {
    fn visit_item(&mut self, item: &Item) {
        if is_for_tests(item) {
            return;
        }
        let defined = match item {
            Item::Use(item) => {
                let is_public = !matches!(item.vis, Visibility::Inherited);
                return self.use_tree(&[], &item.tree, is_public);
            }
            Item::Mod(ItemMod { ident, content: None, attrs, .. }) => {
                let file = attrs.iter().find_map(path_of_file);
                return self.module().children.push((ident.to_string(), file));
            }
            Item::Mod(ItemMod { ident, content: Some((_, items)), .. }) => {
                self.here.push(ident.to_string());
                // An inline module has an entry even if it holds no item.
                self.module();
                items.iter().for_each(|item| self.visit_item(item));
                self.here.pop();
                return;
            }
            Item::Fn(item) => Some(&item.sig.ident),
            Item::Struct(item) => Some(&item.ident),
            Item::Enum(item) => Some(&item.ident),
            Item::Trait(item) => Some(&item.ident),
            Item::Type(item) => Some(&item.ident),
            Item::Const(item) => Some(&item.ident),
            Item::Static(item) => Some(&item.ident),
            Item::Union(item) => Some(&item.ident),
            Item::Macro(item) => item.ident.as_ref(),
            _ => None,
        };
        // What is defined inside a function is no item of the module.
        if let Some(name) = defined.filter(|_| self.depth == 0) {
            self.module().items.insert(name.to_string());
        }
        self.depth += 1;
        visit::visit_item(self, item);
        self.depth -= 1;
    }

    fn visit_impl_item(&mut self, item: &ImplItem) {
        if !is_for_tests(item) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_path(&mut self, path: &syn::Path) {
        self.name(path.segments.iter().map(|part| part.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &syn::Macro) {
        self.visit_path(&call.path);
        self.tokens(call.tokens.clone());
    }

    fn visit_attribute(&mut self, _: &Attribute) {}
}

/// Whether an attribute before an item is `#[test]` or a `#[cfg(…)]` of tests.
fn is_for_tests(item: &impl ToTokens) -> bool {
    let tokens: Vec<TokenTree> = item.to_token_stream().into_iter().collect();
    let is_mark = |token: &TokenTree| matches!(token, TokenTree::Punct(p) if p.as_char() == '#');
    tokens.chunks(2).take_while(|pair| is_mark(&pair[0])).any(|attribute| {
        // An attribute is two tokens: `#` and a group in brackets.
        let text = attribute[1..].iter().map(ToString::to_string).collect::<String>();
        let words: Vec<&str> = text
            .split(|c: char| !c.is_alphanumeric() && c != '_')
            .filter(|w| !w.is_empty())
            .collect();
        words == ["test"]
            || (words[0] == "cfg" && words.contains(&"test") && !words.contains(&"not"))
    })
}

/// The path in `#[path = "…"]`.
fn path_of_file(attribute: &Attribute) -> Option<String> {
    let value = &attribute.meta.require_name_value().ok()?.value;
    let Expr::Lit(ExprLit { lit: Lit::Str(path), .. }) = value else { return None };
    attribute.path().is_ident("path").then(|| path.value())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(text: &str) -> Path {
        text.split("::").map(str::to_owned).collect()
    }

    fn root(source: &str) -> Module {
        modules(source).unwrap().remove(&Vec::new()).unwrap()
    }

    #[test]
    fn items_imports_and_paths_are_read() {
        let module = root(
            "mod a; pub mod b; use crate::c::{self, D as E, f::*}; pub use a::Thing;
             pub const fn make() -> crate::g::H { super::k::<u8>() } #[derive(Debug)] pub struct S;
             fn f() { say!(\"{}\", super::m::n(a: 1)) }",
        );
        assert_eq!(module.children, [("a".into(), None), ("b".into(), None)]);
        assert_eq!(module.items, ["S", "f", "make"].map(str::to_owned).into());
        assert_eq!(module.uses["c"], path("crate::c"));
        assert_eq!(module.uses["E"], path("crate::c::D"));
        assert_eq!(module.uses["Thing"], path("a::Thing"));
        assert_eq!(module.globs, [path("crate::c::f")]);
        let named = ["crate::c", "crate::c::D", "crate::g::H", "super::k", "super::m::n"];
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
        let source = "mod inner { use super::A; mod file; struct B; } struct A;";
        let modules = modules(source).unwrap();
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
