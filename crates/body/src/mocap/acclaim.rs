//! Acclaim's formats: a skeleton (ASF), and a motion of it (AMC).
//!
//! # Model
//! Every bone has a direction in the world at rest and axes C, about which it turns by the angles of
//! a frame: `G = G_parent·C·Rz·Ry·Rx·C⁻¹` turns it from rest. Angles are degrees, y is up.

use std::path::Path;

use glam::{Mat3, Vec3};

use crate::folder_error::FolderError;

/// Degrees of freedom that a bone can have.
const DEGREES_OF_FREEDOM: [&str; 6] = ["tx", "ty", "tz", "rx", "ry", "rz"];

/// A skeleton at rest; the first bone is the root.
#[derive(Debug)]
pub(super) struct Skeleton {
    pub(super) bones: Vec<Bone>,
}

#[derive(Debug)]
pub(super) struct Bone {
    pub(super) name: String,
    pub(super) parent: usize,
    /// Unit vector.
    pub(super) direction: Vec3,
    pub(super) length: f32,
    /// Columns are the axes about which the bone turns.
    pub(super) axes: Mat3,
    /// Values of a frame, as indices of [`DEGREES_OF_FREEDOM`].
    values: Vec<usize>,
}

/// Pose of a skeleton in the world.
pub(super) struct SkeletonPose {
    /// Rotation of each bone from rest.
    pub(super) rotations: Vec<Mat3>,
    /// End of each bone, in the skeleton's unit; of the root, its position.
    pub(super) ends: Vec<Vec3>,
}

/// `Rz·Ry·Rx` of angles in degrees.
fn rotation(degrees: Vec3) -> Mat3 {
    let [x, y, z] = degrees.to_array().map(f32::to_radians);
    Mat3::from_rotation_z(z) * Mat3::from_rotation_y(y) * Mat3::from_rotation_x(x)
}

impl Skeleton {
    /// Parses an ASF file; `path` is for messages.
    pub(super) fn parse(path: &Path, text: &str) -> Result<Self, FolderError> {
        // The root is not listed among the bones.
        let mut bones = vec![Bone::new("root")];
        let (mut section, mut parents) = ("", Vec::new());
        for (line, row) in text.lines().enumerate() {
            let words: Vec<&str> = row.split_whitespace().collect();
            let fault = |reason: &str| FolderError::line(path, line, reason);
            let (Some(&key), rest) = (words.first(), words.get(1..).unwrap_or_default()) else {
                continue;
            };
            if key.starts_with(':') {
                section = key;
                continue;
            }
            if section == ":hierarchy" && !matches!(key, "begin" | "end") {
                // Resolved at the end, when all bones are known.
                parents.push((line, words));
                continue;
            }
            let last = bones.len() - 1;
            let bone = &mut bones[if section == ":root" { 0 } else { last }];
            match (section, key) {
                (":units", "angle") if rest != ["deg"] => {
                    return Err(fault("angles in degrees expected"));
                }
                (":bonedata", "begin") => bones.push(Bone::new("")),
                (":bonedata", "name") => bone.name = rest.join(" "),
                (":bonedata", "direction") => {
                    let direction = vector(rest).and_then(Vec3::try_normalize);
                    bone.direction = direction.ok_or_else(|| fault("a direction expected"))?;
                }
                (":bonedata", "length") => {
                    let length = rest.first().and_then(|word| word.parse().ok());
                    bone.length = length.ok_or_else(|| fault("a length expected"))?;
                }
                (":bonedata", "axis") | (":root", "orientation") => {
                    let (angles, order) = rest.split_at(rest.len().min(3));
                    let angles = vector(angles).filter(|_| matches!(order, [] | ["XYZ"]));
                    bone.axes =
                        rotation(angles.ok_or_else(|| fault("three angles and XYZ expected"))?);
                }
                (":bonedata", "dof") | (":root", "order") => {
                    let known = |word: &&str| {
                        DEGREES_OF_FREEDOM.iter().position(|dof| dof.eq_ignore_ascii_case(word))
                    };
                    let values: Option<_> = rest.iter().map(known).collect();
                    bone.values = values.ok_or_else(|| fault("unknown degree of freedom"))?;
                }
                _ => {}
            }
        }
        for (line, words) in parents {
            let place = |name: &str| {
                let fault = || FolderError::line(path, line, format!("no bone `{name}`"));
                bones.iter().position(|bone| bone.name == name).ok_or_else(fault)
            };
            let places = words.iter().map(|name| place(name)).collect::<Result<Vec<_>, _>>()?;
            for &child in &places[1..] {
                // Poses are computed in this order.
                if child <= places[0] {
                    let reason = format!("`{}` comes before its parent", bones[child].name);
                    return Err(FolderError::line(path, line, reason));
                }
                bones[child].parent = places[0];
            }
        }
        Ok(Self { bones })
    }

