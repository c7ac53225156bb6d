//! Whose hand is simulated and labelled: a model, and which side of it is shown.
//!
//! # Model
//! The published motion moves a body with an arm. A model that is only a hand hangs on the wrist of
//! the procedural arm, of which nothing else is seen.
//!
//! The other hand of a model is its mirror image in the camera's upright plane of symmetry: the
//! model is rendered by a camera whose image is mirrored, and its numbers are those of the left hand
//! in the same mirror ([`Mirror`]). So a run of left hands moves as one of right hands does.

use std::path::Path;

use evpose_body::files::ModelFile;
use evpose_body::skeleton::JOINTS;
use evpose_body::{BodyModel, BodyPose, PosedBody, ShapedBody};
use evpose_core::LookAt;
use evpose_pose::{EVALUATION_JOINTS, HandParams, HandSide, Mirror};
use glam::{Vec2, Vec3};

use crate::SimError;
use crate::config::{BodyConfig, BodySource, CameraConfig};
use crate::raster::is_closed;
use crate::texture::metres_per_texture;

/// Points of the hand that are evaluated.
pub type HandPoints3 = [Vec3; EVALUATION_JOINTS.len()];

/// A model of a hand before a camera.
#[derive(Debug, Clone)]
pub struct Actor {
    body: BodyModel,
    /// The hand the model has.
    own: HandSide,
    /// The arm that moves a model without one, and its neutral shape.
    carrier: Option<(BodyModel, ShapedBody)>,
    mirror: Mirror,
    closed: bool,
    /// How much of the surface a texture covers along its coordinates.
    metres_per_texture: Vec2,
    /// The faces as a mirrored camera sees them.
    turned_faces: Vec<[u32; 3]>,
}

impl Actor {
    /// The model of a configuration.
    ///
    /// # Errors
    /// If its file or its texture coordinates cannot be read.
    pub fn load(config: &BodyConfig, camera: &CameraConfig) -> Result<Self, SimError> {
        let (mut body, own) = match &config.source {
            BodySource::Procedural => (BodyModel::procedural_arm(), HandSide::Right),
            BodySource::File(path) => {
                let file = ModelFile::read(path)?;
                (file.model, file.kind.side())
            }
        };
        if let Some(path) = &config.uvs {
            body.uvs = texture_coordinates(path, body.template_m.len())?;
        }
        // After the coordinates, which are of the whole body.
        if matches!(config.source, BodySource::File(_)) && body.parents.len() == JOINTS {
            body = body.right_arm();
        }
        Ok(Self::new(body, own, &camera.placement()))
    }

    /// A model whose hand is the `own` one, before a camera at `placement`.
    pub fn new(body: BodyModel, own: HandSide, placement: &LookAt) -> Self {
        let carrier = (body.parents.len() != JOINTS).then(|| {
            let arm = BodyModel::procedural_arm();
            let neutral = arm.shaped(&[]);
            (arm, neutral)
        });
        let right = placement.camera_from_world().transpose().x_axis.truncate();
        Self {
            own,
            carrier,
            mirror: Mirror::new(placement.eye_m, right),
            closed: is_closed(&body.faces),
            metres_per_texture: metres_per_texture(&body.template_m, &body.uvs, &body.faces),
            turned_faces: body.faces.iter().map(|&[a, b, c]| [a, c, b]).collect(),
            body,
        }
    }

    /// The model.
    pub fn body(&self) -> &BodyModel {
        &self.body
    }

    /// Whether its faces bound a solid.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }

    /// Metres of the surface that a texture covers along its coordinates, on average.
    pub(crate) fn metres_per_texture(&self) -> Vec2 {
        self.metres_per_texture
    }

    /// Whether a hand of `side` is this model's mirror image.
    pub fn is_mirrored(&self, side: HandSide) -> bool {
        side != self.own
    }

