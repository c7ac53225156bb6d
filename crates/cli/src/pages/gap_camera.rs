//! The page of `evpose gap camera`: values with their intervals, and images of the recordings.

use anyhow::Result;
use evpose_core::{EventStream, Plane};
use evpose_gap::camera::{CameraRecording, CameraReport};
use evpose_report::canvas::Canvas;
use evpose_report::html::{HtmlPage, escape};
use evpose_report::png::png;

/// Width of an image at least, pixels.
const IMAGE_PX: usize = 360;

/// Renders the page.
pub(crate) fn page(report: &CameraReport) -> Result<String> {
    let mut page = HtmlPage::new("Camera", "From recordings in unknown light.");
    page.section("Values", "Those of the camera are pooled. Intervals are of 95 %.");
    let words = |text: &String| format!("<span class=\"words\">{}</span>", escape(text));
    let rows: Vec<Vec<String>> =
        report.rows().iter().map(|row| row.iter().map(words).collect()).collect();
    page.table(&["state", "quantity", "value, or reason", "recordings"], &rows);
    page.section("Images", "Events of every pixel, ON blue, OFF red, logarithmic.");
    for CameraRecording { name, events, .. } in &report.recordings {
        let caption = format!("{}: {} events", escape(name), events.len());
        let [off, on] = maps(events);
        let scale = IMAGE_PX.div_ceil(on.width()) as u32;
        let image = png(&Canvas::events(&on, &off, scale).into_image())?;
        page.image("image/png", &image, "events of every pixel", &caption);
    }
    page.details("camera.toml", &report.preset());
    Ok(page.finish())
}

/// OFF and ON events of every pixel, from 0 to 1.
fn maps(events: &EventStream) -> [Plane<f32>; 2] {
    let mut maps = [(); 2].map(|()| Plane::for_sensor(events.sensor(), 0.0_f32));
    for event in events.iter() {
        let map = &mut maps[usize::from(event.polarity.is_on())];
        *map.at_mut(usize::from(event.x), usize::from(event.y)) += 1.0;
    }
    let most = maps.iter().flat_map(|map| map.data()).fold(1.0_f32, |a, b| a.max(*b)).ln_1p();
    maps.iter_mut().flat_map(|map| map.data_mut()).for_each(|n| *n = n.ln_1p() / most);
    maps
}
