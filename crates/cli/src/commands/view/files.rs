//! Frames as one image: beside each other, or one after the other.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use image::codecs::gif::{GifEncoder, Repeat};
use image::{DynamicImage, Frame, RgbImage};

use super::caption::{captioned, with_keys};
use super::frames::{RenderedFrame, RenderedFrames};
use evpose_report::canvas::contact_sheet;
use evpose_report::png::png;

/// Wider sheets are hard to look at: they have fewer columns.
const SHEET_WIDTH_PX: u32 = 2600;
const MAX_COLUMNS: u32 = 4;
/// GIFs count hundredths of a second, and viewers slow down what takes less than two.
const MAX_GIF_FPS: f64 = 50.0;
/// Search for the 256 colours, from 1 (best) to 30 (fastest).
const GIF_SPEED: i32 = 20;

/// All frames beside each other, from left to right and top to bottom.
pub(super) fn sheet(frames: &RenderedFrames) -> Result<Vec<u8>> {
    let images: Vec<RgbImage> = frames.frames.iter().map(captioned).collect();
    let width = images.first().context("no frames")?.width();
    let columns = (SHEET_WIDTH_PX / width).clamp(1, MAX_COLUMNS) as usize;
    let sheet = contact_sheet(&images, columns.min(images.len()));
    Ok(png(&with_keys(sheet, &frames.keys))?)
}

/// All frames one after the other, for ever. A program that knows no animation shows the busiest.
pub(super) fn animation(frames: &RenderedFrames, fps: f64) -> Result<Vec<u8>> {
    let drawn = |frame: &RenderedFrame| with_keys(captioned(frame), &frames.keys);
    let still = drawn(frames.frames.get(frames.busiest()).context("no frames")?);
    let (width, height) = still.dimensions();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // 0 plays stand for an endless loop.
    encoder.set_animated(frames.frames.len() as u32, 0)?;
    // The still comes first in the file and is no frame of the animation.
    encoder.set_sep_def_img(true)?;
    // A fraction of a second, both parts of 16 bits.
    encoder.set_frame_delay((1000.0 / fps).round().max(1.0) as u16, 1000)?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(still.as_raw())?;
    for frame in &frames.frames {
        writer.write_image_data(drawn(frame).as_raw())?;
    }
    writer.finish()?;
    Ok(bytes)
}

/// As [`animation`], in 256 colours a frame, for programs that show GIFs alone.
pub(super) fn gif(frames: &RenderedFrames, fps: f64) -> Result<Vec<u8>> {
    ensure!(fps <= MAX_GIF_FPS, "--fps {fps}: a GIF shows at most {MAX_GIF_FPS} frames a second");
    let delay = image::Delay::from_saturating_duration(Duration::from_secs_f64(1.0 / fps));
    let mut bytes = Vec::new();
    let mut encoder = GifEncoder::new_with_speed(&mut bytes, GIF_SPEED);
    encoder.set_repeat(Repeat::Infinite)?;
    for frame in &frames.frames {
        let image = DynamicImage::ImageRgb8(with_keys(captioned(frame), &frames.keys)).into_rgba8();
        encoder.encode_frame(Frame::from_parts(image, 0, 0, delay))?;
    }
    // The encoder writes the end of the file when it is dropped.
    drop(encoder);
    Ok(bytes)
}
