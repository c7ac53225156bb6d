//! Tables of labels as CSV: named columns in any order, a time stamp in each line.

use std::path::{Path, PathBuf};

use evpose_core::{Micros, without_bom};

use crate::import::ImportError;

/// Columns of time stamps and the microseconds of their unit.
const TIME_COLUMNS: [(&str, f64); 2] = [("t_us", 1.0), ("t_s", 1e6)];

/// Most columns that a message names.
const MAX_LISTED: usize = 24;

/// A CSV file with a header line.
#[derive(Debug)]
pub(crate) struct Table {
    path: PathBuf,
    columns: Vec<String>,
    rows: Vec<Row>,
    time: (usize, f64),
}

/// A line of a table.
#[derive(Debug)]
pub(crate) struct Row {
    /// From 1; the header is line 1.
    line: usize,
    cells: Vec<String>,
}

impl Table {
    /// Reads a table with a column `t_us` or `t_s`.
    ///
    /// # Errors
    /// If the file cannot be read, has no time column or no labels, or a line has too many or too
    /// few cells.
    pub(crate) fn read(path: &Path) -> Result<Self, ImportError> {
        let text = std::fs::read_to_string(path).map_err(ImportError::io(path, "read"))?;
        let mut lines = without_bom(&text).lines();
        let columns = split(lines.next().unwrap_or_default());
        // Of two columns of one name, the second would be ignored silently.
        for (index, column) in columns.iter().enumerate() {
            if columns[..index].contains(column) {
                let reason = format!("column `{column}` occurs twice");
                return Err(ImportError::malformed(path, "line 1", reason));
            }
        }
        let time = TIME_COLUMNS.iter().find_map(|(name, unit_us)| {
            Some((columns.iter().position(|column| column == name)?, *unit_us))
        });
        let Some(time) = time else {
            let present = listed(&columns);
            let reason =
                format!("no column of time stamps: expected `t_us` or `t_s`; there are {present}");
            return Err(ImportError::malformed(path, "line 1", reason));
        };
        let mut rows = Vec::new();
        // Lines as editors count them; the header is the first.
        for (line, text) in (2..).zip(lines).filter(|(_, text)| !text.trim().is_empty()) {
            let cells = split(text);
            if cells.len() != columns.len() {
                let reason = format!("{} cells, expected {}", cells.len(), columns.len());
                return Err(ImportError::malformed(path, format!("line {line}"), reason));
            }
            rows.push(Row { line, cells });
        }
        if rows.is_empty() {
            return Err(ImportError::Empty { path: path.to_owned(), content: "labels" });
        }
        Ok(Self { path: path.to_owned(), columns, rows, time })
    }

    /// Names of the columns.
    pub(crate) fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The index of a column.
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// The index of a column that must be there; an error names it and those that are.
    pub(crate) fn required(&self, name: &str) -> Result<usize, ImportError> {
        self.column(name).ok_or_else(|| {
            let present = listed(&self.columns);
            self.fault_of_header(format!("no column `{name}`; there are {present}"))
        })
    }

    /// The error for a fault of the header line.
    pub(crate) fn fault_of_header(&self, reason: impl Into<String>) -> ImportError {
        ImportError::malformed(&self.path, "line 1", reason)
    }

    /// Lines with their time stamps, each later than the one before.
    ///
    /// # Errors
    /// If a time stamp cannot be parsed or is not later than the one before.
    pub(crate) fn rows(&self) -> Result<Vec<(Micros, &Row)>, ImportError> {
        let (column, unit_us) = self.time;
        let mut rows: Vec<(Micros, &Row)> = Vec::with_capacity(self.rows.len());
        for row in &self.rows {
            let Some(time) = self.value(row, column)? else {
                return Err(self.fault(row, column, "empty"));
            };
            // Decimal seconds are not exact in binary: truncated, some would lose a microsecond.
            let t = Micros((time * unit_us).round() as i64);
            if rows.last().is_some_and(|(before, _)| *before >= t) {
                return Err(self.fault(row, column, "not later than the line before"));
            }
            rows.push((t, row));
        }
        Ok(rows)
    }

