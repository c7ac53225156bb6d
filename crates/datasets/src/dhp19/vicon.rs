//! Markers of the person in the room, from the motion-capture system.

use std::path::Path;

use evpose_containers::mat::{MatError, MatValue};
use evpose_core::Micros;
use evpose_pose::body::{BODY_JOINTS, network_from_file};
use glam::DVec3;

use crate::DatasetError;
use crate::open::open_mat;

/// Fields of the joints, in the order of files.
const FIELDS: [&str; BODY_JOINTS] = [
    "head",
    "shoulderR",
    "shoulderL",
    "elbowR",
    "elbowL",
    "hipL",
    "hipR",
    "handR",
    "handL",
    "kneeR",
    "kneeL",
    "footR",
    "footL",
];
/// From one pose to the next: 100 a second.
pub const POSE_INTERVAL: Micros = Micros(10_000);

/// Joints of a person in the room, in millimetres, in the order of networks; none where the system
/// lost a marker.
pub type Pose = [Option<DVec3>; BODY_JOINTS];

/// Reads the poses of a movement: a structure `XYZPOS` with a field for each joint, of as many rows
/// as there are poses and three columns. The first pose is that of the beginning.
///
/// # Errors
/// If the file cannot be read or holds something else.
pub fn read_vicon(path: &Path) -> Result<Vec<Pose>, DatasetError> {
    let file = open_mat(path)?;
    let all = file.variable("XYZPOS").map_err(DatasetError::mat(path))?;
    let mut rows = None;
    let mut joints = Vec::with_capacity(BODY_JOINTS);
    for name in FIELDS {
        let joint = all.field(name).map_err(DatasetError::mat(path))?;
        let positions = positions(joint).map_err(DatasetError::mat(path))?;
        // A pose is one row of every joint.
        let rows = *rows.get_or_insert(positions.len());
        if positions.len() != rows {
            let reason = format!("{} poses, but `{}` has {rows}", positions.len(), FIELDS[0]);
            return Err(DatasetError::malformed(path, joint.path(), reason));
        }
        joints.push(positions);
    }
    let pose = |row: usize| network_from_file(&std::array::from_fn(|joint| joints[joint][row]));
    Ok((0..rows.unwrap_or_default()).map(pose).collect())
}

fn positions(joint: MatValue<'_>) -> Result<Vec<Option<DVec3>>, MatError> {
    let &[rows, 3] = joint.dimensions().as_slice() else {
        let sizes: Vec<String> = joint.dimensions().iter().map(ToString::to_string).collect();
        let (expected, actual) = ("an array of three columns", format!("of {}", sizes.join("×")));
        return Err(MatError::Kind { path: joint.path(), expected, actual });
    };
    let values = joint.values()?;
    // MATLAB stores matrices by columns.
    let position = |row: usize| DVec3::from([0, 1, 2].map(|column| values[column * rows + row]));
    Ok((0..rows).map(|row| Some(position(row)).filter(|at| at.is_finite())).collect())
}
