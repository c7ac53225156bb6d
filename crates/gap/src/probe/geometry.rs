//! Displacement of events in the image against the reference.
//!
//! Images of signed events over 20 ms are compared, in the slices of time in which the reference
//! has most events. Displacements are in pixels, from the reference to the measured image. Late
//! events are displaced along the motion, which [`timing`](super::timing) measures as well.

use crate::probe::displacement::Displacement;
pub(crate) use crate::probe::displacement::TILES;
use crate::probe::image::{Image, dot};
use crate::probe::interface::StatisticProbe;
use crate::probe::reference;
use crate::{Entry, StatisticBlock, View};

/// Terms of the displacement field, its residual, and correlations of images.
pub(super) static PROBE: StatisticProbe = StatisticProbe { name: "geometry", entries, measure };

const SLICE_US: i64 = 20_000;
const MAX_SLICES: usize = 8;
/// Pixels of all slices together: large images have enough events in fewer slices.
const MAX_PIXELS: usize = 250_000;
/// Counts of a pixel and slice are clipped here: larger ones come from noise, not from edges.
const MAX_COUNT: f32 = 8.0;
const TOLERANCE_PX: f64 = 0.05;
const TOLERANCE: f64 = 0.02;

/// Signed counts of the slices in which the reference has most events, measured and expected.
fn images(view: &View<'_>) -> Vec<[Image; 2]> {
    let size = view.size();
    let slices = (view.window.length().0 / SLICE_US).max(1) as usize;
    let slice_of = |t_us: i64| (view.since_start_us(t_us) / SLICE_US) as usize;
    let mut expected: Vec<(usize, usize, f32)> = Vec::new();
    let mut counts = vec![0_u32; slices];
    for list in reference::lists(view, view.window) {
        let sign = if list.is_on { 1.0 } else { -1.0 };
        for slice in list.t_us.iter().map(|t| slice_of(*t)).filter(|slice| *slice < slices) {
            counts[slice] += 1;
            expected.push((slice, list.pixel, sign));
        }
    }
    let mut order: Vec<usize> = (0..slices).filter(|slice| counts[*slice] > 0).collect();
    // The busiest by the reference, so that recording and runs are compared in the same slices.
    order.sort_by_key(|slice| (std::cmp::Reverse(counts[*slice]), *slice));
    order.truncate((MAX_PIXELS / size.pixels()).clamp(2, MAX_SLICES));
    let mut image_of = vec![None; slices];
    order.iter().enumerate().for_each(|(image, slice)| image_of[*slice] = Some(image));
    let zeros = || Image::zeros(usize::from(size.width), usize::from(size.height));
    let mut images: Vec<[Image; 2]> = order.iter().map(|_| [zeros(), zeros()]).collect();
    for (slice, pixel, sign) in expected {
        if let Some(image) = image_of[slice] {
            images[image][1].data[pixel] += sign;
        }
    }
    for event in view.events() {
        if let Some(Some(image)) = image_of.get(slice_of(event.t_us)) {
            let sign = if event.is_on { 1.0 } else { -1.0 };
            images[*image][0].data[event.pixel as usize] += sign;
        }
    }
    for count in images.iter_mut().flatten().flat_map(|image| &mut image.data) {
        // A hot pixel would be the strongest edge of the image.
        *count = count.clamp(-MAX_COUNT, MAX_COUNT);
    }
    images
}

pub(crate) fn displacements(view: &View<'_>) -> Vec<Option<(f64, f64)>> {
    let mut displacement = Displacement::default();
    for [measured, expected] in images(view) {
        let smooth = |image: Image| image.smoothed(1).smoothed(2);
        displacement.add(&smooth(measured), &smooth(expected));
    }
    displacement.of_tiles()
}

