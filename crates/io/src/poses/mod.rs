//! Poses of a hand, a person or another thing over time: one set of names, as a table and as JSON.
//!
//! | column | unit | |
//! |---|---|---|
//! | `t_us` | µs | time stamp, on the recording's clock |
//! | `origin` | | `network`, `propagated`, or `nobody` of a row without a pose |
//! | `latency_ms` | ms | from the newest event that the pose depends on to the pose |
//! | `score` | 0 to 1 | of the pose; empty where the network has none |
//! | `frame` | | of `_x_m`, `_y_m`, `_z_m`: `camera` or `world` |
//! | `articulation_1` … `rotation_z_rad` | | [`PARAMETER_NAMES`](evpose_pose::PARAMETER_NAMES), hands |
//! | | | the values of a registered [`PoseLayout`](evpose_pose::PoseLayout), other tasks |
//! | `JOINT_u_px`, `JOINT_v_px` | px | on the sensor, from the outer corner of the top left pixel |
//! | `JOINT_score` | 0 to 1 | of the joint, people |
//! | `JOINT_x_m`, `JOINT_y_m`, `JOINT_z_m` | m | in `frame`, hands |
//!
//! Columns are found by their names, in any order, and cells without a value are empty.
//!
//! * [`PoseSequence`], [`TimedPose`], [`PoseJoint`]: the poses.
//! * [`PoseColumns`]: lines of the table. [`json_line`]: the same as JSON.
//! * [`POSE_FORMATS`], [`read_poses`], [`write_poses`]: these and the layouts of other programs,
//!   one file each.

mod columns;
mod format;
mod hpe_core;
mod json;
mod parquet;
mod pose;
mod registry;
mod rotations;
mod skeletons;
mod table;
#[cfg(test)]
mod tests;

pub use columns::PoseColumns;
pub use format::{PoseFormat, PoseIterator};
pub use json::json_line;
pub use pose::{PoseJoint, PoseKind, PoseSequence, TimedPose};
pub use registry::{
    POSE_FORMATS, pose_format_of, poses_from, read_poses, write_poses, write_poses_from,
};
pub use rotations::{HandRotationRow, write_hand_rotations};
pub use table::read_pose_table;
