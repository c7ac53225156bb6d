//! What there is.

use super::{Memory, PolarityUse, RepresentationSpec};
use crate::{
    Ageing, Binary, Counting, Eci, EciS, Eoi, Eros, ErosConfig, EventCount, FixedCount,
    FixedCountConfig, Lnes, Parameter, ParameterKind, ParameterValues, Pim, PimConfig, Sae, Sits,
    SitsConfig, TimeSurface, TimeSurfaceConfig, Tos, TosConfig, VoxelGrid, VoxelGridConfig,
    fill_eci, fill_eci_s, fill_eoi, fill_lnes,
};

/// All of them.
pub const REPRESENTATIONS: &[RepresentationSpec] = &[
    RepresentationSpec {
        name: "lnes",
        summary: "how recently a pixel fired, per polarity",
        parameters: &[],
        memory: Memory::Window,
        polarity: PolarityUse::Channels,
        any_order_at_once: true,
        channels: |_| 2,
        start: |window, _| Box::new(Lnes::new(window)),
        fill: Some(|window, events, out| fill_lnes(window, events.iter().copied(), out)),
    },
    RepresentationSpec {
        name: "eoi",
        summary: "whether a pixel fired, per polarity",
        parameters: &[],
        memory: Memory::Window,
        polarity: PolarityUse::Channels,
        any_order_at_once: true,
        channels: |_| 2,
        start: |window, _| Box::new(Eoi::new(window)),
        fill: Some(|window, events, out| fill_eoi(window, events.iter().copied(), out)),
    },
    RepresentationSpec {
        name: "eci",
        summary: "how often a pixel fired, per polarity",
        parameters: &[],
        memory: Memory::Window,
        polarity: PolarityUse::Channels,
        any_order_at_once: true,
        channels: |_| 2,
        start: |window, _| Box::new(Eci::new(window, Counting::EveryEvent)),
        fill: Some(|window, events, out| {
            fill_eci(window, Counting::EveryEvent, events.iter().copied(), out);
        }),
    },
    RepresentationSpec {
        name: "eci-s",
        summary: "how often a pixel fired",
        parameters: &[],
        memory: Memory::Window,
        polarity: PolarityUse::Ignored,
        any_order_at_once: true,
        channels: |_| 1,
        start: |window, _| Box::new(EciS::new(window, Counting::EveryEvent)),
        fill: Some(|window, events, out| {
            fill_eci_s(window, Counting::EveryEvent, events.iter().copied(), out);
        }),
    },
    RepresentationSpec {
        name: "eci-parity",
        summary: "eci as the published program computes it: 0.01 per millisecond that fired",
        parameters: &[],
        memory: Memory::Window,
        polarity: PolarityUse::Channels,
        any_order_at_once: true,
        channels: |_| 2,
        start: |window, _| Box::new(Eci::new(window, Counting::OncePerFrame)),
        fill: Some(|window, events, out| {
            fill_eci(window, Counting::OncePerFrame, events.iter().copied(), out);
        }),
    },
    RepresentationSpec {
        name: "eci-s-parity",
        summary: "eci-s as the published program computes it: two equal channels",
        parameters: &[],
        memory: Memory::Window,
        polarity: PolarityUse::Ignored,
        any_order_at_once: true,
        channels: |_| 2,
        start: |window, _| Box::new(EciS::new(window, Counting::OncePerFrame)),
        fill: Some(|window, events, out| {
            fill_eci_s(window, Counting::OncePerFrame, events.iter().copied(), out);
        }),
    },
    RepresentationSpec {
        name: "eros",
        summary: "how many events fell near a pixel since its own, 0 to 255, exponentially",
        parameters: &[kernel(ErosConfig::ONLINE.kernel_px, ParameterKind::Odd), DECAY],
        memory: Memory::Own,
        polarity: PolarityUse::Ignored,
        any_order_at_once: false,
        channels: |_| 1,
        start: |window, values| Box::new(Eros::new(window.sensor, eros(values))),
        fill: None,
    },
    RepresentationSpec {
        name: "eros-python",
        summary: "eros as the published data sets have it: off-centre, fractions dropped",
        parameters: &[kernel(ErosConfig::DATA_SETS.kernel_px, ParameterKind::Even), DECAY],
        memory: Memory::Own,
        polarity: PolarityUse::Ignored,
        any_order_at_once: false,
        channels: |_| 1,
        start: |window, values| Box::new(Eros::python(window.sensor, eros(values))),
        fill: None,
    },
    RepresentationSpec {
        name: "eros-hpe-core",
        summary: "eros as the published online program has it: rounded in f64 at each event",
        parameters: &[kernel(ErosConfig::ONLINE.kernel_px, ParameterKind::Odd), DECAY],
        memory: Memory::Own,
        polarity: PolarityUse::Ignored,
        any_order_at_once: false,
        channels: |_| 1,
        start: |window, values| Box::new(Eros::hpe_core(window.sensor, eros(values))),
        fill: None,
    },
    RepresentationSpec {
        name: "tos",
        summary: "which pixels of a moving edge fired last, 0 to 255",
        parameters: &[
            kernel(TosConfig::PUBLISHED.kernel_px, ParameterKind::Odd),
            Parameter {
                name: "line",
                unit: "px",
                summary: "thickness of the lines that stay",
                kind: ParameterKind::Whole,
                least: 1.0,
                most: 8.0,
                default: TosConfig::PUBLISHED.line_px as f64,
            },
        ],
        memory: Memory::Own,
        polarity: PolarityUse::Ignored,
        any_order_at_once: false,
        channels: |_| 1,
        start: |window, values| {
            let (kernel_px, line_px) = (values.whole("kernel"), values.whole("line"));
            Box::new(Tos::new(window.sensor, TosConfig { kernel_px, line_px }))
        },
        fill: None,
    },
    RepresentationSpec {
        name: "sits",
        summary: "in which order the pixels around an edge fired, 0 to kernel²",
        parameters: &[kernel(SitsConfig::PUBLISHED.kernel_px, ParameterKind::Odd)],
        memory: Memory::Own,
        polarity: PolarityUse::Ignored,
        any_order_at_once: false,
        channels: |_| 1,
        start: |window, values| Box::new(Sits::new(window.sensor, sits(values, Ageing::AtLeast))),
        fill: None,
    },
    RepresentationSpec {
        name: "sits-hpe-core",
        summary: "sits as hpe-core means it: pixels of the same age do not age each other",
        parameters: &[kernel(SitsConfig::PUBLISHED.kernel_px, ParameterKind::Odd)],
        memory: Memory::Own,
        polarity: PolarityUse::Ignored,
        any_order_at_once: false,
        channels: |_| 1,
        start: |window, values| Box::new(Sits::new(window.sensor, sits(values, Ageing::Above))),
        fill: None,
    },
    RepresentationSpec {
        name: "pim",
        summary: "ON minus OFF events of a pixel, fading",
        parameters: &[Parameter {
            name: "rate",
            unit: "1/s",
            summary: "how fast values fade",
            kind: ParameterKind::Real,
            least: 0.0,
            most: 1e6,
            default: PimConfig::PUBLISHED.rate_hz,
        }],
        memory: Memory::Own,
        polarity: PolarityUse::Sign,
        // Sums are rounded.
        any_order_at_once: false,
        channels: |_| 1,
        start: |window, values| {
            Box::new(Pim::new(window.sensor, PimConfig { rate_hz: values.number("rate") }))
        },
        fill: None,
    },
    RepresentationSpec {
        name: "sae",
        summary: "when a pixel last fired, in seconds",
        parameters: &[],
        memory: Memory::Own,
        polarity: PolarityUse::Ignored,
        any_order_at_once: true,
        channels: |_| 1,
        start: |window, _| Box::new(Sae::new(window.sensor)),
        fill: None,
    },
    RepresentationSpec {
        name: "binary",
        summary: "255 where a pixel fired",
        parameters: &[],
        memory: Memory::Window,
        polarity: PolarityUse::Ignored,
        any_order_at_once: true,
        channels: |_| 1,
        start: |window, _| Box::new(Binary::new(window)),
        fill: None,
    },
    RepresentationSpec {
        name: "fixed-count",
        summary: "how often a pixel fired among the latest events; three deviations are 255",
        parameters: &[Parameter {
            name: "n",
            unit: "events",
            summary: "how many events an image shows",
            kind: ParameterKind::Whole,
            least: 1.0,
            most: 1e9,
            default: FixedCountConfig::PUBLISHED.events as f64,
        }],
        memory: Memory::Count,
        polarity: PolarityUse::Ignored,
        // Which of them are the latest.
        any_order_at_once: false,
        channels: |_| 1,
        start: |window, values| {
            let config =
                FixedCountConfig { events: values.whole("n"), ..FixedCountConfig::PUBLISHED };
            Box::new(FixedCount::new(window.sensor, config))
        },
        fill: None,
    },
    RepresentationSpec {
        name: "event-count",
        summary: "how often a pixel fired; three deviations are 255, fractions dropped",
        parameters: &[],
        memory: Memory::Window,
        polarity: PolarityUse::Ignored,
        any_order_at_once: true,
        channels: |_| 1,
        start: |window, _| Box::new(EventCount::new(window)),
        fill: None,
    },
    RepresentationSpec {
        name: "voxel-grid",
        summary: "ON minus OFF events, spread over bins of time",
        parameters: &[Parameter {
            name: "bins",
            unit: "",
            summary: "bins of time, each a channel",
            kind: ParameterKind::Whole,
            least: 1.0,
            most: 1024.0,
            default: VoxelGridConfig::DEFAULT.bins as f64,
        }],
        memory: Memory::Window,
        polarity: PolarityUse::Sign,
        // Sums are rounded.
        any_order_at_once: false,
        channels: |values| values.whole("bins") as usize,
        start: |window, values| {
            Box::new(VoxelGrid::new(window, VoxelGridConfig { bins: values.whole("bins") }))
        },
        fill: None,
    },
    RepresentationSpec {
        name: "time-surface",
        summary: "how recently a pixel fired, per polarity, fading exponentially",
        parameters: &[Parameter {
            name: "tau_ms",
            unit: "ms",
            summary: "time constant",
            kind: ParameterKind::Real,
            least: 1e-3,
            most: 1e6,
            default: TimeSurfaceConfig::DEFAULT.tau_ms,
        }],
        memory: Memory::Own,
        polarity: PolarityUse::Channels,
        any_order_at_once: true,
        channels: |_| 2,
        start: |window, values| {
            let config = TimeSurfaceConfig { tau_ms: values.number("tau_ms") };
            Box::new(TimeSurface::new(window, config))
        },
        fill: None,
    },
];

const DECAY: Parameter = Parameter {
    name: "decay",
    unit: "",
    summary: "what kernel events nearby leave of a value",
    kind: ParameterKind::Real,
    least: 0.0,
    most: 1.0,
    default: ErosConfig::ONLINE.decay,
};

const fn kernel(default_px: u32, kind: ParameterKind) -> Parameter {
    Parameter {
        name: "kernel",
        unit: "px",
        summary: "width and height of the square that an event changes",
        kind,
        least: 1.0,
        most: ErosConfig::LARGEST_KERNEL_PX as f64,
        default: default_px as f64,
    }
}

fn eros(values: &ParameterValues) -> ErosConfig {
    ErosConfig { kernel_px: values.whole("kernel"), decay: values.number("decay") }
}

fn sits(values: &ParameterValues, ageing: Ageing) -> SitsConfig {
    SitsConfig { kernel_px: values.whole("kernel"), ageing }
}
