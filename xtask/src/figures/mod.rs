//! `cargo xtask figures`: writes the figures of pages from stored results.
//!
//! A page has blocks between `<!-- figures: NAME -->` and `<!-- end -->`. Their text is the template
//! `benches/tables/NAME.md` with values of files below `benches/`, and a line that says where these come from.

mod bare;
mod lookup;
mod template;

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use crate::files;
use template::Template;

/// At the beginning of a line, so that text may speak of it.
const BEGIN: &str = "\n<!-- figures: ";
const BEGIN_END: &str = " -->\n";
const END: &str = "<!-- end -->\n";
const TEMPLATES: &str = "benches/tables";
/// The page that lists all blocks.
const LIST_PAGE: &str = "benches/README.md";
/// The block of that list, which has no template.
const LIST: &str = "list";

/// A block of a page: its name, and the files it shows figures of.
struct Block {
    page: String,
    name: String,
    files: Vec<String>,
}

/// Writes the blocks of all pages, or, with `--check`, compares them.
///
/// # Errors
/// If a template names a value that is not stored, a page differs with `--check`, or figures stand outside
/// of blocks.
pub(crate) fn run(args: &[String], say: fn(&str)) -> Result<()> {
    let is_check = match args {
        [] => false,
        [only] if only == "--check" => true,
        _ => bail!("usage: cargo xtask figures [--check]"),
    };
    let pages = pages()?;
    let mut blocks = Vec::new();
    let mut problems = Vec::new();
    // The list comes last, since it names the blocks of all other pages.
    for page in pages.iter().map(String::as_str).chain([LIST_PAGE]) {
        let text = std::fs::read_to_string(page).with_context(|| format!("reading {page}"))?;
        let written = rewritten(page, &text, &mut blocks).with_context(|| page.to_owned())?;
        if written != text {
            if is_check {
                problems
                    .push(format!("{page}: figures differ from the stored: `cargo xtask figures`"));
            } else {
                std::fs::write(page, &written).with_context(|| format!("writing {page}"))?;
                say(&format!("written   {page}"));
            }
        }
        problems.extend(bare::tables(page, &written));
    }
    problems.extend(unused(&blocks)?);
    ensure!(problems.is_empty(), "{}", problems.join("\n"));
    say(&format!("{} blocks of figures in {} pages", blocks.len(), pages.len() + 1));
    Ok(())
}

/// README.md, the pages of the book and those of the shipped networks.
fn pages() -> Result<Vec<String>> {
    let is_page = |path: &String| {
        path.ends_with(".md")
            && (path.starts_with("docs/")
                || path.starts_with("checkpoints/")
                || path == "README.md")
    };
    Ok(files::tracked()?.into_iter().filter(is_page).collect())
}

/// The page with its blocks written anew, which are added to `blocks`.
fn rewritten(page: &str, text: &str, blocks: &mut Vec<Block>) -> Result<String> {
    let mut written = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once(BEGIN) {
        let (name, behind) = behind.split_once(BEGIN_END).context("a marker without its end")?;
        let (_, behind) =
            behind.split_once(END).with_context(|| format!("{name}: no `{}`", END.trim_end()))?;
        let content = if name == LIST {
            list(blocks)
        } else {
            let template = Template::read(&template_path(name))?;
            let content = template.expanded(page).with_context(|| name.to_owned())?;
            let files = template.files().map(str::to_owned).collect();
            blocks.push(Block { page: page.to_owned(), name: name.to_owned(), files });
            content
        };
        written += &format!("{before}{BEGIN}{name}{BEGIN_END}{content}{END}");
        rest = behind;
    }
    Ok(written + rest)
}

fn template_path(name: &str) -> String {
    format!("{TEMPLATES}/{name}.md")
}

/// A table of all blocks with their pages and files.
fn list(blocks: &[Block]) -> String {
    let mut text = "| page | block | stored in |\n|---|---|---|\n".to_owned();
    for Block { page, name, files } in blocks {
        let files: Vec<String> = files
            .iter()
            .map(|file| {
                let below = file.trim_start_matches("benches/");
                format!("[{below}]({below})")
            })
            .collect();
        text += &format!(
            "| [{page}](../{page}) | [{name}](tables/{name}.md) | {} |\n",
            files.join(", ")
        );
    }
    text
}

/// Templates that no page has.
fn unused(blocks: &[Block]) -> Result<Vec<String>> {
    let mut unused = Vec::new();
    for entry in std::fs::read_dir(TEMPLATES).with_context(|| format!("reading {TEMPLATES}"))? {
        let path = entry?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if !blocks.iter().any(|block| block.name == name) {
            unused.push(format!("{}: no page has this block", path.display()));
        }
    }
    Ok(unused)
}

/// The link from a page to a file of the repository. README.md is also shown elsewhere.
fn link(page: &str, file: &str) -> String {
    if page == "README.md" {
        return format!("https://github.com/evpose/evpose/blob/HEAD/{file}");
    }
    let depth = Path::new(page).components().count() - 1;
    format!("{}{file}", "../".repeat(depth))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_outside_of_blocks_stays() {
        let page = "a\n<!-- figures: list -->\nold\n<!-- end -->\nb\n";
        let mut blocks = vec![Block {
            page: "docs/guide/a.md".into(),
            name: "speed".into(),
            files: vec!["benches/machines/x.json".into()],
        }];
        let written = rewritten(LIST_PAGE, page, &mut blocks).expect("a page");
        assert!(written.starts_with("a\n<!-- figures: list -->\n| page"), "{written}");
        assert!(written.contains("[machines/x.json](machines/x.json)"), "{written}");
        assert!(written.ends_with("<!-- end -->\nb\n") && !written.contains("old"), "{written}");
        assert!(rewritten(LIST_PAGE, "a\n<!-- figures: list -->\n", &mut blocks).is_err());
    }

    #[test]
    fn links_lead_from_the_page_to_the_file() {
        assert_eq!(link("docs/guide/live.md", "benches/a.json"), "../../benches/a.json");
        assert!(link("README.md", "benches/a.json").starts_with("https://"));
    }
}
