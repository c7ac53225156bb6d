//! From paths in source to the files that define what they name.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path as FilePath, PathBuf};

use anyhow::{Context, Result};

use super::module::{Module, Path, modules};

/// Re-exports of re-exports that are followed.
const MAX_DEPTH: usize = 16;

/// The files of a crate, by number, and its modules.
pub(super) struct CrateFiles {
    pub(super) paths: Vec<PathBuf>,
    /// For each file the one that declares it as its module.
    parents: Vec<Option<usize>>,
    modules: BTreeMap<Path, (usize, Module)>,
}

/// Referent of a path.
#[derive(Clone, PartialEq, Eq)]
enum Target {
    Module(Path),
    /// An item that the file of this number defines.
    Item(usize),
}

impl CrateFiles {
    /// Reads a crate from its root file along `mod` declarations, tests apart.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub(super) fn read(root: &FilePath) -> Result<Self> {
        let mut tree = Self { paths: Vec::new(), parents: Vec::new(), modules: BTreeMap::new() };
        let folder = root.parent().context("a root file has a folder")?.to_owned();
        tree.add(root.to_owned(), &folder, &[], None)?;
        Ok(tree)
    }

    /// Adds a file whose submodules lie in `folder`.
    fn add(
        &mut self,
        path: PathBuf,
        folder: &FilePath,
        module: &[String],
        declared_by: Option<usize>,
    ) -> Result<()> {
        let source = std::fs::read_to_string(&path);
        let source = source.with_context(|| format!("reading {}", path.display()))?;
        let modules = modules(&source).with_context(|| format!("parsing {}", path.display()))?;
        let number = self.paths.len();
        let parent = path.parent().map(FilePath::to_owned).unwrap_or_default();
        self.paths.push(path);
        self.parents.push(declared_by);
        for (inner, content) in modules {
            let folder = inner.iter().fold(folder.to_owned(), |folder, part| folder.join(part));
            let here = [module, &inner].concat();
            for (name, file) in &content.children {
                // A `path` attribute is relative to the folder of the file, not to that of the
                // module.
                let named = file.as_ref().map(|file| parent.join(file));
                let flat = named.unwrap_or_else(|| folder.join(format!("{name}.rs")));
                let child = [&here[..], std::slice::from_ref(name)].concat();
                if flat.is_file() {
                    self.add(flat, &folder.join(name), &child, Some(number))?;
                } else if folder.join(name).join("mod.rs").is_file() {
                    let below = folder.join(name);
                    self.add(below.join("mod.rs"), &below, &child, Some(number))?;
                }
            }
            self.modules.insert(here, (number, content));
        }
        Ok(())
    }

    /// Pairs of files of which the first names items of the second, and the names.
    pub(super) fn imports(&self) -> BTreeMap<(usize, usize), BTreeSet<String>> {
        let mut imports = BTreeMap::<(usize, usize), BTreeSet<String>>::new();
        for (here, (from, module)) in &self.modules {
            for path in &module.named {
                // A module alone is no item of it: what is used of it stands in the code as a path.
                if let Some(Target::Item(to)) = self.resolve(here, path, 0)
                    && to != *from
                    && Some(to) != self.parents[*from]
                {
                    let name = path.last().cloned().unwrap_or_default();
                    imports.entry((*from, to)).or_default().insert(name);
                }
            }
        }
        imports
    }

    fn resolve(&self, here: &Path, path: &[String], depth: usize) -> Option<Target> {
        if depth > MAX_DEPTH {
            return None;
        }
        let mut at = Target::Module(here.clone());
        for (index, part) in path.iter().enumerate() {
            let Target::Module(module) = at else { return Some(at) };
            at = match part.as_str() {
                "crate" => Target::Module(Vec::new()),
                "self" => Target::Module(module),
                "super" => Target::Module(module[..module.len().checked_sub(1)?].to_vec()),
                _ => match self.member(&module, part, depth) {
                    Some(target) => target,
                    // An unknown name of a module of ours is made by a macro there.
                    None if index > 0 => Target::Item(self.modules.get(&module)?.0),
                    None => return None,
                },
            };
        }
        Some(at)
    }

    fn member(&self, module: &Path, name: &str, depth: usize) -> Option<Target> {
        let child = [&module[..], &[name.to_owned()]].concat();
        if self.modules.contains_key(&child) {
            return Some(Target::Module(child));
        }
        let (file, content) = self.modules.get(module)?;
        if content.items.contains(name) {
            return Some(Target::Item(*file));
        }
        if let Some(path) = content.uses.get(name) {
            // `use name;` of another crate stands for itself.
            let is_itself = path.len() == 1 && path[0] == name;
            return if is_itself { None } else { self.resolve(module, path, depth + 1) };
        }
        content.globs.iter().find_map(|glob| {
            let Target::Module(of) = self.resolve(module, glob, depth + 1)? else { return None };
            // A glob that leads back to its own module would be searched forever.
            if of == *module || depth >= MAX_DEPTH {
                None
            } else {
                self.member(&of, name, depth + 1)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn re_exports_lead_to_the_definition() {
        let folder = tempfile();
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        std::fs::create_dir_all(folder.join("deep")).unwrap();
        write("lib.rs", "mod a; mod deep; pub use deep::*; pub use a::A;");
        write("a.rs", "use crate::B; pub struct A;");
        write("deep/mod.rs", "mod b; pub use b::B;");
        write("deep/b.rs", "pub struct B(crate::A); fn x() { super::nothing::at_all() }");
        let tree = CrateFiles::read(&folder.join("lib.rs")).unwrap();
        let name = |k: usize| tree.paths[k].strip_prefix(&folder).unwrap().display().to_string();
        let imports: Vec<(String, String)> =
            tree.imports().keys().map(|&(from, to)| (name(from), name(to))).collect();
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert!(imports.contains(&pair("a.rs", "deep/b.rs")), "{imports:?}");
        assert!(imports.contains(&pair("deep/b.rs", "a.rs")), "{imports:?}");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    fn tempfile() -> PathBuf {
        let folder = std::env::temp_dir().join(format!("circles-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }
}
