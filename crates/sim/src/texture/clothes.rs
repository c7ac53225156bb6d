//! Clothes, shoes, face and hair of the procedural human, in the layout of its texture.
//!
//! Values are albedos, taken as linear. Left and right look alike, front and back do not.

use evpose_body::clothes_layout::{
    U_ANKLE, U_CHIN, U_ELBOW, U_EYES, U_KNEE, U_NECK, U_OBJECTS, U_SHOULDER, U_WAIST, U_WRIST,
};
use evpose_core::{CounterRng, Plane};
use glam::{Vec2, Vec3A};

use super::Texture;
use super::canvas::{Canvas, random_colour};
use super::noise::fractal_noise;

/// Texels along the body and around it.
const SIZE: (usize, usize) = (512, 256);

#[derive(Debug, Clone, Copy)]
enum Pattern {
    Plain,
    /// Stripes around the body; their number along it.
    Rings(f32),
    /// Stripes along the body; their number around it.
    Stripes(f32),
    /// Both.
    Checks(f32),
    Dots(f32),
    /// Patches of noise.
    Patches,
}

#[derive(Debug, Clone, Copy)]
struct Fabric {
    pattern: Pattern,
    first: Vec3A,
    second: Vec3A,
}

impl Fabric {
    fn draw(rng: &mut CounterRng, value: (f32, f32)) -> Self {
        let pattern = match rng.below(8) {
            0..3 => Pattern::Plain,
            3 => Pattern::Rings(rng.uniform(14.0, 50.0)),
            4 => Pattern::Stripes(rng.uniform(6.0, 20.0).round()),
            5 => Pattern::Checks(rng.uniform(14.0, 40.0)),
            6 => Pattern::Dots(rng.uniform(20.0, 40.0)),
            _ => Pattern::Patches,
        };
        let first = random_colour(rng, (0.0, 0.7), value);
        let second = random_colour(rng, (0.0, 0.7), (0.03, 0.9));
        Self { pattern, first, second }
    }

    /// Colour at texture coordinates, given the noise there.
    fn at(&self, u: f32, around: f32, noise: f32) -> Vec3A {
        let stripe = |x: f32| x.rem_euclid(1.0) < 0.5;
        let is_second = match self.pattern {
            Pattern::Plain => false,
            Pattern::Rings(count) => stripe(u * count),
            Pattern::Stripes(count) => stripe(around * count),
            Pattern::Checks(count) => stripe(u * count) != stripe(around * count * 0.3),
            Pattern::Dots(count) => {
                let cell = Vec2::new(u * count, around * count * 0.3);
                (cell.fract() - 0.5).length() < 0.28
            }
            Pattern::Patches => noise > 0.12,
        };
        if is_second { self.second } else { self.first }
    }
}

#[derive(Debug, Clone, Copy)]
struct Outfit {
    skin: Vec3A,
    hair: Vec3A,
    /// Hairline over the face, as u.
    hairline: f32,
    shirt: Fabric,
    trousers: Fabric,
    shoes: Vec3A,
    belt: Vec3A,
    sleeves_to: f32,
    trousers_from: f32,
    /// Depth of the neckline, as u.
    neckline: f32,
    print: Option<Vec3A>,
    /// Colour under an open jacket.
    inner: Option<Vec3A>,
    thing: Vec3A,
}

impl Outfit {
    fn draw(rng: &mut CounterRng) -> Self {
        // Squared and cubed draws make light skin and dark hair the more frequent.
        let tan = rng.unit();
        let skin = Vec3A::new(0.70, 0.46, 0.35).lerp(Vec3A::new(0.10, 0.055, 0.035), tan * tan);
        let hair =
            Vec3A::new(0.03, 0.02, 0.015).lerp(Vec3A::new(0.45, 0.32, 0.18), rng.unit().powi(3));
        Self {
            skin,
            hair,
            // A hairline above the top of the head is that of the bald.
            hairline: if rng.chance(0.1) { 1.1 } else { rng.uniform(0.87, 0.93) },
            shirt: Fabric::draw(rng, (0.05, 0.9)),
            // Most trousers are of one colour.
            trousers: if rng.chance(0.75) {
                Fabric { pattern: Pattern::Plain, ..Fabric::draw(rng, (0.03, 0.5)) }
            } else {
                Fabric::draw(rng, (0.03, 0.7))
            },
            shoes: random_colour(rng, (0.0, 0.6), (0.02, 0.8)),
            belt: random_colour(rng, (0.0, 0.4), (0.02, 0.3)),
            // Short sleeves end above the elbow, long ones before the wrist.
            sleeves_to: if rng.chance(0.5) {
                rng.uniform(0.68, U_ELBOW)
            } else {
                rng.uniform(0.86, U_WRIST)
            },
            trousers_from: if rng.chance(0.3) {
                rng.uniform(U_KNEE - 0.02, 0.30)
            } else {
                rng.uniform(0.05, 0.08)
            },
            neckline: rng.uniform(0.0, 0.06),
            print: rng.chance(0.3).then(|| random_colour(rng, (0.0, 0.8), (0.05, 0.95))),
            inner: rng.chance(0.25).then(|| random_colour(rng, (0.0, 0.5), (0.1, 0.95))),
            thing: random_colour(rng, (0.1, 0.6), (0.1, 0.7)),
        }
    }

