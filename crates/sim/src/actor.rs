//! The simulated hand: a body model and the side that is rendered and labelled.
//!
//! # Model
//! The published motion moves a body with an arm. A model that is only a hand hangs on the wrist of
//! the procedural arm, whose other parts are not rendered.
//!
//! The other hand of a model is its mirror image in the camera's upright plane of symmetry: the
//! model is rendered by a camera whose image is mirrored, and its pose parameters are those of the
//! left hand in the same mirror ([`Mirror`]). So a run of left hands moves as one of right hands
//! does.

use std::path::Path;

use evpose_body::files::ModelFile;
use evpose_body::fingers::{FingerAxes, HandAngles, HandRotations};
use evpose_body::skeleton::JOINTS;
use evpose_body::texture_layout::coordinates;
use evpose_body::{BodyModel, BodyPose, MakeHuman, PosedBody, ShapedBody};
use evpose_core::LookAt;
use evpose_pose::{EVALUATION_JOINTS, HandParams, HandSide, Mirror};
use glam::{Vec2, Vec3};

use crate::SimError;
use crate::config::{BodySource, CameraConfig, HandModelConfig};
use crate::raster::is_closed;
use crate::texture::metres_per_texture;

/// Evaluated points of a hand in the world, in metres, in the order of [`EVALUATION_JOINTS`].
pub type HandPoints3 = [Vec3; EVALUATION_JOINTS.len()];

/// Rotations of a hand's joints, and the articulation closest to them.
pub(crate) type GesturedHand = (HandRotations, [f32; 6]);

/// A hand model in front of a camera.
#[derive(Debug, Clone)]
pub struct Actor {
    body: BodyModel,
    native_side: HandSide,
    /// Arm that moves a model without one, and its neutral shape.
    carrier: Option<(BodyModel, ShapedBody)>,
    /// Mirror before the configured camera; poses are in the camera's coordinates.
    mirror: Mirror,
    closed: bool,
    /// Extent of the texture on the surface along u and v.
    metres_per_texture: Vec2,
    /// Faces with reversed winding, as a mirrored camera needs them.
    mirrored_faces: Vec<[u32; 3]>,
}

impl Actor {
    /// Loads the model of a configuration.
    ///
    /// # Errors
    /// If its file or its texture coordinates cannot be read.
    pub fn load(config: &HandModelConfig, camera: &CameraConfig) -> Result<Self, SimError> {
        let (mut body, native_side) = match &config.source {
            BodySource::Procedural => (BodyModel::procedural_arm(), HandSide::Right),
            BodySource::File(path) => {
                let file = ModelFile::read(path)?;
                (file.model, file.kind.side())
            }
            BodySource::MakeHuman(folder) => {
                let MakeHuman { model, outfits: [faces, ..] } = MakeHuman::read(folder)?;
                let mut body = BodyModel { faces, ..model };
                // The texture is skin here, not clothes.
                body.uvs = coordinates(&body, &body.shaped(&[]));
                (body, HandSide::Right)
            }
        };
        if let Some(path) = &config.uvs {
            body.uvs = texture_coordinates(path, body.template_m.len())?;
        }
        // The texture coordinates are those of the whole body, so they come first.
        if config.source != BodySource::Procedural && body.parents.len() == JOINTS {
            body = body.right_arm();
        }
        Ok(Self::new(body, native_side, &camera.placement()))
    }

    /// Wraps a model whose hand is a `native_side` one, in front of a camera at `placement`.
    pub fn new(body: BodyModel, native_side: HandSide, placement: &LookAt) -> Self {
        // Motion is generated for a whole arm; a model of a hand alone is carried by a procedural
        // one.
        let carrier = (body.parents.len() != JOINTS).then(|| {
            let arm = BodyModel::procedural_arm();
            let neutral = arm.shaped(&[]);
            (arm, neutral)
        });
        Self {
            native_side,
            carrier,
            mirror: mirror_before(placement),
            closed: is_closed(&body.faces),
            metres_per_texture: metres_per_texture(&body.template_m, &body.uvs, &body.faces),
            // A mirror turns the winding around; without this, faces would look away.
            mirrored_faces: body.faces.iter().map(|&[a, b, c]| [a, c, b]).collect(),
            body,
        }
    }

    /// The body model.
    pub fn body(&self) -> &BodyModel {
        &self.body
    }

    /// Whether the faces bound a solid.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }

    /// Mean extent of the texture on the surface along u and v, in metres.
    pub(crate) fn metres_per_texture(&self) -> Vec2 {
        self.metres_per_texture
    }

    /// Whether a hand of `side` is this model's mirror image.
    pub fn is_mirrored(&self, side: HandSide) -> bool {
        side != self.native_side
    }

