//! The event-count image: how often each pixel fired, in grey values.
//!
//! # Model
//! The number of a pixel's events within the window, whatever their polarity, scaled so that three
//! standard deviations of the pixels that fired are 255, without fraction.
//!
//! # Borders
//! None: an event changes its own pixel only.
//!
//! # Source
//! hpe-core, `createCountImage` and `varianceNormalisation`. There, counters of 8 bits wrap, and
//! columns are taken for rows; neither is imitated.

use crate::Grey;
use crate::counts::{Counting, Counts};
use crate::drawn::Drawn;
use crate::spec::{Memory, PolarityUse, RepresentationSpec};
use crate::three_sigma::{three_sigma_scale, write_scaled};

pub(crate) static SPEC: RepresentationSpec = RepresentationSpec {
    name: "event-count",
    summary: "how often a pixel fired; three deviations are 255, fractions dropped",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Ignored,
    any_order_at_once: true,
    channels: |_| 1,
    start: |window, _| {
        Box::new(Drawn {
            state: Counts::new(window, Counting::EveryEvent),
            channels: 1,
            grey: Grey::White(255.0),
            draw: |counts, out| {
                assert_eq!(2 * out.len(), counts.per_polarity().len(), "planes of another size");
                let scale = three_sigma_scale(counts.per_pixel());
                write_scaled(out, counts.per_pixel(), scale, f64::trunc);
            },
        })
    },
    fill: None,
};
