//! The images of a recording of ROS, at the times of their headers on the clock of its events.

use std::path::Path;

use evpose_core::SensorSize;

use super::light::Light;
use super::{About, FrameDepth, FrameFault, Frames, Opened};
use crate::aedat4::{Depth, Frame};
use crate::ros::{self, Images};
use crate::{IoError, OpenOptions, detect_format};

/// The images of a bag that are still to come.
struct Bag {
    images: Images,
    /// Read when size and depth were learned from it.
    first: Option<Frame>,
    size: SensorSize,
    depth: FrameDepth,
    /// Count of the images that have a time: those before damage.
    left: usize,
}

/// Whether a file or folder is a recording of ROS.
pub(super) fn is_bag(path: &Path) -> bool {
    detect_format(path).is_ok_and(|format| ros::NAMES.contains(&format.name))
}

pub(super) fn open(path: &Path, options: &OpenOptions) -> Result<Opened, IoError> {
    let mut images = ros::images(path, options)?;
    let (times, fault) = images.times();
    if let Some(fault) = fault.filter(|fault| !(options.salvage && fault.is_damage())) {
        return Err(fault);
    }
    // The first image shows size and depth, which messages state one by one.
    let Some(first) = images.next().transpose()? else {
        let reason = "its topic of images has none".to_owned();
        return Err(IoError::Stream { path: path.to_owned(), reason });
    };
    let start = first.t;
    let (size, depth) = properties(&first);
    let left = times.len();
    let times_s = times.into_iter().map(|t| (t - start).as_seconds()).collect();
    let about = About {
        times_s: Some(times_s),
        start: Some(start),
        ..About::new(size, depth, left as u64)
    };
    Ok((Box::new(Bag { images, first: Some(first), size, depth, left }), about))
}

impl Frames for Bag {
    fn next_into(&mut self, path: &Path, light: &Light, out: &mut [f32]) -> Result<bool, IoError> {
        if self.left == 0 {
            return Ok(false);
        }
        // The first image was read for its size, and it is the first frame as well.
        let first = self.first.take().map(Ok);
        let Some(image) = first.or_else(|| self.images.next()).transpose()? else {
            return Ok(false);
        };
        let fault = match properties(&image) {
            (got, _) if got != self.size => FrameFault::Size { got, first: self.size },
            (_, got) if got != self.depth => FrameFault::Depth { got, first: self.depth },
            _ => {
                convert(&image, light, out);
                self.left -= 1;
                return Ok(true);
            }
        };
        Err(IoError::frames(path, fault))
    }
}

fn properties(image: &Frame) -> (SensorSize, FrameDepth) {
    let depth = match image.format.depth {
        Depth::U16 => FrameDepth::Sixteen,
        _ => FrameDepth::Eight,
    };
    (SensorSize { width: image.width, height: image.height }, depth)
}

/// Light of all pixels; messages have grey of 8 or 16 bits, or blue, green and red of 8.
fn convert(image: &Frame, light: &Light, out: &mut [f32]) {
    let pixels = &image.pixels;
    match (image.format.depth, image.format.channels) {
        (Depth::U16, _) => {
            for (y, bytes) in out.iter_mut().zip(pixels.as_chunks::<2>().0) {
                *y = light.code_to_light(u16::from_le_bytes(*bytes));
            }
        }
        (_, 1) => {
            for (y, code) in out.iter_mut().zip(pixels) {
                *y = light.code_to_light(*code);
            }
        }
        _ => {
            for (y, [blue, green, red]) in out.iter_mut().zip(pixels.as_chunks::<3>().0) {
                *y = light.rgb_to_light([*red, *green, *blue]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Plane;

    use super::super::{Encoding, FrameSource};
    use crate::OpenOptions;
    use crate::open_as;

    #[test]
    fn images_of_a_bag_are_light_at_the_times_of_its_events() {
        let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/ros");
        let bag = format!("{golden}/evt3-sqlite");
        let mut source = FrameSource::open(&bag, Encoding::Linear, None).unwrap();
        assert_eq!((source.frames(), source.size().width, source.white()), (5, 16, 255.0));
        let events = open_as(&bag, &OpenOptions::default()).unwrap().stream;
        // Each was stamped with the first event of its fifth of them.
        let start = source.start().unwrap();
        assert_eq!(start, events.t()[0]);
        for (k, since_s) in source.times_s().unwrap().iter().enumerate() {
            let expected_s = (events.t()[120 * k] - start).as_seconds();
            assert!((since_s - expected_s).abs() < 1e-9, "{k}: {since_s} {expected_s}");
        }
        let mut frame = Plane::for_sensor(source.size(), 0.0);
        for k in 0..5 {
            assert!(source.next_into(&mut frame).unwrap());
            let code = |x: usize, y: usize| ((3 * x + 5 * y + 7 * k) % 256) as f32;
            assert_eq!(frame.data()[5 * 16 + 7], code(7, 5) / 255.0);
        }
        assert!(!source.next_into(&mut frame).unwrap());
        let of_no_images =
            FrameSource::open(format!("{golden}/dvs-plain.bag"), Encoding::Linear, None);
        let error = of_no_images.unwrap_err().to_string();
        assert!(error.contains("no topic of images; there are: /dvs/events"), "{error}");
    }
}