    /// Faces of the model rendered as a hand of `side`, counter-clockwise seen from outside.
    pub fn faces(&self, side: HandSide) -> &[[u32; 3]] {
        if self.is_mirrored(side) { &self.mirrored_faces } else { &self.body.faces }
    }

    /// Pose parameters of the mirrored hand.
    pub fn mirrored(&self, hand: &HandParams) -> HandParams {
        self.mirror.hand(hand)
    }

    /// The body that the motion generator drives: the carrier arm, or the model itself.
    pub(crate) fn driven_body<'a>(
        &'a self,
        shaped: &'a ShapedBody,
    ) -> (&'a BodyModel, &'a ShapedBody) {
        match &self.carrier {
            Some((arm, neutral)) => (arm, neutral),
            None => (&self.body, shaped),
        }
    }

    /// Rotations of the joints of the model's own hand for angles of its fingers, and the articulation
    /// that comes closest to them.
    pub(crate) fn gesture(&self, shaped: &ShapedBody, angles: &HandAngles) -> GesturedHand {
        let axes = FingerAxes::new(&self.body, shaped, self.native_side);
        let rotations = axes.rotations(angles);
        (rotations, self.body.right_hand.coefficients(&rotations))
    }

    /// Poses the model as the motion generator says, with `fingers` in place of its articulation
    /// where they move by themselves, and returns the pose parameters of the right hand; `mirror` is
    /// the one before the camera that sees it. `out` is not mirrored.
    pub(crate) fn apply_pose(
        &self,
        shaped: &ShapedBody,
        mut pose: BodyPose,
        articulation: [f32; 6],
        fingers: Option<&HandRotations>,
        mirror: &Mirror,
        out: &mut PosedBody,
    ) -> HandParams {
        let Some((arm, neutral)) = &self.carrier else {
            if let Some(fingers) = fingers {
                pose.set_hand_rotations(&self.body.right_hand, fingers);
            }
            self.body.pose(shaped, &pose, out);
            return out.hand_params(&self.body, articulation);
        };
        arm.pose_joints(neutral, &pose, out);
        let right = out.hand_params(arm, articulation);
        // The arm is a right one: a model of a left hand is posed as its mirror image.
        let own = if self.native_side.is_right() { right } else { mirror.hand(&right) };
        match fingers {
            Some(fingers) => self.body.pose_hand_with(shaped, &own, fingers, out),
            None => self.body.pose_hand(shaped, &own, out),
        }
        right
    }

    /// Evaluated points of the posed model as a hand of `side`, in metres: those of its image in
    /// `mirror` if it is one of the other side.
    pub(crate) fn points(&self, posed: &PosedBody, side: HandSide, mirror: &Mirror) -> HandPoints3 {
        let points_m = posed.evaluation_points(&self.body);
        self.placed(points_m, side, mirror)
    }

    /// Points of the model as those of a hand of `side`.
    fn placed(&self, points_m: HandPoints3, side: HandSide, mirror: &Mirror) -> HandPoints3 {
        if self.is_mirrored(side) { points_m.map(|p| mirror.point(p)) } else { points_m }
    }

    /// Evaluated points of a hand of `side` with the pose parameters `hand`, in metres.
    pub fn points_of(&self, side: HandSide, hand: &HandParams, shaped: &ShapedBody) -> HandPoints3 {
        let own = if self.is_mirrored(side) { self.mirrored(hand) } else { *hand };
        self.placed(self.body.hand_points(shaped, &own), side, &self.mirror)
    }

    /// Vertices of a hand of `side` with the pose parameters `hand`, in metres.
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

/// The upright plane of symmetry of a camera at `placement`, in which hands are mirrored.
pub(crate) fn mirror_before(placement: &LookAt) -> Mirror {
    let right = placement.camera_from_world().transpose().x_axis.truncate();
    Mirror::new(placement.eye_m, right)
}

/// Reads texture coordinates: one `u v` per line; v points up in the file and down in a
/// [`Texture`].
///
/// [`Texture`]: crate::texture::Texture
fn texture_coordinates(path: &Path, vertices: usize) -> Result<Vec<Vec2>, SimError> {
    let fault = |reason: String| SimError::TextureCoordinates { path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(|error| fault(error.to_string()))?;
    let mut uvs = Vec::with_capacity(vertices);
    // Lines are counted before empty ones are skipped, as editors count them.
    for (line, row) in text.lines().enumerate().filter(|(_, row)| !row.trim().is_empty()) {
        let mut columns = row.split_whitespace().map(str::parse::<f32>);
        match (columns.next(), columns.next(), columns.next()) {
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
