//! Images of a recording of ROS, on the clock of its events.
//!
//! | type | encodings |
//! |---|---|
//! | `sensor_msgs/Image` | `mono8`, `mono16`, `bgr8`, `rgb8` |
//! | `sensor_msgs/CompressedImage` | PNG, JPEG |
//!
//! The header of an image has a time of ROS, as events of lists have. So have events of `libcaer` and
//! `libcaer_cmp`, whose driver stamps the images of the same sensor by the clock of its events; the headers
//! of these packets are of their arrival. For packets of `evt3` and `mono` the header of the first one is
//! taken as the time of its first event: by it, times of ROS become times of the sensor.
//!
//! # Source
//! <https://github.com/ros2/common_interfaces>, `sensor_msgs`

use std::collections::VecDeque;
use std::path::Path;

use evpose_core::Micros;

use super::fields::{Fields, Reason, Serialisation};
use super::file::{NamedFile, Topic};
use super::message::unpacked;
use super::place::Place;
use super::source::{RosSource, listed};
use crate::aedat4::{Depth, Frame, PixelFormat};
use crate::{IoError, OpenOptions};

/// Bytes of pixels that wait, from which on a unit is read in parts.
const WAITING: usize = 1 << 26;

/// Types of messages with images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ImageType {
    Plain,
    Compressed,
}

impl ImageType {
    fn by_name(name: &str) -> Option<Self> {
        match (name.split('/').next()?, name.rsplit('/').next()?) {
            ("sensor_msgs", "Image") => Some(Self::Plain),
            ("sensor_msgs", "CompressedImage") => Some(Self::Compressed),
            _ => None,
        }
    }
}

/// The images of a topic, in the order of the file.
pub struct Images {
    place: Place,
    kind: ImageType,
    serialisation: Serialisation,
    /// Time of ROS at which times of events are 0, microseconds since 1970.
    zero_us: i64,
    waiting: VecDeque<Frame>,
    /// Behind those that wait.
    fault: Option<IoError>,
    is_over: bool,
}

/// Opens the images of a recording: of several topics, those beside the one of the events.
///
/// # Errors
/// If the file cannot be read, or has no topic of events, or none or several of images.
pub fn images(path: &Path, options: &OpenOptions) -> Result<Images, IoError> {
    let events = super::open_source(crate::open::input(path)?, options)?;
    let files = super::open_files(crate::open::input(path)?)?;
    of(files, &events, path)
}

fn of(files: Vec<NamedFile>, events: &RosSource, path: &Path) -> Result<Images, IoError> {
    let (place, topics, fault) = Place::new(files);
    if let Some(fault) = fault {
        return Err(fault);
    }
    let refused = |reason: String| IoError::Stream { path: path.to_owned(), reason };
    let mut candidates: Vec<&Topic> =
        topics.iter().filter(|topic| ImageType::by_name(&topic.kind).is_some()).collect();
    if candidates.is_empty() {
        let reason = format!("no topic of images; there are: {}", listed(&topics));
        return Err(refused(reason));
    }
    // Drivers publish the images of a sensor beside its events.
    if candidates.len() > 1 {
        let folder = |topic: &str| topic.rsplit_once('/').map(|(folder, _)| folder.to_owned());
        candidates.retain(|topic| folder(&topic.name) == folder(&events.topic));
    }
    let [topic] = candidates[..] else {
        let reason =
            format!("not one topic of images beside {}: {}", events.topic, listed(&topics));
        return Err(refused(reason));
    };
    let mut place = place;
    place.choose(topic);
    Ok(Images {
        place,
        kind: ImageType::by_name(&topic.kind).unwrap_or(ImageType::Plain),
        serialisation: topic.serialisation,
        zero_us: events.zero_us,
        waiting: VecDeque::new(),
        fault: None,
        is_over: false,
    })
}

impl Images {
    /// Times of all images, up to a fault; the images are then read from where they were.
    pub(crate) fn times(&mut self) -> (Vec<Micros>, Option<IoError>) {
        let (serialisation, zero_us) = (self.serialisation, self.zero_us);
        // Pixels are not decoded now: the place is set back for the images to come.
        let Place { file, at, taken, .. } = self.place;
        let mut times = Vec::new();
        let fault = loop {
            let read = self.place.unit(&mut |message| {
                let message = unpacked(message)?;
                let header_us = Fields::new(&message, serialisation)?.header_us()?;
                times.push(Micros(header_us - zero_us));
                Ok(false)
            });
            match read {
                Ok(false) => {}
                Ok(true) => break None,
                Err(fault) => break Some(self.place.error(fault, 0)),
            }
        };
        (self.place.file, self.place.at, self.place.taken) = (file, at, taken);
        (times, fault)
    }
}

