//! A photodiode whose current saturates smoothly.

use evpose_core::StageNoise;
use evpose_sensor::{
    Block, Citation, Domain, NumberSpec, Parameter, PixelStage, Probe, Signature, Stage, StageSpec,
    Strength, Tick,
};

const HALF: Parameter = Parameter::Number(NumberSpec {
    name: "half",
    unit: "white",
    range: (0.01, 100.0),
    typical: Some((0.2, 5.0)),
    default: Some(f64::INFINITY),
    doc: "light at which the photocurrent is half of the unsaturated one",
    ..NumberSpec::LOG
});

pub(crate) static SOFT_SATURATION: StageSpec = StageSpec {
    name: "soft_saturation",
    domain: Domain::Photodiode,
    summary: "photocurrent saturates smoothly",
    formula: "I = I / (1 + I / half)",
    params: &[HALF],
    source: Citation { key: "this example", text: "made up, to show an effect of another crate" },
    signature: Signature {
        look_for: "fewer events of every edge, the more the brighter it is",
        probe: Probe::Contrast,
        strength: Strength::Falling(&["half"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Pixel(Box::new(Saturation { half: settings.number(&HALF) as f32 })))
    },
};

#[derive(Debug)]
struct Saturation {
    half: f32,
}

impl PixelStage for Saturation {
    fn step(&self, _tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        block.signal.iter_mut().for_each(|light| *light /= 1.0 + *light / self.half);
    }
}
