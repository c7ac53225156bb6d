//! Bodies: the maps that a network outputs, and the joints decoded from them.
//!
//! * [`JOINT_NAMES`], [`LIMBS`], [`MIRRORED`]: thirteen joints in the order of networks, and
//!   [`network_from_file`] for the other.
//! * [`BodyLabel`]: the annotation of the person in an image.
//! * [`BodyMaps`]: heatmaps, centres, regressions and offsets.
//! * [`BodyDecoder`]: from maps to [`BodyJoint`]s.
//! * [`OpenPoseDecoder`], [`movenet_joints`], [`joints_of_coco`]: outputs of networks of others.
//! * [`fusion`]: detections fused with velocities measured from events; [`BodyFollower`] does both.
//! * [`pose_score`], [`PresenceScore`]: whether somebody is there.
//! * [`triangulation`]: points in the world from several cameras, and [`SpatialFilter`] over time.
//! * [`velocity`]: velocities of joints, measured from events.

mod coco;
mod decoder;
mod definition;
mod follower;
pub mod fusion;
mod joint;
mod label;
mod maps;
mod movenet;
mod openpose;
mod score;
mod skeleton;
mod spatial_filter;
pub mod triangulation;
pub mod velocity;

pub use coco::{COCO_KEYPOINT_NAMES, COCO_KEYPOINTS, joints_of_coco};
pub use decoder::{BodyDecoder, DEFAULT_SOFTENING, DEFAULT_THRESHOLD};
pub use definition::JointDefinition;
pub use follower::BodyFollower;
pub use joint::BodyJoint;
pub use label::{BodyLabel, Keypoint, Visibility};
pub use maps::BodyMaps;
pub use movenet::{MOVENET_VALUES, movenet_joints};
pub use openpose::{OpenPoseDecoder, OpenPoseModel, OpenPoseOptions, OpenPosePerson};
pub use score::{PresenceScore, pose_score, score_of_joints};
pub use skeleton::{
    BODY_JOINTS, BodyPoints, JOINT_NAMES, LIMBS, MIRRORED, file_from_network, network_from_file,
    number, torso,
};
pub use spatial_filter::{SpatialFilter, SpatialFilterConfig, WorldJoints};
