//! LSP into images of persons.

use std::path::Path;

use super::person::person;
use super::table;
use crate::DatasetError;
use crate::stills::{self, Converted, Photograph, StillOptions, StillSet, leave_out_exchanged};

/// Photographs of the extended set are `im00001.jpg` and so on, those of the original one
/// `im0001.jpg`: `N` digits.
const DIGITS: [usize; 2] = [5, 4];

/// Converts the photographs of either set; `options.annotations` is its `joints.mat`.
///
/// Persons whose left and right seem to be exchanged are left out: of shoulders and hips that face
/// opposite ways, nobody knows which are right.
///
/// # Errors
/// As [`stills`](crate::stills) has them.
pub fn convert(
    options: &StillOptions,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Converted, DatasetError> {
    let read = |path: &Path, bytes: &[u8]| {
        let persons = table::read(path, bytes)?;
        // The sets number their photographs with different counts of digits.
        let first = |digits: usize| options.images.join(name(0, digits)).is_file();
        let digits = DIGITS.into_iter().find(|&digits| first(digits)).unwrap_or(DIGITS[0]);
        let photograph = |(index, points)| Photograph {
            index,
            name: name(index, digits),
            persons: vec![Ok(person(points))],
        };
        let mut photographs: Vec<Photograph> = persons.iter().enumerate().map(photograph).collect();
        leave_out_exchanged(&mut photographs);
        Ok(StillSet { name: "lsp", photographs, not_for_training: 0 })
    };
    stills::convert(options, read, progress)
}

fn name(index: usize, digits: usize) -> String {
    format!("im{:0digits$}.jpg", index + 1)
}
