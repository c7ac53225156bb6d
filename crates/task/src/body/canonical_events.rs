//! The events that a representation of bodies is made of, and joints between both images.

use evpose_camera::{Calibration, CanonicalView, ViewAdaptor};
use evpose_clean::DenoiseFilter;
use evpose_core::{EventStream, SensorSize};
use evpose_pose::body::BodyPoints;
use evpose_pose::stream::RemainingEvents;
use glam::Vec2;

use super::config::{BodyImageConfig, BodyViewKind};
use crate::event_steps::{denoised, pooled};

/// Events of the canonical view of bodies, or of the sensor itself.
#[derive(Debug, Clone)]
pub(crate) struct CanonicalEvents {
    sensor: SensorSize,
    /// None if events stay as they are.
    adaptor: Option<ViewAdaptor>,
    /// None if all of them stay.
    denoise: Option<DenoiseFilter>,
    events: EventStream,
    /// Events that are left in the view, and by the filter.
    in_view: u64,
    filtered: u64,
}

impl CanonicalEvents {
    pub(crate) fn new(image: &BodyImageConfig, calibration: &Calibration) -> Self {
        let sensor = calibration.sensor;
        let adaptor = match image.view {
            BodyViewKind::Sensor => None,
            BodyViewKind::Canonical => {
                let view = CanonicalView::for_bodies(calibration);
                Some(ViewAdaptor::new(calibration, &view)).filter(|map| !map.is_identity())
            }
        };
        let size = adaptor.as_ref().map_or(sensor, |map| map.view().sensor);
        let denoise = image.denoise.map(|denoise| denoise.start(size));
        Self { sensor, adaptor, denoise, events: EventStream::empty(size), in_view: 0, filtered: 0 }
    }

    pub(crate) fn size(&self) -> SensorSize {
        self.adaptor.as_ref().map_or(self.sensor, |map| map.view().sensor)
    }

    /// The events of the view.
    pub(crate) fn push<'a>(&'a mut self, events: &'a EventStream) -> &'a EventStream {
        match (&mut self.adaptor, &self.denoise) {
            // Nothing changes these events, so that they need no copy.
            (None, None) => return events,
            (None, Some(_)) => self.events.clone_from(events),
            (Some(map), _) => map.push(events, &mut self.events),
        }
        self.in_view += self.events.len() as u64;
        if let Some(denoise) = &mut self.denoise {
            denoise.apply(&mut self.events);
        }
        self.filtered += self.events.len() as u64;
        &self.events
    }

    /// The events that are left after each step, over all recordings.
    pub(crate) fn remaining(&self) -> Vec<RemainingEvents> {
        let adaptor = self.adaptor.as_ref().filter(|map| !map.is_identity());
        let in_view = adaptor.map(|map| pooled(map, self.in_view));
        let filtered = self.denoise.as_ref().map(|_| denoised(self.filtered));
        in_view.into_iter().chain(filtered).collect()
    }

    /// Joints on the sensor of joints in the view, in pixels; none beyond the sensor.
    pub(crate) fn sensor_points(&self, view_px: &BodyPoints) -> BodyPoints {
        let Some(map) = &self.adaptor else { return *view_px };
        let size = Vec2::new(f32::from(self.sensor.width), f32::from(self.sensor.height));
        view_px.map(|point| {
            let at_px = map.sensor_from_view(point?);
            (at_px.cmpge(Vec2::ZERO).all() && at_px.cmple(size).all()).then_some(at_px)
        })
    }

    /// Joints in the view of joints on the sensor, in pixels.
    pub(crate) fn view_points(&self, sensor_px: &BodyPoints) -> BodyPoints {
        let Some(map) = &self.adaptor else { return *sensor_px };
        sensor_px.map(|point| map.view_from_sensor(point?))
    }

    /// Whether events have shown that polarities say nothing; those that stay as they are do without.
    pub(crate) fn has_lost_polarities(&self) -> bool {
        self.adaptor.as_ref().is_some_and(ViewAdaptor::has_lost_polarities)
    }

    pub(crate) fn reset(&mut self) {
        if let Some(map) = &mut self.adaptor {
            map.reset();
        }
        if let Some(denoise) = &mut self.denoise {
            denoise.reset();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_return_to_the_sensor_and_those_in_the_border_have_no_place_on_it() {
        let calibration = Calibration::guessed(SensorSize { width: 1280, height: 720 });
        let seen = CanonicalEvents::new(&BodyImageConfig::default(), &calibration);
        assert_eq!(seen.size(), SensorSize { width: 320, height: 240 });
        let mut points = BodyPoints::default();
        points[3] = Some(Vec2::new(640.0, 360.0));
        let there = seen.view_points(&points);
        assert!(there[3].is_some_and(|at| at.distance(Vec2::new(160.0, 120.0)) < 1e-3));
        let back = seen.sensor_points(&there);
        assert!(back[3].is_some_and(|at| at.distance(Vec2::new(640.0, 360.0)) < 1e-2));
        points[3] = Some(Vec2::new(160.0, 10.0));
        assert_eq!(seen.sensor_points(&points)[3], None);
    }

    #[test]
    fn the_sensor_itself_is_an_identity_of_any_size() {
        let calibration = Calibration::guessed(SensorSize { width: 640, height: 480 });
        let image = BodyImageConfig { view: BodyViewKind::Sensor, ..BodyImageConfig::default() };
        let seen = CanonicalEvents::new(&image, &calibration);
        assert_eq!(seen.size(), calibration.sensor);
    }
}
