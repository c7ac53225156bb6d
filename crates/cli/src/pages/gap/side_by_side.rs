//! Measured, simulated and corrected events side by side, as an animation.
//!
//! All frames are in one image, of which the page shows one part after the other.

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use evpose_gap::report::{ReportData, SideBySide};
use image::{Rgb, RgbImage};

use evpose_report::colour::{OFF, ON};
use evpose_report::html::{HtmlPage, escape};
use evpose_report::png::png;

/// Pixels between two streams.
const GAP: usize = 3;
/// Width of one stream on the page, at least, pixels.
const SHOWN: usize = 340;
/// Time for which a frame is shown, seconds.
const FRAME_S: f64 = 0.12;
const PAPER: [f64; 3] = [252.0, 252.0, 253.0];
const BETWEEN: Rgb<u8> = Rgb([226, 228, 234]);

pub(crate) fn section(page: &mut HtmlPage, data: &ReportData) -> Result<()> {
    // Pixels are placed by the sizes that the file states, which may be wrong.
    let Some(side_by_side) =
        data.side_by_side.as_ref().filter(|side_by_side| is_whole(side_by_side))
    else {
        return Ok(());
    };
    page.section(
        "Side by side",
        &format!(
            "Events of {} ms a frame, {} frames from {:.2} s to {:.2} s: ON blue, OFF red, stronger \
             where a pixel has more. Hold the pointer over it to stop it.",
            side_by_side.frame_us as f64 / 1e3,
            side_by_side.frames.len(),
            side_by_side.frames.first().map_or(0.0, |frame| frame.t_us as f64 * 1e-6),
            side_by_side.frames.last().map_or(0.0, |frame| frame.t_us as f64 * 1e-6),
        ),
    );
    let streams = side_by_side.names.len();
    // A whole multiple, at least `SHOWN` wide where the page has room for it.
    let scale = SHOWN
        .div_ceil(side_by_side.width)
        .min((1_130 / (streams * (side_by_side.width + GAP))).max(1));
    let (width, height) = (row_px(side_by_side) * scale, side_by_side.height * scale);
    let count = side_by_side.frames.len();
    let names: String =
        side_by_side.names.iter().map(|name| format!("<span>{}</span>", escape(name))).collect();
    page.markup(&format!(
        "<style>@keyframes sequence{{from{{background-position-y:0}}to{{background-position-y:-{}px}}}}\
         </style><div class=\"wide\"><div class=\"names\" \
         style=\"width:{width}px;grid-template-columns:repeat({streams},1fr)\">{names}</div>\
         <div class=\"sequence\" role=\"img\" aria-label=\"events side by side\" \
         style=\"width:{}px;height:{height}px;background-size:{width}px {}px;animation:sequence {:.2}s \
         steps({count}) infinite;background-image:url(data:image/png;base64,{})\"></div></div>",
        height * count,
        width + 2,
        height * count,
        FRAME_S * count as f64,
        STANDARD.encode(png(&strip(side_by_side))?)
    ));
    Ok(())
}

/// Whether all event images have the stated size.
fn is_whole(side_by_side: &SideBySide) -> bool {
    let pixels = side_by_side.width * side_by_side.height;
    let fits = |images: &Vec<String>| {
        images.len() == side_by_side.names.len() && images.iter().all(|p| p.len() == pixels)
    };
    pixels > 0
        && !side_by_side.frames.is_empty()
        && side_by_side.frames.iter().all(|frame| fits(&frame.images))
}

fn row_px(side_by_side: &SideBySide) -> usize {
    side_by_side.names.len() * (side_by_side.width + GAP) - GAP
}

/// All frames one below the other, each with all streams.
fn strip(side_by_side: &SideBySide) -> RgbImage {
    let height = side_by_side.height * side_by_side.frames.len();
    let mut strip = RgbImage::from_pixel(row_px(side_by_side) as u32, height as u32, BETWEEN);
    for (k, frame) in side_by_side.frames.iter().enumerate() {
        for (s, image) in frame.images.iter().enumerate() {
            for (i, digit) in image.bytes().enumerate() {
                let x = s * (side_by_side.width + GAP) + i % side_by_side.width;
                let y = k * side_by_side.height + i / side_by_side.width;
                strip.put_pixel(x as u32, y as u32, colour(digit));
            }
        }
    }
    strip
}

fn colour(digit: u8) -> Rgb<u8> {
    let levels = (digit as char).to_digit(16).unwrap_or(0);
    // A digit holds two counts of 0 to 3, that of ON events in its upper bits.
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
