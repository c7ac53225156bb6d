//! Recordings as images of a representation.

use std::path::Path;

use evpose_camera::Calibration;
use evpose_core::{
    CounterRng, Event, EventStream, EventStreamBuilder, Micros, Plane, Polarity, SensorSize,
};
use evpose_io::{OpenOptions, Windows};
use evpose_pose::body::BodyPoints;

use super::canonical_events::CanonicalEvents;
use super::config::BodyImageConfig;
use super::frontend::{Blur, start_representation};
use crate::TaskError;
use crate::recording_stream::ForwardEvents;
use evpose_repr::Representation;

/// How long noise has been there when a recording begins.
const HISTORY: Micros = Micros(1_000_000);

/// A recording as images of a representation, forwards in time.
pub struct RepresentationReader {
    events: ForwardEvents,
    canonical: CanonicalEvents,
    representation: Box<dyn Representation>,
    blur: Blur,
}

impl RepresentationReader {
    /// Opens a recording.
    ///
    /// # Errors
    /// If it cannot be read, or the representation not be made.
    pub fn open(path: &Path, image: &BodyImageConfig) -> Result<Self, TaskError> {
        let windows = Windows::open(path, &OpenOptions::default())?;
        let sensor = windows.sensor();
        let canonical = CanonicalEvents::new(image, &Calibration::guessed(sensor));
        let representation = start_representation(image, canonical.size())?;
        let (events, blur) = (ForwardEvents::new(windows), Blur::new(image.blur));
        Ok(Self { events, canonical, representation, blur })
    }

    /// Size of the sensor of the recording.
    pub fn sensor(&self) -> SensorSize {
        self.events.windows.sensor()
    }

    /// Size of the images: that of the canonical view.
    pub fn image_size(&self) -> SensorSize {
        self.canonical.size()
    }

    /// Joints in the images, in pixels, of joints on the sensor.
    pub fn image_points(&self, sensor_px: &BodyPoints) -> BodyPoints {
        self.canonical.view_points(sensor_px)
    }

    /// Joints on the sensor of joints in the images, both in pixels; none beyond the sensor.
    pub fn sensor_points(&self, image_px: &BodyPoints) -> BodyPoints {
        self.canonical.sensor_points(image_px)
    }

    /// Noise in the second before the recording: so many events per pixel of the view, anywhere.
    pub fn add_noise_history(&mut self, events_per_pixel: f32, seed: u64) {
        let size = self.image_size();
        let start = self.events.windows.start().unwrap_or(Micros(0));
        let count = (events_per_pixel * size.pixels() as f32) as usize;
        // Even spacing keeps events in order; only their places need to be random.
        let at = |k: usize| Micros(start.0 - HISTORY.0 + HISTORY.0 * k as i64 / count as i64);
        let mut rng = CounterRng::new(seed, "noise history", 0);
        let mut noise = EventStreamBuilder::new(size);
        for k in 0..count {
            noise.push(Event {
                t: at(k),
                x: rng.below(usize::from(size.width)) as u16,
                y: rng.below(usize::from(size.height)) as u16,
                polarity: if rng.chance(0.5) { Polarity::On } else { Polarity::Off },
            });
        }
        // Its pixels are those of the view already, so that the map of the sensor is passed by.
        self.representation.push(&noise.finish().0);
    }

    /// The image at `t`, which is not before the last one asked for. `observe` receives the events
    /// since then, in pieces.
    ///
    /// # Errors
    /// If the recording cannot be read up to there.
    pub fn at(
        &mut self,
        t: Micros,
        mut observe: impl FnMut(&EventStream),
    ) -> Result<Plane<u8>, TaskError> {
        // A piece ends with the chunk that was read, and may not reach `t` by itself.
        while self.events.peek()?.is_some_and(|next| next <= t) {
            let events = self.events.take_until(t);
            observe(events);
            self.representation.push(self.canonical.push(events));
        }
        self.representation.advance(t);
        let mut image = Plane::for_sensor(self.image_size(), 0);
        self.representation.render_u8(image.data_mut());
        Ok(self.blur.apply(std::slice::from_ref(&image))[0].clone())
    }
}

#[cfg(test)]
mod tests {
    use evpose_clean::Denoise;

    use super::*;

    /// A recording of 64x48 pixels in which one pixel fires every 10 ms.
    fn recording(directory: &Path) -> std::path::PathBuf {
        let mut text = String::from("# 64 48\n");
        for k in 0..20 {
            text += &format!("{:.6} 32 24 1\n", 1.0 + 0.01 * f64::from(k));
        }
        let path = directory.join("rec.txt");
        std::fs::write(&path, text).unwrap();
        path
    }

    fn lit(image: &Plane<u8>) -> usize {
        image.data().iter().filter(|&&grey| grey > 0).count()
    }

    #[test]
    fn noise_of_before_the_recording_stays_in_an_eros_and_follows_from_the_seed() {
        let directory = tempfile::tempdir().unwrap();
        let path = recording(directory.path());
        let config = BodyImageConfig { blur: None, ..BodyImageConfig::default() };
        let image = |history: Option<(f32, u64)>| {
            let mut reader = RepresentationReader::open(&path, &config).unwrap();
            if let Some((events_per_pixel, seed)) = history {
                reader.add_noise_history(events_per_pixel, seed);
            }
            reader.at(Micros(1_150_000), |_| {}).unwrap()
        };
        let (clean, noisy) = (image(None), image(Some((0.2, 7))));
        assert!(lit(&clean) < 20, "{}", lit(&clean));
        // An event of noise darkens what is around it: fewer stay than came.
        assert!(lit(&noisy) > 5 * lit(&clean), "{} and {}", lit(&noisy), lit(&clean));
        assert_eq!(noisy, image(Some((0.2, 7))));
        assert_ne!(noisy, image(Some((0.2, 8))));
    }

    #[test]
    fn a_pixel_that_fires_alone_is_denoised() {
        let directory = tempfile::tempdir().unwrap();
        let path = recording(directory.path());
        let denoise = Some(Denoise { tau_ms: 20.0, neighbours: 1 });
        let config = BodyImageConfig { denoise, ..BodyImageConfig::default() };
        let mut reader = RepresentationReader::open(&path, &config).unwrap();
        assert_eq!(lit(&reader.at(Micros(1_150_000), |_| {}).unwrap()), 0);
    }
}
