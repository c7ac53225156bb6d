//! Tables that other programs read: one CSV file each.

use std::path::Path;

use anyhow::Result;

use super::confusion::Confusion;
use super::opened::Opened;
use super::score::Scores;
use super::stats::Rate;
use crate::files;

pub(super) fn write(dir: &Path, opened: &[Opened], scores: &Scores) -> Result<()> {
    for (name, table) in [
        ("groups.csv", groups(scores)),
        ("confusion.csv", confusion(opened)),
        ("power.csv", power(scores)),
        ("reliability.csv", reliability(scores)),
        ("intervals.csv", intervals(opened, scores)),
        ("times.csv", times(opened)),
    ] {
        files::write(dir, name, text(&table).as_bytes())?;
    }
    Ok(())
}

type Table = Vec<Vec<String>>;

fn text(table: &Table) -> String {
    table.iter().map(|row| format!("{}\n", line(row))).collect()
}

/// A line; cells with a comma or a quote are quoted.
fn line(cells: &[String]) -> String {
    let cell = |cell: &String| match cell.contains([',', '"']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.clone(),
    };
    cells.iter().map(cell).collect::<Vec<_>>().join(",")
}

fn header(names: &str) -> Table {
    vec![names.split(',').map(str::to_owned).collect()]
}

fn rate(rate: &Rate) -> [String; 3] {
    let share = rate.share.map_or_else(String::new, |share| format!("{share:.4}"));
    [share, format!("{:.4}", rate.lo95), format!("{:.4}", rate.hi95)]
}

fn confusion(opened: &[Opened]) -> Table {
    let matrix = Confusion::from_cases(opened);
    let mut first = vec!["hidden".to_owned()];
    first.extend(matrix.columns);
    let rows = matrix.rows.into_iter().zip(matrix.cells).map(|(name, cells)| {
        let counts = cells.iter().map(|cell| cell.n.to_string());
        std::iter::once(name).chain(counts).collect()
    });
    std::iter::once(first).chain(rows).collect()
}

fn groups(scores: &Scores) -> Table {
    let mut table = header("group,cases,measure,of,n,share,lo95,hi95");
    for group in &scores.groups {
        for (measure, value) in [
            ("recall", &group.recall),
            ("precision", &group.precision),
            ("precision_of_hidden", &group.precision_of_hidden),
            ("as_expected", &group.exact),
            ("wrong_name", &group.wrong),
        ] {
            let first = [group.name.to_owned(), group.cases.to_string(), measure.to_owned()];
            let counts = [value.of.to_string(), value.n.to_string()];
            table.push(first.into_iter().chain(counts).chain(rate(value)).collect());
        }
    }
    table
}

fn power(scores: &Scores) -> Table {
    let mut table = header("effect,strength,visible,right,n,share,lo95,hi95");
    table.extend(scores.power.iter().map(|power| {
        let counts = [power.strength, power.visible, power.right.of, power.right.n];
        std::iter::once(power.effect.to_owned())
            .chain(counts.iter().map(usize::to_string))
            .chain(rate(&power.right))
            .collect()
    }));
    table
}

fn reliability(scores: &Scores) -> Table {
    let mut table = header("from,to,stated,right,n,share,lo95,hi95");
    table.extend(scores.reliability.iter().map(|bin| {
        let bounds = [bin.from.to_string(), bin.to.to_string(), format!("{:.4}", bin.stated)];
        let counts = [bin.right.of.to_string(), bin.right.n.to_string()];
        bounds.into_iter().chain(counts).chain(rate(&bin.right)).collect()
    }));
    table
}

fn intervals(opened: &[Opened], scores: &Scores) -> Table {
    let mut table =
        header("case,kind,finding,parameter,unit,truth,estimate,lo90,hi90,relative_error,covered");
    table.extend(scores.estimates.iter().map(|estimate| {
        let case = opened.iter().find(|case| case.row.id == estimate.id);
        let quantity = &estimate.estimate;
        vec![
            estimate.id.clone(),
            case.map_or_else(String::new, kind),
            estimate.finding.clone(),
            estimate.parameter.clone(),
            quantity.unit.clone(),
            estimate.truth.to_string(),
            quantity.value.to_string(),
            quantity.lo90.to_string(),
            quantity.hi90.to_string(),
            estimate.error().map_or_else(String::new, |error| format!("{error:.5}")),
            estimate.is_covered().to_string(),
        ]
    }));
    table
}

fn times(opened: &[Opened]) -> Table {
    let mut table = header("case,kind,scene,events,make_s,name_s,seconds");
    table.extend(opened.iter().map(|case| {
        let row = &case.row;
        vec![
            row.id.clone(),
            kind(case),
            case.truth.scene.clone(),
            row.events.to_string(),
            format!("{:.3}", row.make_s),
            format!("{:.3}", row.name_s),
            format!("{:.3}", row.seconds()),
        ]
    }));
    table
}

/// The group of a case, as labels have it.
fn kind(case: &Opened) -> String {
    let json = serde_json::to_value(case.truth.kind).unwrap_or_default();
    json.as_str().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{example, score};

    #[test]
    fn cells_with_commas_are_quoted() {
        let cells = ["1 right, 0 wrong", "a", "say \"b\""].map(str::to_owned);
        assert_eq!(line(&cells), "\"1 right, 0 wrong\",a,\"say \"\"b\"\"\"");
    }

    #[test]
    fn every_table_is_written_with_a_row_for_each_of_its_things() -> Result<()> {
        let dir = tempfile::tempdir()?;
        let opened = example::opened();
        let scores = score::score_cases(&opened, None, Vec::new());
        write(dir.path(), &opened, &scores)?;
        for (name, rows, first) in [
            ("groups.csv", 5 * scores.groups.len(), "singles,216,recall,162,162,1.0000,"),
            ("power.csv", 18 * 4, "leak_on,0,0,"),
            ("reliability.csv", scores.reliability.len(), "0.98,1,"),
            ("intervals.csv", scores.estimates.len(), ""),
            ("times.csv", opened.len(), ""),
        ] {
            let text = std::fs::read_to_string(dir.path().join(name))?;
            let lines: Vec<&str> = text.lines().collect();
            assert_eq!(lines.len(), rows + 1, "{name}");
            let columns = |line: &str| line.matches(',').count();
            assert!(lines[1].starts_with(first), "{name}: {}", lines[1]);
            assert!(lines.iter().all(|line| columns(line) == columns(lines[0])), "{name}");
        }
        let text = std::fs::read_to_string(dir.path().join("confusion.csv"))?;
        assert!(text.starts_with("hidden,leak_on,") && text.contains("\"2 right, 0 wrong\""));
        Ok(())
    }
}
