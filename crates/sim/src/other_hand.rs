//! Another hand before the camera, farther away than the one that is labelled.
//!
//! # Model
//! The mirror image of the same arm, with a motion of its own. It is moved along the camera's axis by what its wrist lacks
//! to be [`BEHIND_M`] farther away than the labelled one.

use evpose_body::motion::ViewTest;
use evpose_body::{PosedBody, ShapedBody};
use evpose_core::LookAt;
use evpose_pose::{HandParams, HandSide, Mirror};
use glam::{Vec2, Vec3};

use crate::actor::Actor;
use crate::config::SimulationConfig;
use crate::moving_hand::MovingHand;
use crate::raster::Mesh;
use crate::stopwatch::Stopwatch;

/// The least by which the wrist is farther from the camera, in metres.
const BEHIND_M: f32 = 0.1;
/// Its index among the hands of a sequence.
const INDEX: u64 = 1;

/// The other hand, and the mesh of both.
#[derive(Debug)]
pub(crate) struct OtherHand {
    hand: MovingHand,
    placement: LookAt,
    vertices_m: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    faces: Vec<[u32; 3]>,
}

impl OtherHand {
    /// That beside a labelled hand of `side`.
    pub(crate) fn new(
        actor: &Actor,
        shaped: &ShapedBody,
        config: &SimulationConfig,
        side: HandSide,
        view: &ViewTest,
        seed: u64,
    ) -> Self {
        let (uvs, faces) = (&actor.body().uvs, actor.faces(side));
        let first = uvs.len() as u32;
        // A mirror turns the winding around.
        let mirrored = faces.iter().map(|&[a, b, c]| [first + a, first + c, first + b]);
        Self {
            hand: MovingHand::new(actor, shaped, config, view, (seed, INDEX)),
            placement: config.placement(),
            vertices_m: Vec::new(),
            normals: Vec::new(),
            uvs: uvs.repeat(2),
            faces: faces.iter().copied().chain(mirrored).collect(),
        }
    }

    /// Moves on by a step, behind the labelled hand `posed`, whose parameters as a right one are `labelled`.
    pub(crate) fn step(
        &mut self,
        actor: &Actor,
        shaped: &ShapedBody,
        (view, mirror): (&ViewTest, &Mirror),
        (posed, labelled): (&PosedBody, &HandParams),
    ) {
        let own = self.hand.step(actor, shaped, (view, mirror), &mut Stopwatch::default());
        let LookAt { eye_m, centre_m, .. } = self.placement;
        let forward = (centre_m - eye_m).normalize();
        // Along the axis, a mirror image lies as far away as what it is of.
        let nearer_m = forward.dot(labelled.translation_m - own.translation_m) + BEHIND_M;
        let back_m = nearer_m.max(0.0) * forward;
        let turned = |normal: &Vec3| mirror.point(*normal) - mirror.point(Vec3::ZERO);
        let other = &self.hand.posed;
        self.vertices_m.clear();
        self.vertices_m.extend_from_slice(&posed.vertices_m);
        self.vertices_m.extend(other.vertices_m.iter().map(|m| mirror.point(*m) + back_m));
        self.normals.clear();
        self.normals.extend_from_slice(&posed.normals);
        self.normals.extend(other.normals.iter().map(turned));
    }

    /// The mesh of both hands.
    pub(crate) fn mesh(&self) -> Mesh<'_> {
        let Self { vertices_m, normals, uvs, faces, .. } = self;
        Mesh { vertices_m, normals, uvs, faces }
    }
}