    /// The text of a cell.
    pub(crate) fn text<'a>(&self, row: &'a Row, column: usize) -> &'a str {
        &row.cells[column]
    }

    /// The value of a cell; none where it is missing: empty or `nan`.
    ///
    /// # Errors
    /// If it is not a finite value.
    pub(crate) fn value(&self, row: &Row, column: usize) -> Result<Option<f64>, ImportError> {
        let cell = row.cells[column].as_str();
        if is_missing(cell) {
            return Ok(None);
        }
        let value = cell.parse::<f64>().ok().filter(|value| value.is_finite());
        match value {
            Some(value) => Ok(Some(value)),
            None => Err(self.fault(row, column, &format!("`{cell}` is not a finite value"))),
        }
    }

    /// Values of several cells; none where all of them are missing.
    ///
    /// # Errors
    /// If one is not a finite value, or only some are missing.
    pub(crate) fn values<const N: usize>(
        &self,
        row: &Row,
        columns: [usize; N],
    ) -> Result<Option<[f64; N]>, ImportError> {
        let mut values = [0.0; N];
        let mut count = 0;
        for (value, column) in values.iter_mut().zip(columns) {
            if let Some(known) = self.value(row, column)? {
                *value = known;
                count += 1;
            }
        }
        // One coordinate that is missing is likelier a mistake than half a label.
        match columns.into_iter().find(|column| is_missing(&row.cells[*column])) {
            Some(empty) if count > 0 => {
                Err(self.fault(row, empty, "missing, but not the others of this label"))
            }
            Some(_) => Ok(None),
            None => Ok(Some(values)),
        }
    }

    /// The error for a fault in a cell.
    pub(crate) fn fault(&self, row: &Row, column: usize, reason: &str) -> ImportError {
        let place = format!("line {}: {}", row.line, self.columns[column]);
        ImportError::malformed(&self.path, place, reason)
    }
}

/// Whether a cell holds no value: programs write nothing, or `nan`.
fn is_missing(cell: &str) -> bool {
    cell.is_empty() || cell.eq_ignore_ascii_case("nan")
}

/// Names of columns for a message; of many the first ones and their count.
pub(crate) fn listed(columns: &[String]) -> String {
    if columns.len() <= MAX_LISTED {
        return columns.join(", ");
    }
    format!("{}, … ({} columns)", columns[..MAX_LISTED].join(", "), columns.len())
}

fn split(line: &str) -> Vec<String> {
    line.split(',').map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Table, ImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("labels.csv");
        std::fs::write(&path, text).unwrap();
        Table::read(&path)
    }

    #[test]
    fn columns_are_found_by_name_and_seconds_are_microseconds() {
        let table = read("\u{feff}\"b\", t_s ,a\r\n1.5,0.25,\n,0.5,-2\n").unwrap();
        let rows = table.rows().unwrap();
        assert_eq!(rows[0].0, Micros(250_000));
        let columns = [table.required("b").unwrap(), table.required("a").unwrap()];
        assert_eq!(table.value(rows[0].1, columns[0]).unwrap(), Some(1.5));
        assert_eq!(table.value(rows[1].1, columns[0]).unwrap(), None);
        assert_eq!(table.value(rows[1].1, columns[1]).unwrap(), Some(-2.0));
        assert_eq!(table.column("c"), None);
    }

    #[test]
    fn a_missing_column_is_named_with_those_that_are_there() {
        let message = read("t_us,a\n1,2\n").unwrap().required("b").unwrap_err().to_string();
        assert!(message.contains("line 1: no column `b`; there are t_us, a"), "{message}");
        let many: String = (0..30).map(|k| format!(",c{k}")).collect();
        let text = format!("t_us{many}\n0{}\n", ",".repeat(30));
        let message = read(&text).unwrap().required("b").unwrap_err().to_string();
        assert!(message.ends_with("c22, … (31 columns)"), "{message}");
    }

    #[test]
    fn empty_and_nan_are_missing_values() {
        let table = read("t_us,a,b\n1,,NaN\n2,nan,3\n").unwrap();
        let rows = table.rows().unwrap();
        assert_eq!(table.values(rows[0].1, [1, 2]).unwrap(), None);
        let message = table.values(rows[1].1, [1, 2]).unwrap_err().to_string();
        assert!(message.contains("line 3: a: missing"), "{message}");
    }

    #[test]
    fn faults_name_file_line_and_column() {
        let fault = |text: &str| match read(text) {
            Ok(table) => table
                .rows()
                .and_then(|rows| table.values(rows[0].1, [0, 1]).map(|_| ()))
                .unwrap_err()
                .to_string(),
            Err(error) => error.to_string(),
        };
        for (text, want) in [
            ("t_us,a\n1,x\n", "labels.csv: line 2: a: `x` is not a finite value"),
            ("t_us,a\n1,inf\n", "line 2: a: `inf`"),
            ("t_us,a\n1,\n", "line 2: a: missing, but not"),
            ("t_us,a\n1,2\n1,2\n", "line 3: t_us: not later"),
            ("t_us,a\n1\n", "line 2: 1 cells, expected 2"),
            ("t_us,t_us\n1,2\n", "line 1: column `t_us` occurs twice"),
            (
                "time,a\n1,2\n",
                "line 1: no column of time stamps: expected `t_us` or `t_s`; there are time",
            ),
            ("t_us,a\n", "no labels"),
        ] {
            let message = fault(text);
            assert!(message.contains(want), "{message}");
        }
    }
}
