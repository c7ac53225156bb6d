//! Linear-blend-skinned models of the SMPL family, from any source.

use std::borrow::Cow;

use glam::{Vec2, Vec3};

use crate::makehuman::{MACROS, MacroTarget, macros_of};
use crate::normals::area_weighted_normals;

/// A body, or part of one, that shape and pose coefficients deform.
///
/// # Model
/// SMPL: `vertices = template + Σ βᵢ·shape directionᵢ`, `joints = offsets + regressor·vertices`,
/// then skinning with the joints' rigid transforms ([`Self::pose`]).
///
/// # Source
/// Loper et al., *SMPL* (SIGGRAPH Asia 2015); Romero et al., *Embodied Hands* (2017) for the hands.
#[derive(Debug, Clone)]
pub struct BodyModel {
    /// Vertices in the rest pose where no shape direction counts, in metres: the mean shape, of SMPL
    /// and of procedural models.
    pub template_m: Vec<Vec3>,
    /// Displacement of every vertex per unit of every shape direction, in metres.
    pub shape_directions_m: Vec<Vec<Vec3>>,
    /// How shape coefficients weigh the shape directions.
    pub shape_space: ShapeSpace,
    /// Displacement of every vertex per unit of every entry of `R − I` of joints 1.., row by row,
    /// in metres. Empty: the model has no pose correctives.
    pub pose_directions_m: Vec<Vec<Vec3>>,
    /// Sparse row of every joint: joints are weighted sums of vertices.
    pub joint_regressor: Vec<Vec<(u32, f32)>>,
    /// Offsets of the weighted sums, in metres: of joints that no vertices surround. Zero in
    /// SMPL-family files.
    pub joint_offsets_m: Vec<Vec3>,
    /// Displacement of every joint per unit of every shape direction, beside that of the vertices
    /// in its row, in metres. Empty: none; not so where a surface was cut off its joints.
    pub joint_directions_m: Vec<Vec<Vec3>>,
    /// The joint each joint hangs on; a parent comes before its children.
    pub parents: Vec<Option<usize>>,
    /// Skin weights of each vertex, up to four joints.
    pub skin: Vec<SkinWeights>,
    /// Joints beyond a vertex's four, ascending by vertex; none in the procedural arm. They lie
    /// apart because few vertices of the published models have any, and four fit a vector register.
    pub further_weights: Vec<FurtherWeight>,
    /// Triangles, counterclockwise from outside.
    pub faces: Vec<[u32; 3]>,
    /// Texture coordinates of each vertex; [`crate::texture_layout`] for the procedural arm, all
    /// zero where a file has none.
    pub uvs: Vec<Vec2>,
    /// Articulation of the left hand, if there are two.
    pub left_hand: Option<HandBasis>,
    /// Articulation of the hand that is estimated: the right one, or the only one.
    pub right_hand: HandBasis,
    /// Index of the joint at the wrist of the estimated hand.
    pub wrist: usize,
    /// Vertices at the tips of its thumb, index, middle, ring and pinky.
    pub fingertips: [u32; 5],
}

/// How shape coefficients become weights of shape directions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ShapeSpace {
    /// Each coefficient is the weight of its direction.
    Linear,
    /// Directions are MakeHuman's targets, coefficients its macro parameters: zero is the middle.
    Macros(Vec<MacroTarget>),
}

impl ShapeSpace {
    /// Weights of the shape directions; coefficients, or weights, that are missing are zero.
    pub(crate) fn weights<'a>(&self, betas: &'a [f32]) -> Cow<'a, [f32]> {
        match self {
            Self::Linear => Cow::Borrowed(betas),
            Self::Macros(targets) => {
                let macros = macros_of(betas);
                targets.iter().map(|target| target.weight(&macros)).collect()
            }
        }
    }
}

/// The joints that move a vertex, strongest first, and by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinWeights {
    /// Joints of the model; it does not matter which where the weight is zero.
    pub joints: [u8; 4],
    /// Weights, descending, with sum one; with what [`BodyModel::further_weights`] adds.
    pub weights: [f32; 4],
}

