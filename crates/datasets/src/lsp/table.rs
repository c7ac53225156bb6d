//! The table of points of all photographs, `joints` of `joints.mat`.

use std::path::Path;

use evpose_containers::mat::MatFile;
use evpose_pose::body::Visibility;
use glam::DVec2;

use crate::DatasetError;

/// Points of a person.
pub(super) const LSP_POINTS: usize = 14;
/// Values of a point: column, row and flag.
const VALUES: usize = 3;

/// A point, in pixels of the photograph; none where it is not annotated.
pub(super) type LspPoint = Option<(DVec2, Visibility)>;

/// Reads the points of every photograph.
///
/// The extended set's table is 14 × 3 × N and its flag says that a point is annotated: others are
/// at places outside of the photograph. The original set's is 3 × 14 × N, every point is annotated,
/// and its flag says that it is hidden.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<[LspPoint; LSP_POINTS]>, DatasetError> {
    let failed = DatasetError::mat(path);
    let file = MatFile::parse(bytes).map_err(&failed)?;
    let table = file.variable("joints").map_err(&failed)?;
    let dimensions = table.dimensions();
    let is_extended = match dimensions[..] {
        // One photograph is a table without a third dimension.
        [LSP_POINTS, VALUES] | [LSP_POINTS, VALUES, _] => true,
        [VALUES, LSP_POINTS] | [VALUES, LSP_POINTS, _] => false,
        _ => {
            let sides: Vec<String> = dimensions.iter().map(ToString::to_string).collect();
            let reason = format!("{}: it is 14×3×N or 3×14×N", sides.join("×"));
            return Err(DatasetError::malformed(path, table.path(), reason));
        }
    };
    let values = table.values().map_err(&failed)?;
    let point = |person: &[f64], point: usize| {
        // MATLAB's first dimension runs fastest.
        let value = |value: usize| match is_extended {
            true => person[value * LSP_POINTS + point],
            false => person[point * VALUES + value],
        };
        let at = DVec2::new(value(0), value(1));
        match (is_extended, value(2) != 0.0) {
            (true, false) => None,
            (true, true) | (false, false) => Some((at, Visibility::Visible)),
            (false, true) => Some((at, Visibility::Hidden)),
        }
    };
    let persons = values.chunks_exact(LSP_POINTS * VALUES);
    Ok(persons.map(|person| std::array::from_fn(|index| point(person, index))).collect())
}
