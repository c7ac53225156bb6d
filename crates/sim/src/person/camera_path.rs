//! Camera pose over time: on a tripod, or shaking in a hand.

use evpose_core::{CounterRng, LookAt, Pinhole, SensorSize};
use glam::{Quat, Vec3};

use super::config::{Framing, PeopleConfig};

/// Frequencies of the shake of a hand-held camera, in hertz; below the 8 to 12 Hz of tremor.
const SHAKE_HZ: [f32; 3] = [0.31, 0.83, 1.9];
/// Translation per radian of rotation, in metres: the length of an arm.
const ASIDE_M: f32 = 0.6;

#[derive(Debug, Clone)]
pub(super) struct CameraPath {
    at_rest: LookAt,
    /// Amplitudes of tilt, pan and roll in radians.
    amplitudes: [f32; 3],
    phases: [[f32; 3]; 3],
}

impl CameraPath {
    /// Draws a camera for a person of `height_m` who stands at the origin and faces +z, framed as
    /// configured.
    pub(super) fn draw(
        config: &PeopleConfig,
        height_m: f32,
        rng: &mut CounterRng,
    ) -> (Self, Pinhole) {
        let sensor: SensorSize = config.sensor_size;
        let uniform = |rng: &mut CounterRng, [low, high]: [f32; 2]| rng.uniform(low, high);
        let pinhole = Pinhole::from_vertical_fov(sensor, uniform(rng, config.vertical_fov_deg));
        let share = uniform(rng, config.height_share);
        let (width_px, height_px) = (f32::from(sensor.width), f32::from(sensor.height));
        let View { person_px, middle_share, aside_px, freedom } =
            View::draw(config.framing, share, [width_px, height_px], rng);
        // As similar triangles go, at this distance the person is `person_px` tall.
        let distance_m = height_m * pinhole.focal_px / person_px;
        let metres_per_px = distance_m / pinhole.focal_px;
        // No margin where the person is larger than the image.
        let margin = |side_px: f32, person_px: f32| 0.5 * (side_px - person_px).max(0.0);
        let free_m = metres_per_px * margin(width_px, 0.8 * person_px) * rng.uniform(-0.9, 0.9);
        let aside_m = freedom * free_m + metres_per_px * aside_px;
        let above_m = metres_per_px * margin(height_px, person_px) * rng.uniform(-0.9, 0.9);
        let middle_m = middle_share * height_m;
        let eye_height_m = rng.uniform(0.6, 2.0);
        // The drawn offset of the person on the image becomes an offset of the optical axis.
        let centre_m = Vec3::new(aside_m, middle_m + above_m, 0.0);
        // Nobody looks at a face steeply from above or below.
        let eye_height_m = middle_m + (eye_height_m - middle_m).clamp(-distance_m, distance_m);
        let eye_m = Vec3::new(aside_m * rng.uniform(0.2, 1.0), eye_height_m, 0.0);
        // The eye keeps its distance from the person's middle, but at least half a metre ahead.
        let back_m = (distance_m * distance_m - (eye_m.y - middle_m).powi(2)).max(0.3).sqrt();
        let roll = rng.uniform(-0.06, 0.06);
        let at_rest = LookAt {
            eye_m: eye_m.with_z(back_m),
            centre_m,
            up: Vec3::new(roll.sin(), roll.cos(), 0.0),
        };
        let turn = if rng.chance(config.moving_cameras) {
            config.camera_turn_deg.to_radians()
        } else {
            0.0
        };
        // Cameras in hands turn sideways the most, and roll the least.
        let amplitudes =
            [0.8 * turn, turn, 0.5 * turn].map(|amplitude| amplitude * rng.uniform(0.5, 1.5));
        let phases = [(); 3].map(|()| [(); 3].map(|()| rng.uniform(0.0, std::f32::consts::TAU)));
        (Self { at_rest, amplitudes, phases }, pinhole)
    }

    pub(super) fn at_rest(&self) -> &LookAt {
        &self.at_rest
    }

    pub(super) fn is_at_rest(&self) -> bool {
        self.amplitudes == [0.0; 3]
    }

    /// Camera pose at `t_s` seconds.
    pub(super) fn at(&self, t_s: f32) -> LookAt {
        if self.is_at_rest() {
            return self.at_rest;
        }
        let angle = |axis: usize| {
            // Slow waves are the largest, as in hand-held cameras.
            let waves = SHAKE_HZ.iter().zip(self.phases[axis]).zip([1.0, 0.6, 0.15]);
            let sum: f32 = waves
                .map(|((hz, phase), share)| {
                    share * (std::f32::consts::TAU * hz * t_s + phase).sin()
                })
                .sum();
            self.amplitudes[axis] * sum
        };
        let LookAt { eye_m, centre_m, up } = self.at_rest;
        let along = centre_m - eye_m;
        let right = along.cross(up).normalize();
        let above = right.cross(along).normalize();
        let (tilt, pan, roll) = (angle(0), angle(1), angle(2));
        let turned = Quat::from_axis_angle(above, pan) * Quat::from_axis_angle(right, tilt);
        // A hand moves as it turns: rotation alone would show no parallax.
        let eye_m = eye_m + ASIDE_M * (pan * right + tilt * above);
        let up = Quat::from_axis_angle(along.normalize(), roll) * up;
        LookAt { eye_m, centre_m: eye_m + turned * along, up }
    }
}

struct View {
    /// Height of the whole person in pixels.
    person_px: f32,
    /// Height at which the image's middle is, as a share of the person's.
    middle_share: f32,
    /// Offset to the side in pixels, beside that of a person who is wholly visible.
    aside_px: f32,
    /// 1 if the person may be anywhere where nothing is cut off, 0 if not.
    freedom: f32,
}

impl View {
    /// Draws the view of a person who is `share` of the image tall, if all of the person is shown.
    fn draw(framing: Framing, share: f32, side_px: [f32; 2], rng: &mut CounterRng) -> Self {
        let [width_px, height_px] = side_px;
        let whole =
            Self { person_px: share * height_px, middle_share: 0.5, aside_px: 0.0, freedom: 1.0 };
        // The lowest visible height, as a share of the person's: ankles to thighs, hips, chest.
        let lowest = match framing {
            Framing::Whole | Framing::Nobody => return whole,
            Framing::OffEdge => {
                // The person's middle lies about the edge: partly visible, or just not.
                let beyond_px = whole.person_px * rng.uniform(-0.2, 0.1);
                let aside_px = 0.5 * width_px + beyond_px;
                let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
                return Self { aside_px: side * aside_px, freedom: 0.0, ..whole };
            }
            Framing::LegsCut => [0.08, 0.38],
            Framing::UpperBody => [0.40, 0.62],
            Framing::HeadAndShoulders => [0.70, 0.82],
        };
        let lowest = rng.uniform(lowest[0], lowest[1]);
        // Room above the head is a share of what is visible of the person.
        let above = (1.0 - lowest) * rng.uniform(0.02, 0.35);
        let visible = 1.0 + above - lowest;
        Self {
            person_px: height_px / visible,
            middle_share: lowest + 0.5 * visible,
            aside_px: 0.3 * width_px * rng.uniform(-1.0, 1.0),
            freedom: 0.0,
        }
    }
}
