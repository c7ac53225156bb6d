//! Residuals over the image, along its sides and over time, as images.

use std::fmt::Write as _;

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use evpose_gap::locate::{Arrow, Maps, Profile, ResidualImage};
use image::{Rgb, RgbImage};

use evpose_report::png::png;

/// Residuals of full colour, standard deviations.
pub(super) const FULL: f64 = 6.0;
/// Share of the colour of what is not significant.
const FAINT: f64 = 0.35;
/// Width of images and strips, pixels.
const WIDTH: usize = 330;
const STRIP: f64 = 54.0;
/// Length of the longest arrow, pixels of the page.
const ARROW: f64 = 36.0;

const PAPER: [f64; 3] = [250.0, 250.0, 251.0];
const MORE: [f64; 3] = [200.0, 70.0, 0.0];
const LESS: [f64; 3] = [20.0, 90.0, 190.0];

/// More measured is orange, less is blue; pale where chance does the same.
fn colour(z: f64, is_significant: bool) -> [u8; 3] {
    let ink = if z > 0.0 { MORE } else { LESS };
    let faint = if is_significant { 1.0 } else { FAINT };
    // The root gives small residuals a colour that is still visible.
    let strength = faint * (z.abs() / FULL).min(1.0).sqrt();
    std::array::from_fn(|c| (PAPER[c] + (ink[c] - PAPER[c]) * strength) as u8)
}

/// An image of residuals with the profiles of its columns and rows and of time.
pub(crate) fn figure(maps: &Maps, title: &str) -> Result<String> {
    let ResidualImage { width, height, side_px, residuals } = &maps.image;
    // Reports without a scene have no image.
    if *width == 0 || *height == 0 || residuals.z.len() != width * height {
        return Ok(String::new());
    }
    let image = RgbImage::from_fn(*width as u32, *height as u32, |x, y| {
        let i = y as usize * width + x as usize;
        let is_significant = residuals.is_significant.get(i).copied().unwrap_or(false);
        Rgb(colour(residuals.z[i], is_significant))
    });
    let caption = format!(
        "{} of {} places of {side_px} x {side_px} px, {} hot and {} silent pixels",
        residuals.significant(),
        residuals.z.len(),
        maps.hot,
        maps.silent
    );
    let mut figure = format!(
        "<figure class=\"map\"><h3>{title}</h3><img alt=\"residuals over the image\" width=\"{WIDTH}\" \
         src=\"data:image/png;base64,{}\"><figcaption>significant: {caption}</figcaption>",
        STANDARD.encode(png(&image)?)
    );
    figure += &quiver(maps, WIDTH as f64 * *height as f64 / *width as f64);
    let strips = [("columns", &maps.columns), ("rows", &maps.rows), ("time", &maps.times)];
    for (name, profile) in strips {
        figure += &strip(profile, name);
    }
    Ok(figure + "</figure>")
}

/// Arrows over a frame of the shape of the image, many times as long as displacements are.
fn quiver(maps: &Maps, height: f64) -> String {
    let length = |arrow: &Arrow| arrow.dx_px.hypot(arrow.dy_px);
    let longest = maps.arrows.iter().map(length).fold(0.0, f64::max);
    if !maps.arrows.iter().any(|arrow| arrow.is_significant) {
        return String::new();
    }
    let width = WIDTH as f64;
    // Displacements are parts of a pixel: the longest gets a fixed length.
    let scale = ARROW / longest;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height:.0}\" \
         width=\"{width}\" height=\"{height:.0}\" font-size=\"11\" style=\"display:block;\
         margin-top:6px;background:#fff;border:1px solid var(--line)\">"
    );
    for arrow in &maps.arrows {
        let (x, y) = (arrow.x * width, arrow.y * height);
        let (dx, dy) = (scale * arrow.dx_px, scale * arrow.dy_px);
        let ink = if arrow.is_significant { "#c84600" } else { "#b9bfc9" };
        let _ = write!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.2\" fill=\"{ink}\"/><line x1=\"{x:.1}\" \
             y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{ink}\" stroke-width=\"1.6\"/>",
            x + dx,
            y + dy
        );
    }
    let _ = write!(
        svg,
        "<text x=\"4\" y=\"12\" fill=\"#5d6675\">displacement, the longest {longest:.2} px</text></svg>"
    );
    svg
}

/// Residuals along a line as bars to either side.
fn strip(profile: &Profile, name: &str) -> String {
    let n = profile.z.len().max(1) as f64;
    let (width, middle) = (WIDTH as f64, STRIP / 2.0);
    let largest = profile.z.iter().fold(FULL, |most, z| most.max(z.abs()));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {STRIP}\" \
         width=\"{width}\" height=\"{STRIP}\" font-size=\"11\" style=\"display:block;margin-top:6px;\
         background:#fff;border:1px solid var(--line)\">"
    );
    for (i, z) in profile.z.iter().enumerate() {
        // Two pixels of margin, so that the largest does not touch the frame.
        let height = (z / largest * (middle - 2.0)).abs();
        let top = if *z > 0.0 { middle - height } else { middle };
        let is_significant = profile.is_significant.get(i).copied().unwrap_or(false);
        // The height says how much: colour only says whether it is chance.
        let [r, g, b] = colour(z.signum() * FULL, is_significant);
        let _ = write!(
            svg,
            "<rect x=\"{:.2}\" y=\"{top:.2}\" width=\"{:.2}\" height=\"{height:.2}\" \
             fill=\"rgb({r},{g},{b})\"/>",
            i as f64 * width / n,
            // Narrow bars would vanish between pixels.
            (width / n).max(0.6)
        );
    }
    let _ = write!(
        svg,
        "<text x=\"4\" y=\"12\" fill=\"#5d6675\">{name}</text>\
         <text x=\"{:.0}\" y=\"12\" fill=\"#5d6675\" text-anchor=\"end\">±{largest:.0} sd</text></svg>",
        width - 4.0
    );
    svg
}