impl Iterator for Images {
    type Item = Result<Frame, IoError>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.waiting.is_empty() && !self.is_over {
            let (kind, serialisation, zero_us) = (self.kind, self.serialisation, self.zero_us);
            let (waiting, mut bytes) = (&mut self.waiting, 0);
            let read = self.place.unit(&mut |message| {
                let frame = decode(message, kind, serialisation, zero_us)?;
                bytes += frame.pixels.len();
                waiting.push_back(frame);
                Ok(bytes >= WAITING)
            });
            match read {
                Ok(is_over) => self.is_over = is_over,
                Err(fault) => {
                    self.fault = Some(self.place.error(fault, 0));
                    self.is_over = true;
                }
            }
        }
        // Images before a fault come before it.
        self.waiting.pop_front().map(Ok).or_else(|| self.fault.take().map(Err))
    }
}

fn decode(
    message: &[u8],
    kind: ImageType,
    serialisation: Serialisation,
    zero_us: i64,
) -> Result<Frame, Reason> {
    let message = unpacked(message)?;
    let mut fields = Fields::new(&message, serialisation)?;
    let t = Micros(fields.header_us()? - zero_us);
    let (format, (width, height), pixels) = match kind {
        ImageType::Plain => plain(&mut fields)?,
        ImageType::Compressed => compressed(&mut fields)?,
    };
    let pixel = |length: u32| u16::try_from(length).map_err(|_| Reason::from("a huge image"));
    let (width, height) = (pixel(width)?, pixel(height)?);
    let (format, pixels) = without_colour(format, pixels);
    Ok(Frame {
        t,
        readout_start: Micros(0),
        readout_end: Micros(0),
        // Messages do not say how long an exposure was.
        exposure_start: t,
        exposure_end: t,
        format,
        width,
        height,
        position: (0, 0),
        origin: 0,
        pixels,
    })
}

type Pixels = (PixelFormat, (u32, u32), Vec<u8>);

fn plain(fields: &mut Fields<'_>) -> Result<Pixels, Reason> {
    let (height, width) = (fields.u32()?, fields.u32()?);
    let encoding = fields.text()?;
    let (depth, channels, is_reversed) = match encoding {
        "mono8" | "8UC1" => (Depth::U8, 1, false),
        "mono16" | "16UC1" => (Depth::U16, 1, false),
        "bgr8" | "8UC3" => (Depth::U8, 3, false),
        "rgb8" => (Depth::U8, 3, true),
        other => return Err(format!("images in the encoding `{other}` are not read").into()),
    };
    let is_big_endian = fields.u8()? != 0;
    let step = fields.u32()? as usize;
    let bytes = fields.bytes()?;
    let sample = if depth == Depth::U16 { 2 } else { 1 };
    let row = width as usize * channels as usize * sample;
    if step < row || step.checked_mul(height as usize).is_none_or(|all| all > bytes.len()) {
        return Err("an image with fewer bytes than its size says".into());
    }
    // Rows may be padded: `step` is their length in the message.
    let rows = bytes.chunks(step.max(1)).take(height as usize);
    let mut pixels: Vec<u8> = rows.flat_map(|bytes| &bytes[..row]).copied().collect();
    if is_reversed {
        pixels.chunks_exact_mut(3).for_each(<[u8]>::reverse);
    }
    if is_big_endian && sample == 2 {
        pixels.chunks_exact_mut(2).for_each(<[u8]>::reverse);
    }
    Ok((PixelFormat { depth, channels }, (width, height), pixels))
}

fn compressed(fields: &mut Fields<'_>) -> Result<Pixels, Reason> {
    let _format = fields.text()?;
    let image = image::load_from_memory(fields.bytes()?);
    let image = image.map_err(|fault| format!("an image: {fault}"))?;
    let size = (image.width(), image.height());
    Ok(match image {
        image::DynamicImage::ImageLuma8(grey) => (PixelFormat::GREY, size, grey.into_raw()),
        image::DynamicImage::ImageLuma16(grey) => {
            let bytes = grey.into_raw().into_iter().flat_map(u16::to_le_bytes).collect();
            (PixelFormat { depth: Depth::U16, channels: 1 }, size, bytes)
        }
        other => {
            let mut pixels = other.into_rgb8().into_raw();
            // Frames have blue before red, as the encoding `bgr8` does.
            pixels.chunks_exact_mut(3).for_each(<[u8]>::reverse);
            (PixelFormat { depth: Depth::U8, channels: 3 }, size, pixels)
        }
    })
}

/// Grey cameras may publish their images in colour: all channels are one.
fn without_colour(format: PixelFormat, pixels: Vec<u8>) -> (PixelFormat, Vec<u8>) {
    let (colours, _) = pixels.as_chunks::<3>();
    if format.channels == 3 && colours.iter().all(|[b, g, r]| b == g && g == r) {
        return (PixelFormat::GREY, colours.iter().map(|[grey, ..]| *grey).collect());
    }
    (format, pixels)
}
