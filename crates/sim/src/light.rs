//! Luminance frames of a sequence, for other sensors than its own.
//!
//! * [`Simulation::light`]: the frames that the sensor of a sequence is exposed to, bit for bit.
//! * [`Simulation::light_of`]: frames of a hand with given poses. Skin, lights and background are
//!   drawn, and so is the angle of the arm, which the poses do not determine.

use evpose_body::PosedBody;
use evpose_core::{CounterRng, Plane, seed_for};
use evpose_pose::{HandParams, HandSide};
use glam::Vec3;

use crate::config::CameraPoseConfig;
use crate::simulator::{Surroundings, mesh};
use crate::{SimError, Simulation, SimulationConfig};

/// Largest angle of the forearm against the hand, about each axis, in radians.
///
/// # Source
/// The wrist of the published distribution of poses.
const WRIST_RANGE: f32 = 0.8;

impl Simulation {
    /// Renders the first `frames` frames of sequence `index`: linear luminance relative to white,
    /// the first at time zero.
    ///
    /// # Errors
    /// As [`Simulation::sequence`].
    pub fn light(&self, index: u64, frames: u64) -> Result<Vec<Plane<f32>>, SimError> {
        let mut simulator = self.sequence(index)?;
        (0..frames).map(|_| Ok(simulator.advance()?.luminance.clone())).collect()
    }

    /// Renders one frame per pose of a hand of `side`. `appearance` is the index of the draw of
    /// skin, lights and background; `betas` is the shape of the body, drawn as well where it is
    /// empty.
    ///
    /// # Errors
    /// If a file of skins can no longer be read.
    pub fn light_of(
        &self,
        side: HandSide,
        hands: &[HandParams],
        betas: &[f32],
        appearance: u64,
    ) -> Result<Vec<Plane<f32>>, SimError> {
        let shared = &self.shared;
        let seed = seed_for(shared.seed, "look", appearance);
        // Poses are those before the configured camera, wherever that of a sequence stands.
        let camera_pose = CameraPoseConfig::default();
        let config = SimulationConfig { camera_pose, ..shared.config.clone() };
        let mut around = Surroundings::new(shared, &config, side, seed, 0)?;
        let (actor, body) = (&shared.actor, shared.actor.body());
        // A shape has all coefficients; with others the drawn one stays.
        if betas.len() == body.shape_coefficients() {
            around.shaped = body.shaped(betas);
        }
        // One angle of the wrist for all poses: the forearm does not move against the hand.
        let mut arm = CounterRng::new(seed, "arm", 0);
        let mut angle = || arm.uniform(-WRIST_RANGE, WRIST_RANGE);
        let wrist = Vec3::new(angle(), angle(), angle());
        let mut posed = PosedBody::default();
        let render = |hand: &HandParams| {
            // The model is of one side: a hand of the other is posed as its mirror image.
            let own = if actor.is_mirrored(side) { actor.mirrored(hand) } else { *hand };
            body.pose_hand_at(&around.shaped, &own, wrist, &mut posed);
            around.renderer.render(&mesh(actor, &posed, side)).clone()
        };
        Ok(hands.iter().map(render).collect())
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream, Micros};
    use evpose_pose::HandSide;
    use evpose_sensor::{EffectConfig, SensorConfig, SensorModel};

    use crate::config::SensorChoice;
    use crate::{Simulation, SimulationConfig, record};

    fn simulation() -> Simulation {
        let config = SimulationConfig { image_scale: 0.2, ..SimulationConfig::default() };
        Simulation::new(&config, 3).unwrap()
    }

    #[test]
    fn light_equals_the_frames_of_the_simulator() {
        let simulation = simulation();
        let mut simulator = simulation.sequence(2).unwrap();
        for plane in simulation.light(2, 40).unwrap() {
            assert_eq!(plane.data(), simulator.advance().unwrap().luminance.data());
        }
    }

    /// Frame k of a recording has the events since step k - 1: their times rounded up.
    #[test]
    fn a_sensor_that_is_shown_the_light_has_the_events_of_the_recording() {
        let levels = EffectConfig::new("level_crossing");
        let levels = levels.with("threshold_on", 0.2).with("threshold_off", 0.2);
        let sensor = SensorConfig { effects: vec![levels] };
        let config = SimulationConfig {
            image_scale: 0.2,
            threshold_sd: 0.0,
            sensor: SensorChoice::Chain(sensor.clone()),
            ..SimulationConfig::default()
        };
        let simulation = Simulation::new(&config, 3).unwrap();
        let dir = tempfile::tempdir().unwrap();
        let mut simulator = simulation.sequence(1).unwrap();
        let recorded = record(&mut simulator, 200, dir.path().join("0001"), &|_| {}).unwrap();
        let size = config.image_size();
        let stream = evpose_io::open_with(&recorded.events_path, Some(size)).unwrap().stream;
        let mut run = SensorModel::from_config(&sensor).unwrap().start(size, 0);
        let mut shown: Vec<Event> = Vec::new();
        for (k, plane) in simulation.light(1, 200).unwrap().iter().enumerate() {
            let events = run.expose(plane, Micros(1_000 * k as i64)).unwrap();
            let frame =
                |event: Event| Event { t: Micros((event.t.0 + 999) / 1_000 * 1_000), ..event };
            shown.extend(events.iter().map(frame));
        }
        // Inside a frame there is no order.
        let by_pixel = |events: &mut Vec<Event>| events.sort_by_key(|e| (e.t, e.y, e.x));
        let mut read: Vec<Event> = EventStream::iter(&stream).collect();
        by_pixel(&mut read);
        by_pixel(&mut shown);
        assert!(read.len() > 500, "{}", read.len());
        assert!(read == shown, "{} and {} events", read.len(), shown.len());
    }

    /// The hand covers the same pixels; its appearance and the rest are another draw.
    #[test]
    fn a_known_pose_covers_the_same_pixels_with_any_appearance() {
        let simulation = simulation();
        let mut simulator = simulation.sequence(0).unwrap();
        let hand = simulator.advance().unwrap().label;
        let [a, again, b] =
            [0, 0, 1].map(|draw| simulation.light_of(HandSide::Right, &[hand], &[], draw).unwrap());
        assert_eq!(a[0].data(), again[0].data());
        assert_ne!(a[0].data(), b[0].data());
        // Moved by a centimetre it is elsewhere, with the appearance unchanged.
        let mut moved = hand;
        moved.translation_m.x += 0.01;
        let moved = simulation.light_of(HandSide::Right, &[moved], &[], 0).unwrap();
        let changed = a[0].data().iter().zip(moved[0].data()).filter(|(p, q)| p != q).count();
        assert!((1..a[0].data().len() / 2).contains(&changed), "{changed}");
    }
}