    /// Colour at texture coordinates, given the noise there.
    fn at(&self, u: f32, v: f32, noise: f32) -> Vec3A {
        // Two strips, of the trunk and of the arms: either runs from the front to the back.
        let around = (v * 2.0).fract();
        // The upper half of v is of objects and arms, the lower one of all from the soles upwards.
        if v >= 0.5 {
            return if u < U_OBJECTS {
                self.thing * (1.0 + 0.3 * noise)
            } else if u < self.sleeves_to {
                self.shirt.at(u, around, noise)
            } else {
                self.skin
            };
        }
        match u {
            // Soles are dark, whatever the shoe.
            _ if u < 0.012 => Vec3A::splat(0.03),
            _ if u < U_ANKLE => self.shoes,
            _ if u < self.trousers_from => self.skin,
            _ if u < U_WAIST => self.trousers.at(u, around, noise),
            _ if u < U_WAIST + 0.012 => self.belt,
            _ if u < U_NECK => self.top(u, around, noise),
            _ => self.head(u, around, noise),
        }
    }

    fn top(&self, u: f32, around: f32, noise: f32) -> Vec3A {
        if around < 0.3 && u > U_SHOULDER - self.neckline * (1.0 - around / 0.3) {
            return self.skin;
        }
        if let Some(inner) = self.inner.filter(|_| around < 0.12) {
            return inner;
        }
        let on_chest = around < 0.3 && (0.51..0.585).contains(&u);
        match self.print.filter(|_| on_chest) {
            Some(print) if noise > -0.1 => print,
            _ => self.shirt.at(u, around, noise),
        }
    }

    fn head(&self, u: f32, around: f32, noise: f32) -> Vec3A {
        let is_hair = u > self.hairline - 0.05 * around || (around > 0.5 && u > U_CHIN + 0.04);
        if self.hairline < 1.0 && is_hair {
            return self.hair * (1.0 + 0.5 * noise);
        }
        let near = |at: f32, half: f32| (u - at).abs() < half;
        let is_eye = near(U_EYES, 0.012) && (0.10..0.24).contains(&around);
        let is_brow = near(U_EYES + 0.03, 0.007) && (0.08..0.27).contains(&around);
        let is_mouth = near(U_CHIN + 0.045, 0.008) && around < 0.14;
        if is_eye || is_brow {
            self.hair * 0.7
        } else if is_mouth {
            self.skin * Vec3A::new(0.7, 0.4, 0.4)
        } else {
            self.skin
        }
    }
}

/// Paints the texture of a drawn person.
pub fn paint_clothes(rng: &mut CounterRng) -> Texture {
    let outfit = Outfit::draw(rng);
    let noise: Plane<f32> = fractal_noise(SIZE, (24, 12), 3, 0.5, rng);
    let mut canvas = Canvas::filled(SIZE.0, SIZE.1, Vec3A::ZERO);
    let whole = canvas.whole();
    canvas.paint(whole, |at, _| {
        let (x, y) = (at.x as usize, at.y as usize);
        outfit.at(at.x / SIZE.0 as f32, at.y / SIZE.1 as f32, *noise.at(x, y))
    });
    // Folds and wear.
    canvas.modulate(&fractal_noise(SIZE, (10, 6), 4, 0.6, rng), 0.35);
    Texture::from_plane(&canvas.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_differ_and_the_same_draw_is_the_same_person() {
        let paint = |index| paint_clothes(&mut CounterRng::new(4, "clothes", index));
        assert_eq!(paint(0), paint(0));
        assert_ne!(paint(0), paint(1));
    }

    #[test]
    fn shirts_go_over_into_sleeves_without_a_border() {
        let outfit = Outfit {
            shirt: Fabric { pattern: Pattern::Plain, first: Vec3A::X, second: Vec3A::Y },
            neckline: 0.0,
            ..Outfit::draw(&mut CounterRng::new(4, "clothes", 0))
        };
        for v in [0.26, 0.4, 0.55, 0.75, 0.95] {
            assert_eq!(outfit.at(U_SHOULDER, v, -0.5), Vec3A::X, "{v}");
        }
    }
}
