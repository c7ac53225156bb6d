//! Left and right hands, and the mirror that turns the parameters of one into those of the other.
//!
//! # Model
//! A left hand is a right one in a mirror. With `M` the reflection in the mirror's plane and `S`
//! that of a hand model in its own frame, `x → −x`, which turns the right hand's rest pose into the
//! left one's, a joint of rotation `R` at `t` becomes one of rotation `M·R·S` at `M(t)`. Both are
//! reflections, so `M·R·S` is a rotation again, and mirroring twice changes nothing. Coefficients
//! of the articulation stay as they are: the left hand's basis is the right one's, mirrored.

use glam::{Mat3, Vec3};
use serde::{Deserialize, Serialize};

use crate::HandParams;
use crate::rotation::{axis_angle_from_matrix, matrix_from_axis_angle};

/// Side of a hand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HandSide {
    /// The left one.
    Left,
    /// The right one, as published.
    #[default]
    Right,
}

impl HandSide {
    /// Whether it is the right hand.
    pub fn is_right(&self) -> bool {
        matches!(self, Self::Right)
    }
}

/// A plane in which hands are mirrored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    normal: Vec3,
    /// Distance of the plane from the origin along the normal.
    offset_m: f32,
}

impl Mirror {
    /// The plane through `point_m` with the unit normal `normal`.
    pub fn new(point_m: Vec3, normal: Vec3) -> Self {
        Self { normal, offset_m: normal.dot(point_m) }
    }

    /// The mirror image of a point, in metres.
    pub fn point(&self, point_m: Vec3) -> Vec3 {
        point_m - self.normal * (2.0 * (self.normal.dot(point_m) - self.offset_m))
    }

    /// Parameters of the other hand: the mirror image of a hand's pose.
    pub fn hand(&self, hand: &HandParams) -> HandParams {
        let n = self.normal;
        let across = Mat3::IDENTITY - 2.0 * Mat3::from_cols(n * n.x, n * n.y, n * n.z);
        let own = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
        HandParams {
            articulation: hand.articulation,
            translation_m: self.point(hand.translation_m),
            rotation: axis_angle_from_matrix(across * matrix_from_axis_angle(hand.rotation) * own),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::rotation::geodesic_rad;

    fn vectors(reach: f32) -> impl Strategy<Value = Vec3> {
        let range = -reach..reach;
        (range.clone(), range.clone(), range).prop_map(|(x, y, z)| Vec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn a_mirrored_mirror_image_is_the_hand_itself(
            point in vectors(1.0), normal in vectors(1.0), position in vectors(1.0), rotation in vectors(1.7),
        ) {
            prop_assume!(normal.length() > 0.1);
            let mirror = Mirror::new(point, normal.normalize());
            let hand = HandParams { articulation: [0.5; 6], translation_m: position, rotation };
            let twice = mirror.hand(&mirror.hand(&hand));
            prop_assert!((twice.translation_m - position).length() < 1e-5);
            prop_assert!(geodesic_rad(twice.rotation, rotation) < 1e-3);
            prop_assert_eq!(twice.articulation, hand.articulation);
        }

        #[test]
        fn points_of_the_mirrored_model_lie_where_the_mirror_shows_them(
            rotation in vectors(1.7), position in vectors(1.0), local in vectors(0.2),
        ) {
            // A point that is rigid with the wrist, in its frame, and its twin on the left model.
            let mirror = Mirror::new(Vec3::new(0.3, 0.1, 0.0), Vec3::new(0.6, 0.0, 0.8));
            let hand = HandParams { translation_m: position, rotation, ..HandParams::default() };
            let twin = Vec3::new(-local.x, local.y, local.z);
            let at = |hand: &HandParams, local| {
                hand.translation_m + matrix_from_axis_angle(hand.rotation) * local
            };
            let seen = mirror.point(at(&hand, local));
            prop_assert!((at(&mirror.hand(&hand), twin) - seen).length() < 1e-5);
        }
    }

    #[test]
    fn a_mirror_at_the_side_exchanges_left_and_right() {
        let mirror = Mirror::new(Vec3::new(-0.5, 0.0, 0.0), Vec3::X);
        let seen = mirror.point(Vec3::new(-0.6, 0.2, 0.3));
        assert!((seen - Vec3::new(-0.4, 0.2, 0.3)).length() < 1e-6, "{seen}");
        // A turn about x is the same in such a mirror, one about y the opposite.
        let turned = |axis: Vec3| {
            mirror.hand(&HandParams { rotation: axis * 0.4, ..HandParams::default() }).rotation
        };
        assert!((turned(Vec3::X) - Vec3::X * 0.4).length() < 1e-6);
        assert!((turned(Vec3::Y) + Vec3::Y * 0.4).length() < 1e-6);
    }
}
