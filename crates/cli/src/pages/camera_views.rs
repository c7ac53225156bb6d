//! Rendered frames of a simulated camera beside its events: one sheet for a whole run.

use anyhow::{Context, Result};
use evpose_core::{Micros, Plane};
use evpose_sim::Simulation;
use glam::{Vec2, Vec3A};
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use crate::pages::recent_events::RecentEvents;
use evpose_report::canvas::contact_sheet;

/// Moments on the sheet, each a view and its events.
const INSTANTS: u64 = 8;
/// From when on the first and every further instant is looked for, in steps: far enough from the start for
/// its burst to be forgotten, and different in every sequence.
const FIRST_STEP: u64 = 400;
const FURTHER_STEPS: u64 = 170;
/// Times among which the one with most events is shown, and steps between them: hands rest at times.
const CANDIDATES: u64 = 6;
const CANDIDATE_STEPS: u64 = 150;
/// Steps between instants of the same sequence, where there are few.
const ROUND_STEPS: u64 = 1_500;
/// How long events stay in the image.
const WINDOW: Micros = Micros(50_000);
/// Width an image is enlarged to, at least.
const IMAGE_PX: u32 = 240;
/// Linear light to a screen's pixel values, as in the published simulator.
const SCREEN_GAMMA: f32 = 2.2;

/// Views of the sequences of `simulation`, at times at which hands move, simulated up to there once more. The same for any number
/// of threads.
///
/// # Errors
/// If a sequence cannot be simulated.
pub fn sheet(simulation: &Simulation) -> Result<RgbImage> {
    let pairs: Vec<[RgbImage; 2]> =
        (0..INSTANTS).into_par_iter().map(|i| instant(simulation, i)).collect::<Result<_>>()?;
    Ok(contact_sheet(&pairs.concat(), 4))
}

fn instant(simulation: &Simulation, index: u64) -> Result<[RgbImage; 2]> {
    let config = simulation.config();
    let sequences = config.sequences as u64;
    let first = FIRST_STEP + FURTHER_STEPS * index + ROUND_STEPS * (index / sequences);
    let first = first.min(config.frames()).checked_sub(1).context("sequences without steps")?;
    let mut simulator = simulation.sequence(index % sequences)?;
    let sensor = simulator.camera().sensor();
    let scale = IMAGE_PX.div_ceil(u32::from(sensor.width));
    let mut recent = RecentEvents::new(sensor, WINDOW);
    let corners = [Vec2::ZERO, Vec2::new(f32::from(sensor.width), f32::from(sensor.height))];
    let mut busiest: Option<(usize, [RgbImage; 2])> = None;
    let last = (first + (CANDIDATES - 1) * CANDIDATE_STEPS).min(config.frames() - 1);
    for number in 0..=last {
        let step = simulator.advance()?;
        recent.push(step.events);
        let now = step.t;
        // The busiest of a few: at a turning point of the motion there are few events to show.
        let is_candidate = number >= first && (number - first).is_multiple_of(CANDIDATE_STEPS);
        let count = if is_candidate { recent.count(now, corners) } else { 0 };
        if is_candidate && busiest.as_ref().is_none_or(|(most, _)| count > *most) {
            let images = [screen(&simulator.frame_rgb(), scale), recent.image(now, scale)];
            busiest = Some((count, images));
        }
    }
    busiest.map(|(_, images)| images).context("sequences without steps")
}

/// Linear colours as a screen shows them.
fn screen(linear: &Plane<Vec3A>, scale: u32) -> RgbImage {
    RgbImage::from_fn(linear.width() as u32 * scale, linear.height() as u32 * scale, |x, y| {
        let rgb = *linear.at((x / scale) as usize, (y / scale) as usize);
        let shown = rgb.clamp(Vec3A::ZERO, Vec3A::ONE).powf(1.0 / SCREEN_GAMMA) * 255.0;
        Rgb(shown.to_array().map(|value| value.round() as u8))
    })
}

#[cfg(test)]
mod tests {
    use evpose_sim::SimulationConfig;

    use super::*;

    #[test]
    fn the_sheet_shows_a_hand_and_its_events() -> Result<()> {
        let mut config = SimulationConfig {
            image_scale: 0.2,
            sequences: 2,
            seconds: 0.5,
            ..SimulationConfig::default()
        };
        config.skin.texels = 32;
        let simulation = Simulation::new(&config, 3)?;
        let sheet = sheet(&simulation)?;
        // 48x36 pixels five times as large, 16 of them with gaps of 6.
        assert_eq!(sheet.dimensions(), (4 * 246 + 6, 4 * 186 + 6));
        let [view, events] = instant(&simulation, 0)?;
        let colours = |image: &RgbImage| {
            image.pixels().map(|pixel| pixel.0).collect::<std::collections::BTreeSet<_>>().len()
        };
        assert!(colours(&view) > 100 && colours(&events) > 10);
        Ok(())
    }
}
