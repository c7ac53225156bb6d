//! Light as it reaches a pixel: the scene through lamp and lens, as a function of time.
//!
//! Distortion moves the point at which the analytic scene is read; blur and scattered light need
//! neighbours and are prepared for a whole recording; the lamp multiplies.

mod frame_sequence;
mod veil;

use crate::circuit::{Lamp, Optics};
use crate::event::{HEIGHT, WIDTH};
use crate::scene::Scene;
use frame_sequence::FrameSequence;
use veil::Veil;

/// The light of one recording.
#[derive(Debug)]
pub struct Light<'a> {
    scene: &'a Scene,
    distortion_k1: f64,
    frames: Option<FrameSequence>,
    veil: Option<Veil>,
    lamp: Option<Lamp>,
}

impl<'a> Light<'a> {
    /// The scene seen through `optics`.
    pub fn new(scene: &'a Scene, optics: &Optics) -> Self {
        let k1 = optics.distortion_k1;
        let frames = (optics.blur_sigma_px > 0.0)
            .then(|| FrameSequence::new(scene, k1, optics.blur_sigma_px));
        let veil = (optics.scattered_share > 0.0).then(|| Veil::new(scene, optics.scattered_share));
        Self { scene, distortion_k1: k1, frames, veil, lamp: optics.lamp }
    }

    /// Natural logarithm of the light on pixel `(x, y)` at `t_s`, 0 at white.
    pub fn log_light(&self, x: usize, y: usize, t_s: f64) -> f64 {
        let mut log = match &self.frames {
            Some(frames) => frames.log_light(x, y, t_s),
            None => log_scene(self.scene, self.distortion_k1, x as f64, y as f64, t_s),
        };
        if let Some(veil) = &self.veil {
            log = veil.over(log, t_s);
        }
        if let Some(lamp) = &self.lamp {
            log += lamp.brightness(t_s).ln();
        }
        log
    }
}

impl Lamp {
    /// Brightness relative to the mean.
    pub fn brightness(&self, t_s: f64) -> f64 {
        let phase = std::f64::consts::TAU * self.ripple_hz * t_s + self.phase_rad;
        // The second harmonic of a rectified mains wave behind a smoothing capacitor.
        1.0 + self.ripple_share * (phase.sin() + 0.1 * (2.0 * phase).sin())
    }
}

/// The scene at the point that the lens images onto `(x, y)`.
fn log_scene(scene: &Scene, k1: f64, x_px: f64, y_px: f64, t_s: f64) -> f64 {
    let (x_px, y_px) = undistort(k1, x_px, y_px);
    scene.log_luminance(x_px, y_px, t_s)
}

/// Undistorted position of pixel position `(x, y)`: solves `r_seen = r (1 + k1 r^2)`.
fn undistort(k1: f64, x_px: f64, y_px: f64) -> (f64, f64) {
    if k1 == 0.0 {
        return (x_px, y_px);
    }
    let (cx, cy) = (0.5 * (WIDTH as f64 - 1.0), 0.5 * (HEIGHT as f64 - 1.0));
    let half_diagonal_px = cx.hypot(cy);
    let (dx, dy) = ((x_px - cx) / half_diagonal_px, (y_px - cy) / half_diagonal_px);
    let seen = dx.hypot(dy);
    // Newton's steps converge at once for the few per cent of a lens.
    let mut radius = seen;
    for _ in 0..6 {
        radius -=
            (radius * (1.0 + k1 * radius * radius) - seen) / (1.0 + 3.0 * k1 * radius * radius);
    }
    let stretch = if seen > 0.0 { radius / seen } else { 1.0 };
    (cx + dx * stretch * half_diagonal_px, cy + dy * stretch * half_diagonal_px)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneKind;

    #[test]
    fn distortion_moves_the_corner_by_k1_half_diagonals() {
        let half_diagonal_px = 47.5_f64.hypot(35.5);
        // The point that is seen at radius 1.1 lies at radius 1 for k1 = .1.
        let reach = 1.1 * half_diagonal_px;
        let (ux, uy) = (47.5 / half_diagonal_px, 35.5 / half_diagonal_px);
        let (x, y) = undistort(0.1, 47.5 + reach * ux, 35.5 + reach * uy);
        assert!((x - 95.0).abs() < 1e-9 && (y - 71.0).abs() < 1e-9);
    }

    #[test]
    fn the_lamp_adds_its_logarithm_to_every_pixel() {
        let scene = Scene::new(SceneKind::Rest, 4);
        let lamp = Lamp { ripple_hz: 100.0, ripple_share: 0.2, phase_rad: 0.4 };
        let still = Light::new(&scene, &Optics::default());
        let lit = Light::new(&scene, &Optics { lamp: Some(lamp), ..Optics::default() });
        let t_s = 0.123;
        let gain = lit.log_light(40, 30, t_s) - still.log_light(40, 30, t_s);
        assert!((gain - lamp.brightness(t_s).ln()).abs() < 1e-12);
    }

    #[test]
    fn scattered_light_is_the_same_everywhere_and_keeps_the_sum() {
        let scene = Scene::new(SceneKind::Bars, 4);
        let share = 0.1;
        let optics = Optics { scattered_share: share, ..Optics::default() };
        let (clear, veiled) = (Light::new(&scene, &Optics::default()), Light::new(&scene, &optics));
        let t_s = 0.5;
        let added = |x, y| {
            veiled.log_light(x, y, t_s).exp() - (1.0 - share) * clear.log_light(x, y, t_s).exp()
        };
        let mean = scene.frame(500, 1000.0).iter().map(|&i| f64::from(i)).sum::<f64>()
            / (WIDTH * HEIGHT) as f64;
        assert!((added(3, 3) - added(80, 60)).abs() < 1e-9);
        assert!((added(3, 3) - share * mean).abs() < 0.02 * share * mean);
    }
}
