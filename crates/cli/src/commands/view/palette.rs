//! Colour maps of representation planes.

use evpose_core::{Plane, SensorSize};
use image::{Rgb, RgbImage, imageops};

use evpose_report::canvas::Canvas;

/// Wide enough to be seen; smaller sensors are enlarged.
const MIN_WIDTH_PX: u32 = 320;
/// Share of values that are shown as they are; few large ones do not make the rest faint.
const SHOWN: f32 = 0.995;

const PAPER: [f32; 3] = [252.0, 252.0, 253.0];
const POSITIVE: [f32; 3] = [30.0, 100.0, 200.0];
const NEGATIVE: [f32; 3] = [200.0, 50.0, 60.0];
const INK: [f32; 3] = [20.0, 24.0, 32.0];

/// How planes are drawn.
#[derive(Clone, Copy)]
pub(in crate::commands) struct Palette {
    sensor: SensorSize,
    /// Whether values are between 0 and 1 already.
    is_events: bool,
    /// Sides of a pixel of the sensor, in pixels of the frame.
    scale: u32,
}

impl Palette {
    pub(in crate::commands) fn new(sensor: SensorSize, is_events: bool) -> Self {
        let scale = MIN_WIDTH_PX.div_ceil(u32::from(sensor.width));
        Self { sensor, is_events, scale }
    }

    /// Sides of a pixel of the sensor, in pixels of the frame.
    pub(super) fn scale(&self) -> u32 {
        self.scale
    }

    /// At least this wide, in pixels of the frame.
    pub(super) fn at_least(self, width_px: u32) -> Self {
        let scale = width_px.div_ceil(u32::from(self.sensor.width));
        Self { scale: self.scale.max(scale), ..self }
    }

    /// As large as the sensor, for programs that enlarge by themselves.
    #[cfg(feature = "rerun")]
    pub(super) fn unscaled(self) -> Self {
        Self { scale: 1, ..self }
    }

    /// `planes`, `[channels][height][width]`: two as OFF and ON over each other, others beside each
    /// other.
    pub(in crate::commands) fn draw(&self, planes: &[f32]) -> RgbImage {
        // Event images range to 1; other planes have units of their own.
        let most = if self.is_events { 1.0 } else { largest(planes) };
        let scaled = |plane: &[f32]| {
            let mut scaled = Plane::for_sensor(self.sensor, 0.0);
            for (to, from) in scaled.data_mut().iter_mut().zip(plane) {
                *to = (from / most).clamp(-1.0, 1.0);
            }
            scaled
        };
        let planes: Vec<Plane<f32>> =
            planes.chunks_exact(self.sensor.pixels()).map(scaled).collect();
        match planes.as_slice() {
            [off, on] => Canvas::events(on, off, self.scale).into_image(),
            planes => beside(planes, self.scale),
        }
    }
}

fn beside(planes: &[Plane<f32>], scale: u32) -> RgbImage {
    const GAP: u32 = 4;
    let (width, height) = planes.first().map_or((1, 1), |p| (p.width() as u32, p.height() as u32));
    // Asked of all planes, so that a colour means the same in each.
    let is_signed = planes.iter().any(|plane| plane.data().iter().any(|&value| value < 0.0));
    let all = (width * scale + GAP) * planes.len() as u32 - GAP;
    let mut image = RgbImage::from_pixel(all, height * scale, Rgb([228, 230, 235]));
    for (i, plane) in planes.iter().enumerate() {
        let one = RgbImage::from_fn(width * scale, height * scale, |x, y| {
            let value = *plane.at((x / scale) as usize, (y / scale) as usize);
            let ink = match (is_signed, value < 0.0) {
                (false, _) => INK,
                (true, true) => NEGATIVE,
                (true, false) => POSITIVE,
            };
            let of = |c: usize| (PAPER[c] + (ink[c] - PAPER[c]) * value.abs()) as u8;
            Rgb([of(0), of(1), of(2)])
        });
        imageops::replace(&mut image, &one, i64::from(i as u32 * (width * scale + GAP)), 0);
    }
    image
}

/// The value that all but few stay below, of those that are not 0.
fn largest(planes: &[f32]) -> f32 {
    let mut values: Vec<f32> = planes.iter().map(|v| v.abs()).filter(|v| *v > 0.0).collect();
    if values.is_empty() {
        return 1.0;
    }
    let at = ((values.len() - 1) as f32 * SHOWN) as usize;
    let (_, value, _) = values.select_nth_unstable_by(at, f32::total_cmp);
    *value
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 160, height: 1 };

    #[test]
    fn one_plane_is_ink_two_are_polarities_and_five_stand_beside_each_other() {
        let palette = Palette::new(SENSOR, false);
        let draw = |channels: usize, value: f32| {
            let mut planes = vec![0.0; channels * SENSOR.pixels()];
            planes[0] = value;
            palette.draw(&planes)
        };
        assert_eq!(draw(1, 3.0).dimensions(), (320, 2));
        assert_eq!(draw(1, 3.0).get_pixel(0, 0).0, [20, 24, 32]);
        assert_eq!(draw(1, -3.0).get_pixel(0, 0).0, [200, 50, 60]);
        assert_eq!(draw(2, 3.0).get_pixel(0, 0).0, [200, 50, 60], "OFF is first");
        assert_eq!(draw(5, 3.0).dimensions(), (5 * 320 + 4 * 4, 2));
        assert_eq!(draw(1, 0.0).get_pixel(0, 0).0, [252, 252, 253]);
    }
}
