//! Inputs of `evpose sensor tap`: closed-form light, and the simulated hand.

use crate::pages::hand_scene;
use anyhow::Result;
use evpose_core::{Event, Micros, Plane};
use evpose_sensor::{Origin, SensorRun};

use super::args::Input;

/// Uniform light, relative to white, at a time in seconds; none where the light is an image.
pub(super) fn light(input: Input, t_s: f64) -> Option<f64> {
    Some(match input {
        // 1 ns keeps the exposures at the edges of the step on one side of rounding.
        Input::Step => (if (0.05..0.15).contains(&(t_s + 1e-9)) { -0.7_f64 } else { -2.3 }).exp(),
        Input::Ramp => {
            let rise = (t_s / 0.1).clamp(0.0, 1.0) - ((t_s - 0.15) / 0.1).clamp(0.0, 1.0);
            (-2.3 + 2.0 * rise).exp()
        }
        Input::Flicker => 0.2 * (1.0 + 0.5 * (std::f64::consts::TAU * 50.0 * t_s).sin()),
        Input::Hand => return None,
    })
}

/// Length of an input and of its steps.
pub(super) fn clock(input: Input) -> (Micros, Micros) {
    match input {
        Input::Step | Input::Ramp => (Micros(250_000), Micros(100)),
        Input::Flicker => (Micros(100_000), Micros(100)),
        Input::Hand => (Micros(250_000), Micros(1_000)),
    }
}

/// Illuminates a spot around a pixel, or everything at the start. A flash of the whole sensor would
/// saturate the readout and hide the response of the pixel.
fn illuminate(plane: &mut Plane<f32>, (x, y): (u16, u16), is_everywhere: bool, light: f32) {
    const RADIUS: u16 = 7;
    let reach = |centre: u16, side: usize| {
        let radius = if is_everywhere { u16::MAX } else { RADIUS };
        let end = usize::from(centre.saturating_add(radius).saturating_add(1)).min(side);
        usize::from(centre.saturating_sub(radius))..end
    };
    let (columns, rows) = (reach(x, plane.width()), reach(y, plane.height()));
    for row in rows {
        plane.row_mut(row)[columns.clone()].fill(light);
    }
}

/// Exposes a sensor to an input. Calls `observe` after every exposure with the events, their
/// origins if the sensor records them, the light and the time.
pub(super) fn expose(
    run: &mut SensorRun,
    input: Input,
    pixel: (u16, u16),
    seed: u64,
    mut observe: impl FnMut(&[Event], Option<&[Origin]>, &Plane<f32>, Micros),
) -> Result<()> {
    let (length, step) = clock(input);
    let (size, mut events) = (run.size(), Vec::new());
    let mut show = |plane: &Plane<f32>, t: Micros| {
        events.clear();
        events.extend(run.expose(plane, t)?.iter());
        observe(&events, run.origins(), plane, t);
        Ok(())
    };
    let steps = length.0 / step.0;
    // One more than steps: there is light at both ends.
    if input == Input::Hand {
        return hand_scene::for_each_plane(1.0, seed, steps as usize + 1, show);
    }
    let mut plane = Plane::for_sensor(size, 0.0);
    for t in (0..=steps).map(|k| Micros(k * step.0)) {
        if let Some(light) = light(input, t.as_seconds()) {
            illuminate(&mut plane, pixel, t == Micros(0), light as f32);
        }
        show(&plane, t)?;
    }
    Ok(())
}
