//! Recorded motion of whole bodies: CMU's motion capture as distributed (ASF and AMC).
//!
//! * [`MotionLibrary`]: the motions of a folder, less those of subjects that are kept for tests.
//! * [`Capture`]: a stretch of one of them, as somebody's motion: poses of any body of SMPL+H's
//!   skeleton.
//!
//! # Source
//! CMU motion capture database (mocap.cs.cmu.edu, free for all uses): a folder for each
//! subject with `NN.asf`, the skeleton, and `NN_MM.amc`, its motions at 120 Hz.

mod acclaim;
mod retarget;
#[cfg(test)]
mod tests;

use std::f32::consts::TAU;
use std::path::{Path, PathBuf};

use evpose_core::CounterRng;
use glam::{Mat3, Quat, Vec3};

use crate::activity::lowest_sole_m;
use crate::folder_error::{FolderError, read_text, sorted_paths};
use crate::{BodyModel, BodyPose, PosedBody, ShapedBody};

use acclaim::Skeleton;
use retarget::{Clip, leg_length};

/// Subjects whose motions are in test sets: they are never read, whatever a folder has.
pub const HELD_OUT_SUBJECTS: [u32; 2] = [1, 2];
/// How far somebody gets from where they stand, in leg lengths: longer ways are walked on the spot,
/// in part, so that a camera that stands still sees all of them.
const REACH_LEGS: f32 = 0.8;
/// How much faster or slower a motion is played.
const SPEEDS: [f32; 2] = [0.8, 1.25];

/// Motions of a folder. They are read when they are drawn.
#[derive(Debug)]
pub struct MotionLibrary {
    performers: Vec<Performer>,
}

#[derive(Debug)]
struct Performer {
    skeleton: Skeleton,
    motions: Vec<PathBuf>,
}

/// Somebody's motion: a stretch of a recorded one.
#[derive(Debug, Clone)]
pub struct Capture {
    name: String,
    clip: Clip,
    start_s: f32,
    speed: f32,
    /// Rotation about the vertical axis, in radians.
    turn_rad: f32,
    /// The middle of the way, at the height of the floor, and the share of the way that is walked.
    middle: Vec3,
    walked: f32,
}

impl MotionLibrary {
    /// Lists the motions of a folder and of all folders in it, without [`HELD_OUT_SUBJECTS`].
    ///
    /// # Errors
    /// Malformed skeletons, and a folder without any motion of other subjects.
    pub fn read(folder: &Path) -> Result<Self, FolderError> {
        let (mut performers, mut folders) = (Vec::new(), vec![folder.to_owned()]);
        while let Some(folder) = folders.pop() {
            let paths = sorted_paths(&folder)?;
            let with = |ending: &str| -> Vec<&PathBuf> {
                let is = |path: &&PathBuf| path.extension().is_some_and(|e| e == ending);
                paths.iter().filter(is).filter(|path| !is_held_out(path)).collect()
            };
            for path in with("asf") {
                let own = |motion: &&PathBuf| subject(motion) == subject(path);
                let motions: Vec<PathBuf> = with("amc").into_iter().filter(own).cloned().collect();
                if !motions.is_empty() {
                    let skeleton = Skeleton::parse(path, &read_text(path)?)?;
                    performers.push(Performer { skeleton, motions });
                }
            }
            folders.extend(paths.iter().rev().filter(|path| path.is_dir()).cloned());
        }
        if performers.is_empty() {
            let reason =
                "no .asf with .amc of its own beside it; subjects 01 and 02 are kept for tests";
            return Err(FolderError::content(folder, reason));
        }
        Ok(Self { performers })
    }

    /// Paths of all motions, in a fixed order.
    pub fn motions(&self) -> impl Iterator<Item = &Path> {
        self.performers.iter().flat_map(|performer| performer.motions.iter().map(PathBuf::as_path))
    }

    /// Draws a subject, one of its motions, and a stretch of it of `seconds`. A motion that is
    /// shorter is played to and fro.
    ///
    /// # Errors
    /// A motion that cannot be read or is malformed.
    pub fn draw(&self, rng: &mut CounterRng, seconds: f32) -> Result<Capture, FolderError> {
        let performer = &self.performers[rng.below(self.performers.len())];
        let path = &performer.motions[rng.below(performer.motions.len())];
        let clip = Clip::parse(&performer.skeleton, path, &read_text(path)?)?;
        let speed = rng.uniform(SPEEDS[0], SPEEDS[1]);
        let start_s = rng.unit() * (clip.seconds() - speed * seconds).max(0.0);
        let turn_rad = rng.uniform(0.0, TAU);
        let (low, high) = clip.bounds(start_s, start_s + speed * seconds);
        let walked =
            (REACH_LEGS / (0.5 * (high - low).with_y(0.0).length()).max(REACH_LEGS)).min(1.0);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let middle = (0.5 * (low + high)).with_y(low.y);
        Ok(Capture { name, clip, start_s, speed, turn_rad, middle, walked })
    }
}

/// Number of the subject of a file, before `_` in its name.
fn subject(path: &Path) -> Option<u32> {
    path.file_stem()?.to_str()?.split('_').next()?.parse().ok()
}

fn is_held_out(path: &Path) -> bool {
    subject(path).is_none_or(|subject| HELD_OUT_SUBJECTS.contains(&subject))
}

impl Capture {
    /// Name of the motion, such as `03_01`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The pose at a time in seconds. The lowest foot of the stretch is at height zero.
    /// `posed` is memory to work in; its joints are those of the pose afterwards.
    ///
    /// # Panics
    /// If the model is no body with both hands.
    pub fn pose(
        &self,
        t_s: f32,
        model: &BodyModel,
        shaped: &ShapedBody,
        posed: &mut PosedBody,
    ) -> BodyPose {
        let frame = self.clip.at(self.start_s + self.speed * t_s);
        let mut pose = BodyPose::rest(model);
        for (joint, rotation) in pose.joints.iter_mut().zip(frame.rotations) {
            *joint = rotation.to_scaled_axis();
        }
        for basis in model.left_hand.iter().chain([&model.right_hand]) {
            pose.set_hand(basis, &[]);
        }
        let turn = Mat3::from_rotation_y(self.turn_rad);
        pose.joints[0] = (Quat::from_mat3(&turn) * frame.rotations[0]).to_scaled_axis();
        model.pose_joints(shaped, &pose, posed);
        let leg_m = leg_length(&shaped.joints_m);
        let way_m = (frame.place - self.middle) * leg_m;
        let place_m = turn * (way_m * self.walked).with_y(0.0);
        let pelvis_m = Vec3::from(posed.joints[0].translation);
        pose.translation_m = (place_m - pelvis_m).with_y(way_m.y - lowest_sole_m(posed));
        for joint in &mut posed.joints {
            joint.translation += glam::Vec3A::from(pose.translation_m);
        }
        pose
    }
}
