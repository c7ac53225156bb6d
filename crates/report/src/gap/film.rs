//! Measured, simulated and corrected events side by side, as one moving picture.
//!
//! All frames are one picture, of which the page shows one part after the other.

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use evpose_gap::report::{Film, ReportData};
use image::{Rgb, RgbImage};

use crate::colour::{OFF, ON};
use crate::html::{Page, escape};
use crate::png::png;

/// Pixels between two streams.
const GAP: usize = 3;
/// Width of one stream on the page, at least, pixels.
const SHOWN: usize = 340;
/// Time for which a frame is shown, seconds.
const FRAME_S: f64 = 0.12;
const PAPER: [f64; 3] = [252.0, 252.0, 253.0];
const BETWEEN: Rgb<u8> = Rgb([226, 228, 234]);

/// The section with the film.
pub(crate) fn section(page: &mut Page, data: &ReportData) -> Result<()> {
    let Some(film) = data.film.as_ref().filter(|film| is_whole(film)) else { return Ok(()) };
    page.section(
        "Side by side",
        &format!(
            "Events of {} ms a frame, {} frames from {:.2} s to {:.2} s: ON blue, OFF red, stronger \
             where a pixel has more. Hold the pointer over it to stop it.",
            film.frame_us as f64 / 1e3,
            film.frames.len(),
            film.frames.first().map_or(0.0, |frame| frame.t_us as f64 * 1e-6),
            film.frames.last().map_or(0.0, |frame| frame.t_us as f64 * 1e-6),
        ),
    );
    let streams = film.names.len();
    let scale = SHOWN.div_ceil(film.width).min((1_130 / (streams * (film.width + GAP))).max(1));
    let (width, height) = (row_px(film) * scale, film.height * scale);
    let count = film.frames.len();
    let names: String =
        film.names.iter().map(|name| format!("<span>{}</span>", escape(name))).collect();
    page.markup(&format!(
        "<style>@keyframes film{{from{{background-position-y:0}}to{{background-position-y:-{}px}}}}\
         </style><div class=\"names\" style=\"width:{width}px;grid-template-columns:repeat({streams},\
         1fr)\">{names}</div><div class=\"film\" role=\"img\" aria-label=\"events side by side\" \
         style=\"width:{}px;height:{height}px;background-size:{width}px {}px;animation:film {:.2}s \
         steps({count}) infinite;background-image:url(data:image/png;base64,{})\"></div>",
        height * count,
        width + 2,
        height * count,
        FRAME_S * count as f64,
        STANDARD.encode(png(&strip(film))?)
    ));
    Ok(())
}

/// Whether pictures are of the size that the film says.
fn is_whole(film: &Film) -> bool {
    let pixels = film.width * film.height;
    let fits = |pictures: &Vec<String>| {
        pictures.len() == film.names.len() && pictures.iter().all(|p| p.len() == pixels)
    };
    pixels > 0 && !film.frames.is_empty() && film.frames.iter().all(|frame| fits(&frame.pictures))
}

fn row_px(film: &Film) -> usize {
    film.names.len() * (film.width + GAP) - GAP
}

/// All frames one below the other, each with all streams.
fn strip(film: &Film) -> RgbImage {
    let height = film.height * film.frames.len();
    let mut strip = RgbImage::from_pixel(row_px(film) as u32, height as u32, BETWEEN);
    for (k, frame) in film.frames.iter().enumerate() {
        for (s, picture) in frame.pictures.iter().enumerate() {
            for (i, digit) in picture.bytes().enumerate() {
                let x = s * (film.width + GAP) + i % film.width;
                let y = k * film.height + i / film.width;
                strip.put_pixel(x as u32, y as u32, colour(digit));
            }
        }
    }
    strip
}

fn colour(digit: u8) -> Rgb<u8> {
    let levels = (digit as char).to_digit(16).unwrap_or(0);
    let (on, off) = (f64::from(levels / 4), f64::from(levels % 4));
    let all = on + off;
    if all == 0.0 {
        return Rgb(PAPER.map(|channel| channel as u8));
    }
    let strength = [0.0, 0.5, 0.75, 1.0][(all.min(3.0)) as usize];
    let inks = [(ON.0, OFF.0), (ON.1, OFF.1), (ON.2, OFF.2)];
    Rgb(std::array::from_fn(|c| {
        let ink = (f64::from(inks[c].0) * on + f64::from(inks[c].1) * off) / all;
        (PAPER[c] + (ink - PAPER[c]) * strength) as u8
    }))
}
