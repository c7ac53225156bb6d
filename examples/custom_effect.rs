//! A sensor effect of one's own: fog, which adds the same light to every pixel and so lowers the
//! contrast.
//!
//! ```console
//! $ cargo run --release --example custom_effect
//! ```
//! An effect of evpose is such a file, plus a line in the registry; see `CONTRIBUTING.md`.

#![allow(clippy::print_stdout, reason = "a program")]

use anyhow::Result;
use evpose_core::{Micros, Plane, SensorSize, StageNoise};
use evpose_sensor::{
    Block, Citation, Domain, EffectConfig, NumberSpec, Parameter, PixelStage, Probe, STAGES,
    SensorConfig, SensorModel, Signature, Stage, StageSpec, Strength, Tick,
};

const HAZE: Parameter = Parameter::Number(NumberSpec {
    name: "haze",
    range: (0.001, 1.0),
    typical: Some((0.01, 0.3)),
    default: Some(0.0),
    doc: "light that fog adds, relative to white",
    ..NumberSpec::LOG
});

static FOG: StageSpec = StageSpec {
    name: "fog",
    domain: Domain::Optics,
    summary: "fog adds light everywhere",
    formula: "I = I + haze",
    params: &[HAZE],
    source: Citation { key: "this example", text: "made up, to show the parts of an effect" },
    signature: Signature {
        look_for: "fewer events of every edge, most of all in the dark",
        probe: Probe::RateByRadius,
        strength: Strength::Rising(&["haze"]),
        beside: &[],
    },
    build: |settings| Ok(Stage::Pixel(Box::new(Fog { haze: settings.number(&HAZE) as f32 }))),
};

#[derive(Debug)]
struct Fog {
    haze: f32,
}

impl PixelStage for Fog {
    fn is_neutral(&self) -> bool {
        self.haze <= 0.0
    }

    fn step(&self, _tick: &Tick, block: &mut Block<'_>, _noise: StageNoise) {
        block.signal.iter_mut().for_each(|light| *light += self.haze);
    }
}

fn main() -> Result<()> {
    let registry: Vec<&StageSpec> = STAGES.iter().copied().chain([&FOG]).collect();
    for haze in [0.0, 0.03, 0.1, 0.3] {
        let mut config = SensorConfig::preset("ideal")?;
        config.effects.push(EffectConfig::new("fog").with("haze", haze));
        let model = SensorModel::from_config_in(&registry, &config)?;
        let size = SensorSize { width: 64, height: 64 };
        let mut run = model.start(size, 1);
        let mut count = 0;
        for step in 0..200 {
            let mut frame = Plane::for_sensor(size, 0.0);
            for (pixel, light) in frame.data_mut().iter_mut().enumerate() {
                let x = (pixel % usize::from(size.width)) as f32 - 0.1 * step as f32;
                *light = 0.2 + 0.15 * (0.4 * x).sin();
            }
            count += run.expose(&frame, Micros(1_000 * step))?.len();
        }
        println!("haze {haze:<4}  {count:>6} events of a grating that moves for 0.2 s");
    }
    Ok(())
}