impl SkinWeights {
    /// The four strongest of `weights`, scaled to sum one.
    ///
    /// # Panics
    /// If none is positive.
    pub fn strongest(weights: impl IntoIterator<Item = (usize, f32)>) -> Self {
        let mut sorted: Vec<(usize, f32)> =
            weights.into_iter().filter(|&(_, weight)| weight > 1e-4).collect();
        sorted.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        sorted.truncate(4);
        let total: f32 = sorted.iter().map(|&(_, weight)| weight).sum();
        assert!(total > 0.0, "a vertex no joint moves");
        let mut skin = Self { joints: [0; 4], weights: [0.0; 4] };
        for (slot, (joint, weight)) in sorted.into_iter().enumerate() {
            skin.joints[slot] = joint as u8;
            skin.weights[slot] = weight / total;
        }
        skin
    }

    /// Joints and weights other than zero.
    pub fn iter(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        self.joints
            .iter()
            .zip(&self.weights)
            .map(|(&joint, &weight)| (usize::from(joint), weight))
            .take_while(|&(_, weight)| weight > 0.0)
    }
}

/// A joint that moves a vertex beside the four of its [`SkinWeights`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FurtherWeight {
    /// Index of the vertex.
    pub vertex: u32,
    /// Index of the joint.
    pub joint: u8,
    /// By how much.
    pub weight: f32,
}

/// Coefficients of a hand's articulation to axis-angles of its 15 joints.
///
/// `angles = mean + Σ coefficientᵢ · componentᵢ`, 45 angles in radians: index, middle, pinky, ring,
/// thumb; three joints each.
#[derive(Debug, Clone, PartialEq)]
pub struct HandBasis {
    /// The first of its 15 joints.
    pub first_joint: usize,
    /// Angles of coefficients zero.
    pub mean: [f32; 45],
    /// One component a row.
    pub components: Box<[[f32; 45]; 45]>,
}

impl HandBasis {
    /// Axis-angle of the `joint`-th of the 15 joints; coefficients that are missing are zero.
    pub fn rotation(&self, joint: usize, coefficients: &[f32]) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|axis| {
            let entry = 3 * joint + axis;
            let rows = self.components.iter().zip(coefficients);
            self.mean[entry] + rows.map(|(row, coefficient)| row[entry] * coefficient).sum::<f32>()
        }))
    }
}

/// One person: a model with its shape coefficients applied, in the rest pose.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapedBody {
    /// Vertices in metres.
    pub vertices_m: Vec<Vec3>,
    /// Outward unit normals.
    pub normals: Vec<Vec3>,
    /// Joints in metres.
    pub joints_m: Vec<Vec3>,
}

impl BodyModel {
    /// Number of shape coefficients.
    pub fn shape_coefficients(&self) -> usize {
        match self.shape_space {
            ShapeSpace::Linear => self.shape_directions_m.len(),
            ShapeSpace::Macros(_) => MACROS,
        }
    }

    /// The model with shape coefficients `betas`; those that are missing are zero.
    ///
    /// # Panics
    /// If there are more than the model has.
    pub fn shaped(&self, betas: &[f32]) -> ShapedBody {
        let known = self.shape_coefficients();
        assert!(betas.len() <= known, "{} shape coefficients for a model of {known}", betas.len());
        self.blended(&self.shape_space.weights(betas))
    }

    /// The model with weights of its shape directions; those that are missing are zero.
    pub(crate) fn blended(&self, weights: &[f32]) -> ShapedBody {
        let mut vertices_m = self.template_m.clone();
        let directions = self.shape_directions_m.iter().zip(weights);
        // Of several hundred targets, most do not count.
        for (direction_m, &weight) in directions.filter(|(_, weight)| **weight != 0.0) {
            for (vertex_m, &offset_m) in vertices_m.iter_mut().zip(direction_m) {
                *vertex_m += offset_m * weight;
            }
        }
        let mut joints_m: Vec<Vec3> = self
            .joint_regressor
            .iter()
            .zip(&self.joint_offsets_m)
            .map(|(row, &offset_m)| {
                row.iter().fold(offset_m, |sum, &(vertex, weight)| {
                    sum + vertices_m[vertex as usize] * weight
                })
            })
            .collect();
        // Joints may move by themselves, beside what the regressor says.
        for (direction_m, &weight) in self.joint_directions_m.iter().zip(weights) {
            for (joint_m, &offset_m) in joints_m.iter_mut().zip(direction_m) {
                *joint_m += offset_m * weight;
            }
        }
        let normals = area_weighted_normals(&vertices_m, &self.faces);
        ShapedBody { vertices_m, normals, joints_m }
    }
}