fn entries() -> Vec<Entry> {
    let terms = [
        "shift in x",
        "shift in y",
        "scale, at the corner",
        "rotation, at the corner",
        "cube of the radius, at the corner",
        "rest of displacement",
    ];
    let terms = terms
        .map(|name| Entry::value(StatisticBlock::Geometry, format!("{name}, px"), TOLERANCE_PX));
    let likeness = [0, 1, 2].map(|blur| {
        let name = format!("correlation of images, blur {blur} px");
        Entry::value(StatisticBlock::Geometry, name, TOLERANCE)
    });
    terms.into_iter().chain(likeness).collect()
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    let mut displacement = Displacement::default();
    // Scalar products: measured with expected, measured with measured, expected with expected.
    let mut products = [[0.0; 3]; 3];
    for [mut measured, mut expected] in images(view) {
        for (blur, products) in products.iter_mut().enumerate() {
            if blur > 0 {
                // The second blur is applied to the result of the first.
                measured = measured.smoothed(blur);
                expected = expected.smoothed(blur);
            }
            products[0] += dot(&measured.data, &expected.data);
            products[1] += dot(&measured.data, &measured.data);
            products[2] += dot(&expected.data, &expected.data);
        }
        // At the coarsest blur, whose gradients reach over a shift of some pixels.
        displacement.add(&measured, &expected);
    }
    let size = view.size();
    let aspect = f64::from(size.height) / f64::from(size.width);
    let (terms, rest) = displacement.field(aspect);
    out.extend(terms);
    out.push(rest);
    out.extend(products.map(|[both, measured, expected]| {
        let scale = (measured * expected).sqrt();
        if scale > 0.0 { both / scale } else { 0.0 }
    }));
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, EventStream};

    use super::*;
    use crate::probe::testing;

    fn moved(map: impl Fn(f64, f64) -> (f64, f64)) -> EventStream {
        testing::changed(|event| {
            let (x, y) = map(f64::from(event.x), f64::from(event.y));
            let (x, y) = (x.round(), y.round());
            let is_inside = (0.0..96.0).contains(&x) && (0.0..72.0).contains(&y);
            is_inside.then_some(Event { x: x as u16, y: y as u16, ..event })
        })
    }

    fn value(events: &EventStream, name: &str) -> f64 {
        testing::value(&PROBE, events, name)
    }

    #[test]
    fn events_in_their_place_are_not_displaced() {
        for entry in entries() {
            let value = value(testing::events(), &entry.name);
            let expected = if entry.name.starts_with("correlation") { 1.0 } else { 0.0 };
            assert!((value - expected).abs() < 1e-3, "{}: {value}", entry.name);
        }
    }

    #[test]
    fn a_shift_by_a_pixel_is_a_pixel() {
        for (dx, dy) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (1.0, -1.0)] {
            let shifted = moved(|x, y| (x + dx, y + dy));
            let shift = ["x", "y"].map(|axis| value(&shifted, &format!("shift in {axis}, px")));
            assert!((shift[0] - dx).abs() < 0.1, "{dx} {dy}: {shift:?}");
            assert!((shift[1] - dy).abs() < 0.1, "{dx} {dy}: {shift:?}");
            assert!(value(&shifted, "correlation of images, blur 0 px") < 0.95);
        }
    }

    #[test]
    fn noise_does_not_shrink_a_shift() {
        let shifted = moved(|x, y| (x + 1.0, y));
        let noisy = testing::stream(shifted.iter().chain(testing::noise(20_000, 7)));
        let dx = value(&noisy, "shift in x, px");
        assert!((dx - 1.0).abs() < 0.15, "{dx}");
    }

    #[test]
    fn scale_and_rotation_are_those_at_the_corner() {
        let (cx, cy) = (47.5, 35.5);
        let corner = f64::from(48 * 48 + 36 * 36).sqrt();
        let scaled = moved(|x, y| (cx + (x - cx) * 1.03, cy + (y - cy) * 1.03));
        let corner_shift = value(&scaled, "scale, at the corner, px")
            + value(&scaled, "cube of the radius, at the corner, px");
        assert!((corner_shift - 0.03 * corner).abs() < 0.4, "{corner_shift}");
        let turned = moved(|x, y| (x - 0.03 * (y - cy), y + 0.03 * (x - cx)));
        let rotation = value(&turned, "rotation, at the corner, px");
        assert!((rotation - 0.03 * corner).abs() < 0.4, "{rotation}");
    }
}
