//! The binary image: which pixels fired, whatever the polarity.
//!
//! # Model
//! 255 where a pixel fired within the window, 0 elsewhere.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! hpe-core, class `BIN` (event-driven's has 1 for 255), which is cleared by its user instead.

use crate::Grey;
use crate::drawn::Drawn;
use crate::last_times::LastTimes;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "binary",
    summary: "255 where a pixel fired",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Ignored,
    any_order_at_once: true,
    channels: |_| 1,
    start: |window, _| {
        Box::new(Drawn {
            state: LastTimes::new(window),
            channels: 1,
            grey: Grey::White(PEAK),
            draw: |last, out| {
                last.render_joined(out, |left_us| if left_us > 0 { PEAK } else { 0.0 });
            },
        })
    },
    fill: None,
};

const PEAK: f32 = 255.0;
