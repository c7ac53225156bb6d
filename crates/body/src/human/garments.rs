//! Garments that change the outline of a person: hair, hats, skirts, coats, thick clothes, bags, shoes.
//!
//! Each is a distance field around the mean body at rest, united with it before the surface is
//! polygonised, so that one skinned mesh remains. Sizes are those of common clothes, in metres.

use evpose_core::CounterRng;
use glam::Vec3;

use crate::implicit::cone::{Cone, smooth_min, smooth_step};

/// Length over which a garment blends into what is below it.
const BLEND_M: f32 = 0.012;
/// The neck of the body at rest: clothes end here.
const NECK_Y_M: f32 = 0.27;
/// The ankles of the body at rest.
const ANKLE_Y_M: f32 = -1.07;

/// Hair beyond that which lies flat on the head.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hair {
    Flat,
    /// Around the whole head, this much thicker than flat hair.
    Thick(f32),
    /// Down the back to this height.
    Long(f32),
    Bun,
    Tail,
}

/// Head-dress.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hat {
    None,
    /// With a brim of this radius all around.
    Brimmed(f32),
    /// With a peak over the eyes.
    Cap,
    Woollen,
}

/// A cone-shaped garment around waist and legs.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Skirt {
    from_y_m: f32,
    to_y_m: f32,
    radii_m: [f32; 2],
}

/// The outfit of a person, beyond close-fitting clothes.
#[derive(Debug, Clone, PartialEq)]
pub struct Garments {
    hair: Hair,
    hat: Hat,
    skirt: Option<Skirt>,
    /// Thickness of the clothes on trunk and limbs.
    padding_m: f32,
    /// Thickness of shoes beyond the feet.
    shoes_m: f32,
    /// Depth of a backpack.
    backpack_m: Option<f32>,
    /// A bag on the right (-1) or left (1) hip.
    bag_side: Option<f32>,
}

impl Garments {
    /// Draws an outfit.
    pub fn draw(rng: &mut CounterRng) -> Self {
        let hair = match rng.below(6) {
            0 | 1 => Hair::Flat,
            2 => Hair::Thick(rng.uniform(0.015, 0.06)),
            3 => Hair::Long(rng.uniform(0.05, 0.30)),
            4 => Hair::Bun,
            _ => Hair::Tail,
        };
        let hat = match rng.below(8) {
            0 => Hat::Brimmed(rng.uniform(0.14, 0.20)),
            1 => Hat::Cap,
            2 => Hat::Woollen,
            _ => Hat::None,
        };
        let skirt = rng.chance(0.35).then(|| {
            // A skirt begins at the waist, a coat or dress at the chest.
            let from_y_m = if rng.chance(0.5) { -0.06 } else { 0.10 };
            Skirt {
                from_y_m,
                to_y_m: rng.uniform(-0.95, -0.42),
                radii_m: [rng.uniform(0.145, 0.165), rng.uniform(0.18, 0.30)],
            }
        });
        Self {
            hair,
            hat,
            skirt,
            padding_m: if rng.chance(0.6) { rng.uniform(0.0, 0.03) } else { 0.0 },
            shoes_m: rng.uniform(0.0, 0.018),
            backpack_m: rng.chance(0.2).then(|| rng.uniform(0.10, 0.17)),
            bag_side: rng.chance(0.2).then(|| if rng.chance(0.5) { 1.0 } else { -1.0 }),
        }
    }

    /// Signed distance to the dressed body, given that to the bare one at `point_m`.
    pub(super) fn over(&self, bare_m: f32, point_m: Vec3) -> f32 {
        let mut distance_m = bare_m - self.thickness_m(point_m.y);
        for part_m in [
            self.hair_m(point_m),
            self.hat_m(point_m),
            self.skirt_m(point_m),
            self.backpack_m(point_m),
            self.bag_m(point_m),
        ]
        .into_iter()
        .flatten()
        {
            // Smooth unions, since a crease would be an edge for the camera.
            distance_m = smooth_min(distance_m, part_m, BLEND_M);
        }
        distance_m
    }

    /// Thickness of clothes or shoes at a height.
    fn thickness_m(&self, y_m: f32) -> f32 {
        let clothes = 1.0 - smooth_step(NECK_Y_M - 0.04, NECK_Y_M, y_m);
        let shoes = 1.0 - smooth_step(ANKLE_Y_M - 0.04, ANKLE_Y_M, y_m);
        self.padding_m * (clothes - shoes) + self.shoes_m * shoes
    }

