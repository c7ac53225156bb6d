//! Tables in `benches/gap` say what their stored rows say, and so do the pages that quote them.

use evpose_gap::workflow::CALIBRATION;

use super::*;
use crate::calibrate::Fit;
use crate::outside as other;
use crate::stats::Rate;
use crate::targets::Reached;

/// Recordings of other programs by the last two programs, and all cases of the home tier.
const OUTSIDE: [&str; 2] = ["outside", "outside-ebf3f3a"];
const HOME: [&str; 3] = ["plan-13439286", "plan-161464479", "plan-247414586"];

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn root() -> PathBuf {
    repository().join("benches/gap")
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn dirs(names: &[&str]) -> Vec<PathBuf> {
    names.iter().map(|name| root().join(name)).collect()
}

#[test]
fn every_table_and_page_is_what_its_stored_rows_make() -> Result<()> {
    let derived = derived(&root())?;
    for (path, made) in &derived {
        assert!(
            text(path) == *made,
            "{} is not what its rows make: `gapbench score benches/gap` makes it again",
            path.display()
        );
    }
    for page in ["README.md", "outside.md"] {
        assert!(text(&root().join(page)).contains(BEGIN), "{page} shows no table");
    }
    // Every folder with results is scored, and its table is shown.
    let pages = text(&root().join("README.md")) + &text(&root().join("outside.md"));
    for (dir, _) in folders(&root())? {
        let name = dir.file_name().unwrap_or_default().to_string_lossy();
        assert!(derived.contains_key(&dir.join(TABLE)), "{name}");
        assert!(pages.contains(&format!("{BEGIN}{name}/{TABLE} -->")), "{name} is not shown");
    }
    Ok(())
}

#[test]
fn a_figure_that_was_changed_by_hand_is_seen() -> Result<()> {
    let root = Path::new("/root");
    let derived = BTreeMap::from([(root.join("a/table.md"), "| recall | 3/4 |\n".to_owned())]);
    let page =
        "Before.\n<!-- generated: a/table.md -->\n\n| recall | 4/4 |\n\n<!-- end -->\nBehind.\n";
    let made = with_blocks(page, root, &derived)?;
    assert_eq!(made, page.replace("4/4", "3/4"));
    assert_eq!(with_blocks(&made, root, &derived)?, made);
    assert!(with_blocks("<!-- generated: b.md -->\n<!-- end -->\n", root, &derived).is_err());
    assert!(with_blocks("<!-- generated: a/table.md -->\n", root, &derived).is_err());
    Ok(())
}

#[test]
fn the_fit_in_the_program_is_that_of_the_stored_cases() -> Result<()> {
    let fit = Fit::of_stored(&root())?;
    let path = repository().join("crates/gap/src/workflow/calibration.json");
    assert_eq!(text(&path), files::json(&fit.calibration)?);
    assert_eq!(fit.calibration, *CALIBRATION);
    Ok(())
}

/// Neither a fit that has not seen them nor the one in use states more or less of the names in
/// recordings of other programs than is right, with the names of conventions and without.
#[test]
fn probabilities_agree_with_what_is_right_in_recordings_of_other_programs() -> Result<()> {
    let fit = Fit::of_stored(&root())?;
    for without in [&OUTSIDE[..], &[]] {
        let stated = fit.stated_without(without, &OUTSIDE).context("there are names")?;
        let counts = stated.map(|stated| (stated.right.of, stated.right.n));
        assert_eq!(counts, [(76, 83), (41, 48)]);
        assert!(stated.iter().all(|stated| stated.holds()), "{without:?}: {stated:?}");
    }
    // What the programs stated themselves, by the fit before, does not.
    let scores = other::scores(&dirs(&OUTSIDE))?;
    assert!(!scores.stated.holds() && !scores.stated_strict.holds(), "{:?}", scores.stated);
    Ok(())
}

fn of(rate: &Rate) -> String {
    format!("{} of {}", rate.of, rate.n)
}

fn percent(rate: &Rate) -> String {
    rate.share.map_or_else(String::new, |share| format!("{:.0} %", 100.0 * share))
}

/// Recall stands nowhere without precision, conventions aside, nulls, what is outside the catalogue,
/// and the home tier.
#[test]
fn pages_that_quote_one_figure_quote_all_of_them() -> Result<()> {
    let outside = other::scores(&dirs(&OUTSIDE))?;
    let all = &outside.groups[0];
    let (opened, own) = cases(&dirs(&HOME))?;
    let home = score::score_cases(&opened, own::summary(&own), Vec::new());
    let sentence = format!(
        "{} visible effects named ({}), {} names right ({}), {} without the conventions of generators \
         ({}); {} nulls named, {} outside the catalogue left open",
        of(&all.recall),
        percent(&all.recall),
        of(&all.precision),
        percent(&all.precision),
        of(&all.strict_precision),
        percent(&all.strict_precision),
        of(&all.nulls_named),
        of(&all.outside_open),
    );
    let missed = home.headlines.iter().filter(|row| row.reached() == Reached::Missed).count();
    let required = home.headlines.iter().filter(|row| row.reached() != Reached::Unknown).count();
    let of_home = format!("{missed} of {required} targets of the home tier are missed");
    for page in ["README.md", "docs/guide/gap.md"] {
        let text = text(&repository().join(page)).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(&sentence), "{page}: {sentence}");
        assert!(text.contains(&of_home), "{page}: {of_home}");
    }
    Ok(())
}