    pub(super) fn bone(&self, name: &str) -> Option<usize> {
        self.bones.iter().position(|bone| bone.name == name)
    }

    /// Parses every `every`-th frame of an AMC file and passes its pose to `visit`.
    pub(super) fn frames(
        &self,
        path: &Path,
        text: &str,
        every: usize,
        mut visit: impl FnMut(&SkeletonPose),
    ) -> Result<(), FolderError> {
        let mut angles = vec![[0.0; 6]; self.bones.len()];
        let mut number: Option<usize> = None;
        for (line, row) in text.lines().enumerate() {
            let fault = |reason: String| FolderError::line(path, line, reason);
            let mut words = row.split_whitespace();
            let Some(key) = words.next().filter(|key| !key.starts_with(['#', ':'])) else {
                continue;
            };
            // Frames count from 1.
            let is_used =
                |number: Option<usize>| number.is_some_and(|n| (n - 1).is_multiple_of(every));
            if let Ok(next) = key.parse::<usize>() {
                if next != number.map_or(1, |number| number + 1) {
                    return Err(fault(format!("frame {next} out of order")));
                }
                // A frame is complete when the next one begins.
                if is_used(number) {
                    visit(&self.pose(&angles));
                }
                number = Some(next);
            } else if is_used(number) {
                let bone = self.bone(key).ok_or_else(|| fault(format!("no bone `{key}`")))?;
                let values: Option<Vec<f32>> = words.map(|word| word.parse().ok()).collect();
                let values = values.filter(|values| values.iter().all(|value| value.is_finite()));
                let freedoms = &self.bones[bone].values;
                match values {
                    Some(values) if values.len() == freedoms.len() => {
                        freedoms.iter().zip(values).for_each(|(&k, value)| angles[bone][k] = value);
                    }
                    _ => return Err(fault(format!("{} values expected", freedoms.len()))),
                }
            }
        }
        // Nothing follows the last frame.
        if number.is_some_and(|n| (n - 1).is_multiple_of(every)) {
            visit(&self.pose(&angles));
        }
        Ok(())
    }

    fn pose(&self, values: &[[f32; 6]]) -> SkeletonPose {
        let (mut rotations, mut ends) = (Vec::<Mat3>::new(), Vec::<Vec3>::new());
        for (place, (bone, &[tx, ty, tz, rx, ry, rz])) in self.bones.iter().zip(values).enumerate()
        {
            // Angles are about the bone's axes, directions are in the skeleton's.
            let own = bone.axes * rotation(Vec3::new(rx, ry, rz)) * bone.axes.transpose();
            if place == 0 {
                rotations.push(own);
                ends.push(Vec3::new(tx, ty, tz));
                continue;
            }
            let rotation = rotations[bone.parent] * own;
            ends.push(ends[bone.parent] + rotation * bone.direction * bone.length);
            rotations.push(rotation);
        }
        SkeletonPose { rotations, ends }
    }
}

impl Bone {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            parent: 0,
            direction: Vec3::ZERO,
            length: 0.0,
            axes: Mat3::IDENTITY,
            values: Vec::new(),
        }
    }
}

fn vector(words: &[&str]) -> Option<Vec3> {
    let values: Option<Vec<f32>> = words.iter().map(|word| word.parse().ok()).collect();
    Some(Vec3::from_array(values?.try_into().ok()?))
}