    fn hair_m(&self, at_m: Vec3) -> Option<f32> {
        let back = |y: f32, z: f32| Vec3::new(0.0, y, z);
        Some(match self.hair {
            Hair::Flat => return None,
            Hair::Thick(more_m) => Cone::ball(back(0.485, -0.012), 0.098 + more_m).distance(at_m),
            Hair::Long(to_y_m) => Cone::new(back(0.49, -0.02), back(to_y_m, -0.085), [0.115, 0.08])
                .flattened(Vec3::Z, 0.75)
                .distance(at_m),
            Hair::Bun => Cone::ball(back(0.545, -0.085), 0.05).distance(at_m),
            Hair::Tail => {
                Cone::new(back(0.51, -0.11), back(0.27, -0.125), [0.036, 0.018]).distance(at_m)
            }
        })
    }

    fn hat_m(&self, at_m: Vec3) -> Option<f32> {
        let up = |y: f32, z: f32| Vec3::new(0.0, y, z);
        let crown = |top: f32, radii_m| Cone::new(up(0.505, 0.01), up(top, 0.01), radii_m);
        Some(match self.hat {
            Hat::None => return None,
            Hat::Brimmed(radius_m) => {
                let brim = Cone::ball(up(0.515, 0.015), radius_m).flattened(Vec3::Y, 0.09);
                brim.distance(at_m).min(crown(0.56, [0.112, 0.095]).distance(at_m))
            }
            Hat::Cap => {
                let peak = Cone::new(up(0.515, 0.08), up(0.50, 0.165), [0.075, 0.055]);
                let peak = peak.flattened(Vec3::Y, 0.16);
                peak.distance(at_m).min(crown(0.515, [0.108, 0.10]).distance(at_m))
            }
            Hat::Woollen => crown(0.53, [0.115, 0.105]).distance(at_m),
        })
    }

    fn skirt_m(&self, at_m: Vec3) -> Option<f32> {
        let Skirt { from_y_m, to_y_m, radii_m } = self.skirt?;
        let along = |y: f32| Vec3::new(0.0, y, 0.0);
        let cone = Cone::new(along(from_y_m), along(to_y_m), radii_m).flattened(Vec3::Z, 0.72);
        // Level ends instead of the cone's round ones.
        let ends = (to_y_m - at_m.y).max(at_m.y - from_y_m);
        Some(cone.distance(at_m).max(ends))
    }

    fn backpack_m(&self, at_m: Vec3) -> Option<f32> {
        let depth_m = self.backpack_m?;
        let z = -0.10 - 0.5 * depth_m;
        let sack = Cone::new(Vec3::new(0.0, 0.0, z), Vec3::new(0.0, 0.16, z), [0.15, 0.13]);
        Some(sack.flattened(Vec3::Z, 0.5 * depth_m / 0.14).distance(at_m))
    }

    fn bag_m(&self, at_m: Vec3) -> Option<f32> {
        let x = 0.20 * self.bag_side?;
        let bag = Cone::new(Vec3::new(x, -0.34, 0.0), Vec3::new(x, -0.28, 0.0), [0.12, 0.11]);
        Some(bag.flattened(Vec3::X, 0.4).distance(at_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bare() -> Garments {
        Garments {
            hair: Hair::Flat,
            hat: Hat::None,
            skirt: None,
            padding_m: 0.0,
            shoes_m: 0.0,
            backpack_m: None,
            bag_side: None,
        }
    }

    #[test]
    fn without_garments_the_body_is_the_bare_one() {
        for y in [-1.1, -0.5, 0.2, 0.5] {
            assert_eq!(bare().over(0.1, Vec3::new(0.1, y, 0.0)), 0.1);
        }
    }

    #[test]
    fn garments_only_add_to_a_body() {
        for index in 0..64 {
            let worn = Garments::draw(&mut CounterRng::new(3, "garments", index));
            for (x, y, z) in
                [(0.0, 0.5, 0.0), (0.15, -0.2, 0.1), (0.0, 0.1, -0.2), (0.1, -1.1, 0.1)]
            {
                let point_m = Vec3::new(x, y, z);
                assert!(worn.over(0.05, point_m) <= 0.05, "{worn:?} at {point_m}");
            }
        }
    }

    #[test]
    fn a_skirt_ends_level() {
        let skirt = Skirt { from_y_m: -0.06, to_y_m: -0.8, radii_m: [0.15, 0.25] };
        let worn = Garments { skirt: Some(skirt), ..bare() };
        assert!(worn.over(1.0, Vec3::new(0.2, -0.79, 0.0)) < 0.0);
        let below = worn.over(1.0, Vec3::new(0.0, -0.85, 0.0));
        assert!((below - 0.05).abs() < 1e-5, "{below}");
    }
}
