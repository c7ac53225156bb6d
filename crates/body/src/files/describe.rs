//! The description of a model that `evpose info` prints.

use std::fmt;

use evpose_pose::HandSide;
use glam::Vec3;

use super::{ModelFile, ModelKind};

impl fmt::Display for ModelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Hand(HandSide::Right) => "right hand (MANO)",
            Self::Hand(HandSide::Left) => "left hand (MANO)",
            Self::Jointed(HandSide::Right) => "right hand (joints of WebXR)",
            Self::Jointed(HandSide::Left) => "left hand (joints of WebXR)",
            Self::Body => "body with both hands (SMPL+H)",
        })
    }
}

impl ModelFile {
    /// Size of the mean shape in the rest pose along x, y and z, in metres.
    pub fn extent_m(&self) -> Vec3 {
        let vertices_m = &self.model.template_m;
        let least = vertices_m.iter().copied().reduce(Vec3::min);
        let most = vertices_m.iter().copied().reduce(Vec3::max);
        most.unwrap_or_default() - least.unwrap_or_default()
    }
}

impl fmt::Display for ModelFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let model = &self.model;
        writeln!(f, "  model     {}", self.kind)?;
        writeln!(f, "  format    {}", self.format)?;
        let (vertices, faces) = (model.template_m.len(), model.faces.len());
        writeln!(f, "  surface   {vertices} vertices, {faces} triangles")?;
        writeln!(f, "  joints    {}", model.parents.len())?;
        writeln!(f, "  shape     {} directions", model.shape_directions_m.len())?;
        writeln!(f, "  pose      {} corrective directions", model.pose_directions_m.len())?;
        writeln!(f, "  hand      {} components of articulation", self.hand_components)?;
        let mut crowded: Vec<u32> = model.further_weights.iter().map(|more| more.vertex).collect();
        // Weights of a vertex follow each other.
        crowded.dedup();
        let crowded = crowded.len();
        writeln!(f, "  skinning  {crowded} vertices moved by more than four joints")?;
        let size_mm = self.extent_m() * 1e3;
        writeln!(f, "  extent    {:.0} x {:.0} x {:.0} mm", size_mm.x, size_mm.y, size_mm.z)?;
        for missing in &self.missing {
            writeln!(f, "  missing   {missing}")?;
        }
        Ok(())
    }
}
