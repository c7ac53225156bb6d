//! An animated GIF, whose delays are times.
//!
//! It is decoded twice, for the times and for the frames, so that one frame is in memory at a time. Delays below 20 ms
//! are 100 ms, as browsers and `ffmpeg` have it: old programs wrote 0 where they meant nothing.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use evpose_core::SensorSize;
use image::codecs::gif::GifDecoder;
use image::{AnimationDecoder, Frame, Frames, ImageDecoder as _};

use super::{OpenedVideo, VideoDecoder, undecodable};
use crate::frames::fault::sensor_size;
use crate::frames::light::Light;
use crate::frames::{FrameFault, folder};

/// How GIFs of both versions begin.
pub(super) const MAGIC: &[u8] = b"GIF8";
/// Shorter delays stand for [`USUAL_DELAY_S`].
const MIN_DELAY_S: f64 = 0.02;
const USUAL_DELAY_S: f64 = 0.1;

/// The frames of an animation that are still to come.
struct Gif(Frames<'static>);

pub(super) fn open(path: &Path) -> Result<OpenedVideo, FrameFault> {
    let (size, frames) = begin(path)?;
    let (mut times_s, mut time_s) = (Vec::new(), 0.0);
    for frame in frames {
        let frame = frame.map_err(|fault| at_frame(times_s.len(), &fault))?;
        times_s.push(time_s);
        time_s += delay_s(&frame);
    }
    // The file is decoded twice, since all times are known before the first frame is used.
    let (_, frames) = begin(path)?;
    Ok((Box::new(Gif(frames)), size, times_s))
}

impl VideoDecoder for Gif {
    fn decode(&mut self, frame: usize, light: &Light, out: &mut [f32]) -> Result<(), FrameFault> {
        let missing = || undecodable("it became shorter while it was read");
        let image = self.0.next().ok_or_else(missing)?;
        let image = image.map_err(|fault| at_frame(frame, &fault))?;
        folder::colour::<_, 4>(image.buffer(), light, out);
        Ok(())
    }
}

/// Size, and the frames from the first on.
fn begin(path: &Path) -> Result<(SensorSize, Frames<'static>), FrameFault> {
    let file = File::open(path).map_err(undecodable)?;
    let decoder = GifDecoder::new(BufReader::new(file)).map_err(undecodable)?;
    let (width, height) = decoder.dimensions();
    Ok((sensor_size(width.into(), height.into())?, decoder.into_frames()))
}

fn at_frame(number: usize, fault: &image::ImageError) -> FrameFault {
    undecodable(format!("frame {number}: {fault}"))
}

fn delay_s(frame: &Frame) -> f64 {
    let (numerator, denominator) = frame.delay().numer_denom_ms();
    let delay_s = 1e-3 * f64::from(numerator) / f64::from(denominator);
    if delay_s < MIN_DELAY_S { USUAL_DELAY_S } else { delay_s }
}

#[cfg(test)]
mod tests {
    use evpose_core::Plane;
    use image::codecs::gif::GifEncoder;
    use image::{Delay, Rgba, RgbaImage};

    use crate::{Encoding, FrameFault, FrameSource, IoError};

    /// Grey frames of 3 x 2 pixels, with their delays in milliseconds.
    fn animation(frames: &[(u8, u32)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = GifEncoder::new(&mut bytes);
        for (code, delay_ms) in frames {
            let image = RgbaImage::from_pixel(3, 2, Rgba([*code, *code, *code, 255]));
            let delay = Delay::from_numer_denom_ms(*delay_ms, 1);
            encoder.encode_frame(image::Frame::from_parts(image, 0, 0, delay)).unwrap();
        }
        drop(encoder);
        bytes
    }

    #[test]
    fn frames_come_at_the_times_of_their_delays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("moving.gif");
        std::fs::write(&path, animation(&[(0, 40), (51, 0), (255, 250), (51, 10)])).unwrap();
        let mut source = FrameSource::open(&path, Encoding::Linear, None).unwrap();
        let times_s = source.times_s().unwrap();
        let expected = [0.0, 0.04, 0.14, 0.39];
        assert!(
            times_s.iter().zip(expected).all(|(t, wanted)| (t - wanted).abs() < 1e-9),
            "{times_s:?}"
        );
        assert_eq!((source.size().to_string(), source.frames()), ("3x2".to_owned(), 4));
        let mut frame = Plane::for_sensor(source.size(), 0.0);
        let mut light = Vec::new();
        while source.next_into(&mut frame).unwrap() {
            light.push(frame.data()[5]);
        }
        assert!(
            light.iter().zip([0.0, 0.2, 1.0, 0.2]).all(|(y, wanted)| (y - wanted).abs() < 1e-6),
            "{light:?}"
        );
    }

    #[test]
    fn a_cut_animation_is_an_error_that_names_its_frame() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cut.gif");
        let whole = animation(&[(0, 40), (51, 40), (255, 40)]);
        std::fs::write(&path, &whole[..whole.len() - 12]).unwrap();
        let error = FrameSource::open(&path, Encoding::Linear, None).unwrap_err();
        assert!(
            matches!(error, IoError::Frames { fault: FrameFault::Undecodable(_), .. }),
            "{error}"
        );
        assert!(error.to_string().contains("frame 2"), "{error}");
    }
}
