//! Parametric body models: the SMPL family, a procedural arm and human, skinning and motion.
//!
//! * [`BodyModel`]: a linear-blend-skinned body of the SMPL family; [`BodyModel::procedural_arm`]
//!   and [`BodyModel::procedural_human`] are procedural, [`files`] reads the published hand and
//!   body models into the same type, [`MakeHuman`] that of its distributed files.
//! * [`ShapedBody`], [`BodyPose`], [`PosedBody`]: one person, one pose, and the two together.
//! * [`HandSkeleton`]: the evaluated points of a hand without its surface; [`HandFit`]: the hand that fits
//!   such points where a network sees them.
//! * [`motion`]: the published random motion of arm and hand; [`activity`]: activities of a whole
//!   body; [`mocap`]: recorded motion of a whole body.
//! * [`fingers`]: gestures, and fingers that move by themselves.
//! * [`skeleton`], [`texture_layout`], [`clothes_layout`]: joint indices, and the texture layouts
//!   of skin and clothes.
//!
//! World coordinates are the model's: x to the body's left, y up, z forward, in metres.
//!
//! ```
//! use evpose_body::{BodyModel, BodyPose, PosedBody, motion::{BezierMotion, MotionConfig}};
//!
//! let model = BodyModel::procedural_arm();
//! let person = model.shaped(&[0.5, -1.0]);
//! let mut motion = BezierMotion::new(MotionConfig::default(), 7, 1000);
//! let mut body = PosedBody::default();
//! let target = *motion.step();
//! let pose = BodyPose::from_generator(&model, &target.parameters, target.translation_m);
//! model.pose(&person, &pose, &mut body);
//! let label = body.hand_params(&model, target.articulation());
//! assert_eq!(label.translation_m, body.evaluation_points(&model)[0]);
//! ```

pub mod activity;
pub mod clothes_layout;
pub mod files;
pub mod fingers;
mod folder_error;
mod hand_fit;
mod hand_skeleton;
mod human;
mod implicit;
mod makehuman;
pub mod mocap;
mod model;
pub mod motion;
mod normals;
mod pose;
mod posed;
mod procedural;
mod right_arm;
pub mod skeleton;
mod skinning;
pub mod texture_layout;

pub use evpose_pose::rotation;
pub use folder_error::FolderError;
pub use hand_fit::{FittedPose, HandFit, JointObservation};
pub use hand_skeleton::HandSkeleton;
pub use human::Garments;
pub use makehuman::{MacroTarget, MakeHuman};
pub use model::{BodyModel, FurtherWeight, HandBasis, ShapeSpace, ShapedBody, SkinWeights};

pub use pose::{BodyPose, GENERATOR_PARAMETERS};
pub use posed::PosedBody;
