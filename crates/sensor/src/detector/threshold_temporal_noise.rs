//! The comparator is noisy: a threshold is another one at every event.
//!
//! # Model
//! After each event of a pixel, and at the start, `C_on` and `C_off` are the pixel's own plus
//! `sigma N`, none below 0.01. Event times then scatter by `sigma / |dV/dt|`, without a fixed
//! pattern.
//!
//! With `redraw = "exposure"` both are drawn anew at every exposure, whether there were events or
//! not, and a pixel has an event only where its voltage comes through the level of that exposure. A
//! slow change then reaches low levels early, and one that has passed them all has no event.
//!
//! # Source
//! Joubert et al. 2021 (IEBCS) redraw thresholds at events, Rebecq et al. 2018 (ESIM) for every image.

use evpose_core::{Polarity, StageNoise};

use super::threshold_mismatch::MIN_THRESHOLD;
use super::{PixelTerm, PixelTraits};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::{
    Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, StageSpec, Traits, WordSpec,
};

const SIGMA: Parameter = Parameter::Number(NumberSpec {
    name: "sigma",
    unit: "ln",
    range: (1e-4, 1.0),
    typical: Some((0.01, 0.1)),
    doc: "standard deviation of a threshold from event to event",
    ..LOG_OFF_AT_ZERO
});

const REDRAW: Parameter = Parameter::Word(WordSpec {
    name: "redraw",
    allowed: &["event", "exposure"],
    default: Some("event"),
    doc: "whether thresholds hold until the next event of a pixel, or for one exposure",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "threshold_temporal_noise",
    domain: Domain::Detector,
    summary: "thresholds are redrawn after every event, or at every exposure",
    formula: "C = max(0.01, C + sigma N(event)), or N(exposure)",
    params: &[SIGMA, REDRAW],
    source: Citation::JOUBERT_2021,
    signature: Signature {
        look_for: "times of crossings scatter about those of the ideal sensor, by the change of \
                   threshold over the slope; no fixed pattern",
        probe: Probe::StampError,
        strength: Strength::Rising(&["sigma"]),
        beside: &[],
    },
    build: |settings| {
        let sigma = settings.number(&SIGMA) as f32;
        let at_exposures = settings.word(&REDRAW) == Some("exposure");
        Ok(Stage::Term(Box::new(ThresholdTemporalNoise { sigma, at_exposures })))
    },
};

/// Beyond every normal value that is drawn: those of uniform values of 24 bits end at 5.8.
const MAX_NORMAL: f32 = 6.0;

#[derive(Debug)]
struct ThresholdTemporalNoise {
    sigma: f32,
    at_exposures: bool,
}

impl PixelTerm for ThresholdTemporalNoise {
    fn traits(&self) -> Traits {
        let redraws = self.at_exposures.then_some(MAX_NORMAL * self.sigma);
        Traits { renews: !self.at_exposures, redraws, ..Traits::default() }
    }

    fn redraw(&self, pixel: usize, noise: StageNoise) -> f32 {
        self.sigma * noise.normal(pixel, 0)
    }

    fn renew(
        &self,
        pixel: usize,
        count: u32,
        _last: Option<Polarity>,
        traits: &mut PixelTraits,
        noise: StageNoise,
    ) {
        // Draw indices wrap around after a billion events of one pixel.
        let draw = count.wrapping_mul(2) & 0x3fff_ffff;
        let redraw = |threshold: f32, draw: u32| {
            (threshold + self.sigma * noise.normal(pixel, draw)).max(MIN_THRESHOLD)
        };
        traits.threshold_on = redraw(traits.threshold_on, draw);
        traits.threshold_off = redraw(traits.threshold_off, draw + 1);
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Micros, Plane, SensorSize};

    use super::SPEC;
    use crate::{EffectConfig, SensorConfig, SensorModel};

    /// Events of many pixels that brighten by 0.97 ln in `steps` exposures, a threshold of 0.3.
    fn events(steps: i32, sigma: f64, redraw: &str) -> usize {
        let size = SensorSize { width: 100, height: 100 };
        let effects = vec![
            EffectConfig::new("level_crossing")
                .with("threshold_on", 0.3)
                .with("threshold_off", 0.3),
            EffectConfig::new("threshold_temporal_noise")
                .with("sigma", sigma)
                .with("redraw", redraw),
        ];
        let model = SensorModel::from_config(&SensorConfig { effects }).unwrap();
        let mut run = model.start(size, 5);
        let mut count = 0;
        for step in 0..=steps {
            let light = 0.3 * (0.97 * step as f32 / steps as f32).exp();
            let plane = Plane::filled(100, 100, light);
            count += run.expose(&plane, Micros(1_000 * i64::from(step))).unwrap().len();
        }
        count
    }

    #[test]
    fn without_spread_both_forms_are_level_crossing() {
        assert_eq!(events(30, 0.0, "exposure"), 30_000);
        assert_eq!(events(30, 1e-4, "exposure"), events(30, 1e-4, "event"));
    }

    #[test]
    fn detectors_that_cross_no_levels_keep_their_thresholds() {
        let size = SensorSize { width: 20, height: 20 };
        let events = |effects: &[EffectConfig]| -> Vec<_> {
            let config = SensorConfig { effects: effects.to_vec() };
            let mut run = SensorModel::from_config(&config).unwrap().start(size, 5);
            let light = |step: i64| Plane::filled(20, 20, 0.1 + 0.05 * ((step * 7) % 11) as f32);
            let all = (0..30).flat_map(|step| {
                run.expose(&light(step), Micros(1_000 * step)).unwrap().iter().collect::<Vec<_>>()
            });
            all.collect()
        };
        let redraw = EffectConfig::new(SPEC.name).with("sigma", 0.05).with("redraw", "exposure");
        for name in ["frame_difference", "frame_count"] {
            let detector = EffectConfig::new(name).with("threshold_on", 0.3);
            let detector = detector.with("threshold_off", 0.3);
            let alone = events(std::slice::from_ref(&detector));
            assert!(alone.len() > 1_000, "{name}");
            assert_eq!(events(&[detector, redraw.clone()]), alone, "{name}");
        }
    }

    #[test]
    fn a_level_that_is_behind_is_missed() {
        // In one exposure levels are multiples of one draw: the whole steps in 0.97 of N(0.3,
        // 0.05), which is what is expected of redrawing at events as well, nearly.
        let by_event = events(30, 0.05, "event") as f64;
        let in_one = events(1, 0.05, "exposure") as f64;
        assert!((in_one / by_event - 1.0).abs() < 0.1, "{in_one} {by_event}");
        // Of many exposures each takes the voltage through the level with a small probability, and
        // once it is three deviations beyond, never again.
        let in_many = events(3_000, 0.05, "exposure") as f64;
        assert!(in_many < 0.5 * by_event, "{in_many} {by_event}");
    }
}
