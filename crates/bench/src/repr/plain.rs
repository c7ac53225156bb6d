//! The published loops, written plainly: what our representations are held against in every run.

use std::hint::black_box;

use evpose_core::EventStream;

use crate::peer_bench::Run;

/// EROS as its definition has it: every event multiplies a square of 7 by 7 doubles.
pub(super) fn eros(events: &EventStream) -> Run {
    let (width, height) = (usize::from(events.sensor().width), usize::from(events.sensor().height));
    // As defined: 0.3 to the power of one over the side of the square.
    let decay = 0.3_f64.powf(1.0 / 7.0);
    let events = events.clone();
    let mut image = vec![0.0_f64; width * height];
    Box::new(move || {
        for (&x, &y) in events.x().iter().zip(events.y()) {
            let (x, y) = (usize::from(x), usize::from(y));
            for row in y.saturating_sub(3)..(y + 4).min(height) {
                let columns = x.saturating_sub(3)..(x + 4).min(width);
                for value in &mut image[row * width..][columns] {
                    *value *= decay;
                }
            }
            image[y * width + x] = 255.0;
        }
        black_box(&image);
        Ok(())
    })
}

/// State of an LNES: the time of the last event of each pixel and polarity.
pub(super) fn lnes(events: &EventStream) -> Run {
    let width = usize::from(events.sensor().width);
    let pixels = events.sensor().pixels();
    let events = events.clone();
    let mut last = vec![i64::MIN; 2 * pixels];
    Box::new(move || {
        for event in events.iter() {
            let pixel = usize::from(event.y) * width + usize::from(event.x);
            last[usize::from(event.polarity.is_on()) * pixels + pixel] = event.t.0;
        }
        black_box(&last);
        Ok(())
    })
}
