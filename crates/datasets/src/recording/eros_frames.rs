//! EROS images of a recording, one for each instant at which joints are known.

use std::num::NonZeroUsize;
use std::path::Path;

use evpose_core::{Micros, Plane, SensorSize, TimeWindow};
use evpose_repr::{BlurWork, Eros, ErosConfig, ErosFramer, GaussianKernel, Representation};

use super::{LabelledRecording, TorsoRule, body_label};
use crate::stills::{CropFormat, write_image};
use crate::{Annotation, DatasetError};

/// Variant of the EROS, and its blur.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ErosStyle {
    /// The input of networks in operation: a kernel of 7 pixels, a blur of 5, by definition.
    #[default]
    Online,
    /// The training images of the published networks: a kernel of 8 pixels beside its centre,
    /// fractions dropped at each event, a blur of 7.
    Published,
}

/// Selection of instants, and the variant of their images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErosFrameOptions {
    /// Variant of the EROS.
    pub style: ErosStyle,
    /// Count of first instants that are left out: their images are nearly empty.
    pub first: usize,
    /// Of the others, those whose number is a multiple of this are taken.
    pub every: NonZeroUsize,
    /// How the torso is measured.
    pub torso: TorsoRule,
}

impl Default for ErosFrameOptions {
    fn default() -> Self {
        let (style, torso) = (ErosStyle::default(), TorsoRule::default());
        Self { style, first: 2, every: NonZeroUsize::MIN, torso }
    }
}

impl ErosFrameOptions {
    /// As the published exporter makes them.
    pub const PUBLISHED: Self = Self {
        style: ErosStyle::Published,
        first: 2,
        every: NonZeroUsize::MIN,
        torso: TorsoRule::Published,
    };
}

/// Writes `NAME_00002.png`, `NAME_00003.png`, … into `folder` and returns what is on them.
///
/// An image holds all events up to its instant, the instant included. Instants without any known
/// joint are left out.
///
/// # Errors
/// If an image cannot be written.
///
/// # Source
/// hpe-core, `datasets/h36m/export_eros.py`, which writes JPEG files.
pub fn write_eros_frames(
    recording: &LabelledRecording,
    options: &ErosFrameOptions,
    folder: &Path,
) -> Result<Vec<Annotation>, DatasetError> {
    let LabelledRecording { name, events, bodies } = recording;
    let sensor = events.sensor();
    let mut renderer = ErosRenderer::new(sensor, options.style);
    let mut annotations = Vec::new();
    let mut start = Micros(i64::MIN);
    for (index, body) in bodies.iter().enumerate() {
        // The instant is included, and a window excludes its end.
        let window = TimeWindow { start, end: body.t + Micros(1) };
        // Also before instants that are left out: the representation remembers.
        renderer.eros.push(&events.slice(window));
        start = window.end;
        let is_known = body.points_px.iter().any(Option::is_some);
        if index < options.first || index % options.every != 0 || !is_known {
            continue;
        }
        let image = format!("{name}_{index:05}.png");
        write_image(&folder.join(&image), renderer.draw(), CropFormat::Png)?;
        let label = body_label(&body.points_px, sensor, options.torso);
        annotations.push(Annotation { image, t_s: Some(body.t.as_seconds()), label });
    }
    Ok(annotations)
}

/// An EROS, and the buffers of its rendering.
struct ErosRenderer {
    eros: Eros,
    style: Style,
    image: Plane<u8>,
}

enum Style {
    Online(ErosFramer),
    Published { sharp: Plane<u8>, work: BlurWork },
}

impl ErosRenderer {
    fn new(sensor: SensorSize, style: ErosStyle) -> Self {
        let image = Plane::for_sensor(sensor, 0);
        let (eros, style) = match style {
            ErosStyle::Online => {
                let framer = ErosFramer::new(sensor, sensor.width.into(), sensor.height.into());
                (Eros::new(sensor, ErosConfig::ONLINE), Style::Online(framer))
            }
            ErosStyle::Published => {
                let style = Style::Published { sharp: image.clone(), work: BlurWork::default() };
                (Eros::python(sensor, ErosConfig::DATA_SETS), style)
            }
        };
        Self { eros, style, image }
    }

    fn draw(&mut self) -> &Plane<u8> {
        match &mut self.style {
            Style::Online(framer) => framer.blurred(&self.eros, self.image.data_mut()),
            Style::Published { sharp, work } => {
                self.eros.render_u8(sharp.data_mut());
                GaussianKernel::Seven.blur(sharp, work, &mut self.image);
            }
        }
        &self.image
    }
}

#[cfg(test)]
mod tests;