    /// The faces of the model as they are seen on `side`, counter-clockwise from outside.
    pub fn faces(&self, side: HandSide) -> &[[u32; 3]] {
        if self.is_mirrored(side) { &self.turned_faces } else { &self.body.faces }
    }

    /// The numbers of a hand in the mirror.
    pub fn mirrored(&self, hand: &HandParams) -> HandParams {
        self.mirror.hand(hand)
    }

    /// The body that the generator's numbers move.
    pub(crate) fn moved<'a>(&'a self, shaped: &'a ShapedBody) -> (&'a BodyModel, &'a ShapedBody) {
        match &self.carrier {
            Some((arm, neutral)) => (arm, neutral),
            None => (&self.body, shaped),
        }
    }

    /// Moves the model by the generator's pose; `out` is as the model is, not mirrored. The numbers
    /// are those of the right hand.
    pub(crate) fn perform(
        &self,
        shaped: &ShapedBody,
        pose: &BodyPose,
        articulation: [f32; 6],
        out: &mut PosedBody,
    ) -> HandParams {
        let Some((arm, neutral)) = &self.carrier else {
            self.body.pose(shaped, pose, out);
            return out.hand_params(&self.body, articulation);
        };
        arm.pose_joints(neutral, pose, out);
        let right = out.hand_params(arm, articulation);
        let own = if self.own.is_right() { right } else { self.mirrored(&right) };
        self.body.pose_hand(shaped, &own, out);
        right
    }

    /// The evaluated points of the posed model, seen as a hand of `side`, in metres.
    pub(crate) fn points(&self, posed: &PosedBody, side: HandSide) -> HandPoints3 {
        let points_m = posed.evaluation_points(&self.body);
        if self.is_mirrored(side) { points_m.map(|p| self.mirror.point(p)) } else { points_m }
    }

    /// The evaluated points of a hand of `side` with the numbers `hand`, in metres.
    pub fn points_of(
        &self,
        side: HandSide,
        hand: &HandParams,
        shaped: &ShapedBody,
        posed: &mut PosedBody,
    ) -> HandPoints3 {
        let own = if self.is_mirrored(side) { self.mirrored(hand) } else { *hand };
        self.body.pose_hand(shaped, &own, posed);
        self.points(posed, side)
    }

    /// The vertices of a hand of `side` with the numbers `hand`, in metres.
    pub fn vertices_of<'a>(
        &'a self,
        side: HandSide,
        hand: &HandParams,
        shaped: &ShapedBody,
        posed: &'a mut PosedBody,
    ) -> impl Iterator<Item = Vec3> + 'a {
        let is_mirrored = self.is_mirrored(side);
        let own = if is_mirrored { self.mirrored(hand) } else { *hand };
        self.body.pose_hand(shaped, &own, posed);
        let place = move |m: &Vec3| if is_mirrored { self.mirror.point(*m) } else { *m };
        posed.vertices_m.iter().map(place)
    }
}

/// One `u v` a line; v goes upwards in the file and downwards in textures here.
fn texture_coordinates(path: &Path, vertices: usize) -> Result<Vec<Vec2>, SimError> {
    let fault = |reason: String| SimError::TextureCoordinates { path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(|error| fault(error.to_string()))?;
    let mut uvs = Vec::with_capacity(vertices);
    for (line, row) in text.lines().enumerate().filter(|(_, row)| !row.trim().is_empty()) {
        let mut numbers = row.split_whitespace().map(str::parse::<f32>);
        match (numbers.next(), numbers.next(), numbers.next()) {
            (Some(Ok(u)), Some(Ok(v)), None) if u.is_finite() && v.is_finite() => {
                uvs.push(Vec2::new(u, 1.0 - v));
            }
            _ => return Err(fault(format!("line {}: `u v` expected, not `{row}`", line + 1))),
        }
    }
    if uvs.len() != vertices {
        return Err(fault(format!("{} lines for a model of {vertices} vertices", uvs.len())));
    }
    Ok(uvs)
}
