//! The rig: where joints are in the mesh, and which move which vertices.

use std::collections::BTreeMap;
use std::path::Path;

use glam::Vec3;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::folder_error::{FolderError, read_text};
use crate::skeleton::{BODY_JOINTS, HAND_JOINTS, JOINTS};

use super::obj::BaseMesh;

/// Names of the body's bones in the order of SMPL+H's joints.
const BODY: &str = "pelvis thigh_l thigh_r spine_01 calf_l calf_r spine_02 foot_l foot_r spine_03 \
    ball_l ball_r neck_01 clavicle_l clavicle_r head upperarm_l upperarm_r lowerarm_l lowerarm_r \
    hand_l hand_r";
const DIGITS: [&str; 5] = ["index", "middle", "pinky", "ring", "thumb"];
/// Number of the joint of the head, and of the neck.
pub(super) const HEAD: usize = 15;
const NECK: usize = 12;

/// Name of the bone of a joint of SMPL+H.
pub(super) fn bone_of(joint: usize) -> String {
    let Some(k) = joint.checked_sub(BODY_JOINTS) else {
        return BODY.split_whitespace().nth(joint).unwrap_or_default().to_owned();
    };
    let side = if k < HAND_JOINTS { 'l' } else { 'r' };
    format!("{}_0{}_{side}", DIGITS[k % HAND_JOINTS / 3], k % 3 + 1)
}

#[derive(Deserialize)]
struct Bone {
    head: BoneEnd,
    tail: BoneEnd,
}

#[derive(Deserialize)]
struct BoneEnd {
    strategy: String,
    #[serde(default)]
    cube_name: String,
}

type BoneWeights = Vec<(u32, f32)>;

#[derive(Deserialize)]
struct Weights {
    weights: BTreeMap<String, BoneWeights>,
}

/// The rig of a base mesh.
pub(super) struct Rig {
    /// Vertices whose mean is the position of each joint.
    heads: Vec<Vec<u32>>,
    /// The same for the ends of the ten digits, left hand first.
    tips: Vec<Vec<u32>>,
    weights: Vec<BoneWeights>,
    weights_path: std::path::PathBuf,
}

impl Rig {
    /// Reads the rig and its weights from their folder.
    pub(super) fn read(folder: &Path, mesh: &BaseMesh) -> Result<Self, FolderError> {
        let path = folder.join("rig.game_engine.json");
        let bones: BTreeMap<String, Bone> = json(&path)?;
        let bone = |joint: usize| {
            let name = bone_of(joint);
            let missing = || FolderError::content(&path, format!("no bone `{name}`"));
            bones.get(&name).ok_or_else(missing)
        };
        let cube = |end: &BoneEnd| {
            let vertices = mesh.group(&end.cube_name);
            if end.strategy != "CUBE" || vertices.is_empty() {
                let reason = format!(
                    "an end of a bone by `{}` at `{}`; a group of {} expected",
                    end.strategy,
                    end.cube_name,
                    mesh.path.display()
                );
                return Err(FolderError::content(&path, reason));
            }
            Ok(vertices)
        };
        let heads = (0..JOINTS).map(|joint| cube(&bone(joint)?.head)).collect::<Result<_, _>>()?;
        let last = |digit: usize| BODY_JOINTS + 3 * digit + 2;
        let tips = (0..10).map(|digit| cube(&bone(last(digit))?.tail)).collect::<Result<_, _>>()?;
        let weights_path = folder.join("weights.game_engine.json");
        let Weights { mut weights } = json(&weights_path)?;
        let mut of_bone = |joint| weights.remove(&bone_of(joint)).unwrap_or_default();
        let weights = (0..JOINTS).map(&mut of_bone).collect();
        Ok(Self { heads, tips, weights, weights_path })
    }

    /// Joints in the middle of their vertices. That of the head is lowered to the middle between
    /// MakeHuman's and the neck's, where SMPL has it: labels lie above it.
    pub(super) fn joints(&self, points: &[Vec3]) -> [Vec3; JOINTS] {
        let mut joints = std::array::from_fn(|joint| middle(&self.heads[joint], points));
        joints[HEAD] = 0.5 * (joints[HEAD] + joints[NECK]);
        joints
    }

    /// Ends of the digits: index, middle, pinky, ring, thumb of the left and of the right hand.
    pub(super) fn tips(&self, points: &[Vec3]) -> [Vec3; 10] {
        std::array::from_fn(|digit| middle(&self.tips[digit], points))
    }

    /// Joints of each of the `kept` vertices with their shares, which sum to one.
    pub(super) fn shares(&self, kept: &[u32]) -> Result<Vec<Vec<(usize, f32)>>, FolderError> {
        let mut shares = vec![Vec::new(); kept.len()];
        for (joint, weights) in self.weights.iter().enumerate() {
            for &(vertex, weight) in weights.iter().filter(|(_, weight)| *weight > 0.0) {
                // Vertices that were not kept have no place.
                if let Ok(place) = kept.binary_search(&vertex) {
                    shares[place].push((joint, weight));
                }
            }
        }
        for (shares, vertex) in shares.iter_mut().zip(kept) {
            let sum: f32 = shares.iter().map(|(_, weight)| weight).sum();
            if !(0.5..2.0).contains(&sum) {
                let reason = format!("the weights of vertex {vertex} have sum {sum}, expected 1");
                return Err(FolderError::content(&self.weights_path, reason));
            }
            shares.iter_mut().for_each(|(_, weight)| *weight /= sum);
        }
        Ok(shares)
    }
}

fn middle(vertices: &[u32], points: &[Vec3]) -> Vec3 {
    vertices.iter().map(|&v| points[v as usize]).sum::<Vec3>() / vertices.len() as f32
}

fn json<T: DeserializeOwned>(path: &Path) -> Result<T, FolderError> {
    let fault = |error: serde_json::Error| {
        FolderError::content(path, format!("not as MakeHuman's: {error}"))
    };
    serde_json::from_str(&read_text(path)?).map_err(fault)
}
