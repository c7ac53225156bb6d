//! Stamps scatter, whatever made the event.
//!
//! # Model
//! `either`: `t ← t + sigma_us N`. No stamp comes before what was delivered already: events at the
//! very start of a step move to later times only.
//! `late`: `t ← t + max(0, mean_us + sigma_us N)`, a latency that scatters, and is none at the least.
//!
//! # Source
//! Joubert et al. 2021 (IEBCS): jitter of the latency, 10 us in their example, clipped at zero.

use evpose_core::StageNoise;

use super::ClockStage;
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::tick::Tick;
use crate::{
    Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Parameter, Request, StageSpec, WordSpec,
};

const SIGMA: Parameter = Parameter::Number(NumberSpec {
    name: "sigma_us",
    unit: "us",
    range: (0.1, 1e5),
    typical: Some((1.0, 500.0)),
    doc: "standard deviation of stamps",
    ..LOG_OFF_AT_ZERO
});

const MEAN: Parameter = Parameter::Number(NumberSpec {
    name: "mean_us",
    unit: "us",
    range: (0.1, 1e5),
    typical: Some((10.0, 1e3)),
    doc: "mean of the latency where stamps are late, before it is clipped at zero",
    ..LOG_OFF_AT_ZERO
});

const SIDE: Parameter = Parameter::Word(WordSpec {
    name: "side",
    allowed: &["either", "late"],
    default: Some("either"),
    doc: "whether stamps scatter to both sides, or are late only",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "timestamp_jitter",
    domain: Domain::Clock,
    summary: "stamps scatter about the times of their events",
    formula: "t = t + sigma_us N; late: t = t + max(0, mean_us + sigma_us N)",
    params: &[SIGMA, MEAN, SIDE],
    source: Citation::JOUBERT_2021,
    signature: Signature {
        look_for: "stamps scatter about their times, the same for slow and fast changes",
        probe: Probe::StampError,
        strength: Strength::Rising(&["sigma_us"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Clock(Box::new(TimestampJitter {
            sigma_s: settings.number(&SIGMA) * 1e-6,
            mean_s: settings.number(&MEAN) * 1e-6,
            is_late: settings.word(&SIDE) == Some("late"),
        })))
    },
};

/// No stamp is further off than this many standard deviations, so that it is known when all
/// earlier ones have come.
const REACH: f64 = 4.0;

#[derive(Debug)]
struct TimestampJitter {
    sigma_s: f64,
    mean_s: f64,
    is_late: bool,
}

impl ClockStage for TimestampJitter {
    fn earliest_shown(&self, t_s: f64) -> f64 {
        if self.is_late { t_s } else { (t_s - REACH * self.sigma_s).max(0.0) }
    }

    fn step(&self, _tick: &Tick, events: &mut Vec<Request>, _state: &mut [f64], noise: StageNoise) {
        // A draw is that of a pixel at a time, so that an event keeps it whatever others come and
        // go; those of one pixel at one time, side by side in the list, are counted.
        let (mut last, mut repeat) = ((u32::MAX, 0), 0);
        for event in events {
            let key = (event.pixel, event.t_s.to_bits());
            repeat = if key == last { repeat + 1 } else { 0 };
            last = key;
            let draw = (key.1 ^ (key.1 >> 32)) as u32 & 0x0fff_ffff;
            let normal = noise.normal(event.pixel as usize, draw.wrapping_add(repeat << 16));
            let moved_s = self.sigma_s * f64::from(normal).clamp(-REACH, REACH);
            let moved_s = if self.is_late { (self.mean_s + moved_s).max(0.0) } else { moved_s };
            event.t_s = (event.t_s + moved_s).max(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Micros, Plane, Polarity, SensorSize};

    use super::*;
    use crate::{EffectConfig, Origin, SensorConfig, SensorModel};

    const EITHER: TimestampJitter = TimestampJitter { sigma_s: 1e-5, mean_s: 0.0, is_late: false };

    #[test]
    fn late_stamps_are_never_early_and_as_many_are_on_time_as_the_clipping_leaves() {
        let event =
            |pixel| Request { t_s: 0.5, pixel, polarity: Polarity::On, origin: Origin::Signal };
        let mut events: Vec<Request> = (0..20_000).map(event).collect();
        let tick = Tick { start_s: 0.0, end_s: 1.0, index: 1 };
        let late = TimestampJitter { sigma_s: 2e-3, mean_s: 1e-3, is_late: true };
        late.step(&tick, &mut events, &mut [], StageNoise::new(2, SPEC.name, 1));
        assert!(events.iter().all(|event| event.t_s >= 0.5));
        let on_time = events.iter().filter(|event| event.t_s == 0.5).count() as f64 / 20_000.0;
        // The normal distribution function at minus one half.
        assert!((on_time - 0.3085).abs() < 0.012, "{on_time}");
    }

    #[test]
    fn stamps_have_the_scatter_asked_for() {
        let n = 50_000;
        let at = |pixel| Request {
            t_s: 0.5 + f64::from(pixel % 7) * 1e-5,
            pixel,
            polarity: Polarity::On,
            origin: Origin::Signal,
        };
        let before: Vec<Request> = (0..n).map(at).collect();
        let mut events = before.clone();
        let tick = Tick { start_s: 0.0, end_s: 1.0, index: 1 };
        let noise = StageNoise::new(2, SPEC.name, 1);
        EITHER.step(&tick, &mut events, &mut [], noise);
        let moved = || events.iter().zip(&before).map(|(a, b)| (a.t_s - b.t_s) * 1e5);
        let mean = moved().sum::<f64>() / f64::from(n);
        let variance = moved().map(|d| d * d).sum::<f64>() / f64::from(n);
        assert!(mean.abs() < 4.0 / f64::from(n).sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 4.0 * (2.0 / f64::from(n)).sqrt(), "{variance}");
    }

    #[test]
    fn events_of_one_pixel_at_one_time_part() {
        let event = Request { t_s: 0.5, pixel: 3, polarity: Polarity::On, origin: Origin::Signal };
        let mut events = vec![event; 5];
        let tick = Tick { start_s: 0.0, end_s: 1.0, index: 1 };
        let noise = StageNoise::new(2, SPEC.name, 1);
        EITHER.step(&tick, &mut events, &mut [], noise);
        let mut times: Vec<f64> = events.iter().map(|e| e.t_s).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        assert_eq!(times.len(), 5);
    }

    /// Scatter of half a step of the scene, which moves many events across its ends.
    #[test]
    fn stamps_do_not_pile_up_where_steps_of_the_scene_end() {
        let mut config = SensorConfig::default();
        config.effects.push(EffectConfig::new(SPEC.name).with("sigma_us", 500.0));
        let size = SensorSize { width: 40, height: 40 };
        let mut run = SensorModel::from_config(&config).unwrap().start(size, 3);
        let mut phases = [0_usize; 10];
        for k in 0..60 {
            let mut plane = Plane::for_sensor(size, 0.0);
            for (i, y) in plane.data_mut().iter_mut().enumerate() {
                *y = (-3.0 + 0.03 * k as f32 + 1e-4 * i as f32).exp();
            }
            let events = run.expose(&plane, Micros(1_000 * k)).unwrap();
            assert!(events.t().is_sorted());
            for t in events.t().iter().filter(|t| t.0 > 10_000) {
                phases[(t.0 % 1_000 / 100) as usize] += 1;
            }
        }
        let mean = phases.iter().sum::<usize>() as f64 / 10.0;
        assert!(mean > 500.0, "{mean}");
        for n in phases {
            assert!((n as f64 - mean).abs() < 0.15 * mean, "{phases:?}");
        }
    }
}
