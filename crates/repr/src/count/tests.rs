use evpose_core::{Polarity, SensorSize};

use super::*;
use crate::ChannelOrder;

const SENSOR: SensorSize = SensorSize { width: 2, height: 1 };

fn event(frame: u32, x: u16, on: bool) -> FrameEvent {
    FrameEvent { frame, x, y: 0, polarity: Polarity::from_on(on) }
}

/// Pixel 0 fires ON three times in one frame and once in the next, OFF once; pixel 1 OFF once.
const EVENTS: [(u32, u16, bool); 6] =
    [(0, 0, true), (0, 0, true), (0, 0, false), (0, 0, true), (1, 0, true), (1, 1, false)];

fn events() -> impl Iterator<Item = FrameEvent> {
    EVENTS.into_iter().map(|(frame, x, on)| event(frame, x, on))
}

#[test]
fn every_event_counts_by_definition() {
    let window = FrameWindow::new(SENSOR, 2, ChannelOrder::OnFirst);
    let mut eci = [f32::NAN; 4];
    fill_eci(&window, Counting::EveryEvent, events(), &mut eci);
    assert_eq!(eci, [4.0, 0.0, 1.0, 1.0]);
    let mut eci_s = [f32::NAN; 2];
    fill_eci_s(&window, Counting::EveryEvent, events(), &mut eci_s);
    assert_eq!(eci_s, [5.0, 1.0]);
}

#[test]
fn the_published_program_counts_a_hundredth_once_per_frame_pixel_and_polarity() {
    let window = FrameWindow::new(SENSOR, 2, ChannelOrder::OnFirst);
    let mut eci = [f32::NAN; 4];
    fill_eci(&window, Counting::OncePerFrame, events(), &mut eci);
    assert_eq!(eci, [0.02, 0.0, 0.01, 0.01]);
    let mut eci_s = [f32::NAN; 4];
    fill_eci_s(&window, Counting::OncePerFrame, events(), &mut eci_s);
    assert_eq!(eci_s, [0.03, 0.01, 0.03, 0.01]);
}
