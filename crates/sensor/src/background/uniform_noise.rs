//! Noise events that every pixel sends at the same rate, whatever it sees.
//!
//! # Model
//! `signal = "kept"`: two Poisson processes per pixel, of rates `on_hz` and `off_hz`, beside the
//! signal; the memory of the detector is untouched.
//!
//! `signal = "replaced"`: in each step a pixel makes one noise event with probability
//! `(on_hz + off_hz) dt`, at the time of the exposure and in place of its signal events of that
//! step, whose effect on the memory stays: EventHands' form.
//!
//! Nothing is drawn per pixel. The processes of all pixels, one behind the other, are one process
//! along a line; drawing the gaps between its events costs one number per event.
//!
//! # Source
//! EventHands (Rudnev et al. 2021), supplement: 5.5e-5 ON and 2.2e-6 OFF per pixel and
//! millisecond.

use evpose_core::{Polarity, SensorSize, StageNoise};

use super::{BackgroundStage, exponential, uniform};
use crate::signature::{Probe, Signature, Strength};
use crate::stage::Stage;
use crate::tick::Tick;
use crate::{
    Citation, Domain, LOG_OFF_AT_ZERO, NumberSpec, Origin, Parameter, Request, StageSpec, WordSpec,
};

const RATE: NumberSpec = NumberSpec {
    name: "on_hz",
    unit: "Hz",
    range: (1e-5, 1e3),
    typical: Some((1e-3, 10.0)),
    doc: "ON noise events of one pixel per second",
    ..LOG_OFF_AT_ZERO
};

const ON: Parameter = Parameter::Number(RATE);
const OFF: Parameter = Parameter::Number(NumberSpec {
    name: "off_hz",
    doc: "OFF noise events of one pixel per second",
    ..RATE
});

const SIGNAL: Parameter = Parameter::Word(WordSpec {
    name: "signal",
    allowed: &["kept", "replaced"],
    default: Some("kept"),
    doc: "whether noise joins the signal of its pixel or takes its place in that step",
});

pub(crate) static SPEC: StageSpec = StageSpec {
    name: "uniform_noise",
    domain: Domain::Background,
    summary: "every pixel sends noise events at the same rates",
    formula: "ON ~ Poisson(on_hz dt), OFF ~ Poisson(off_hz dt)",
    params: &[ON, OFF, SIGNAL],
    source: Citation::RUDNEV_2021,
    signature: Signature {
        look_for: "exponential intervals at the same rate in every pixel, whatever the light",
        probe: Probe::RestIntervals,
        strength: Strength::Rising(&["on_hz", "off_hz"]),
        beside: &[],
    },
    build: |settings| {
        Ok(Stage::Background(Box::new(UniformNoise {
            on_hz: settings.number(&ON),
            off_hz: settings.number(&OFF),
            replaces_signal: settings.word(&SIGNAL) == Some("replaced"),
        })))
    },
};

#[derive(Debug)]
struct UniformNoise {
    on_hz: f64,
    off_hz: f64,
    replaces_signal: bool,
}

/// The sequences of draws of one tick. They take the place of a pixel in [`StageNoise`].
const ON_GAPS: usize = 0;
const OFF_GAPS: usize = 1;
const EITHER_GAPS: usize = 2;
const POLARITIES: usize = 3;

impl BackgroundStage for UniformNoise {
    fn step(&self, tick: &Tick, size: SensorSize, requests: &mut Vec<Request>, noise: StageNoise) {
        if tick.dt_s() <= 0.0 {
            return;
        }
        if self.replaces_signal {
            self.replace(tick, size, requests, noise);
        } else {
            add(tick, size, self.on_hz, Polarity::On, requests, noise);
            add(tick, size, self.off_hz, Polarity::Off, requests, noise);
        }
    }
}

/// A Poisson process along the line on which every pixel holds a length of one step.
fn add(
    tick: &Tick,
    size: SensorSize,
    rate_hz: f64,
    polarity: Polarity,
    requests: &mut Vec<Request>,
    noise: StageNoise,
) {
    let mean = rate_hz * tick.dt_s();
    if mean <= 0.0 {
        return;
    }
    // A stream for each polarity: a changed rate must not move events of the other.
    let sequence = if polarity.is_on() { ON_GAPS } else { OFF_GAPS };
    let mut position = 0.0;
    for draw in 0.. {
        // The whole part of the position is the pixel, its fraction the time within the step.
        position += exponential(noise, sequence, draw) / mean;
        if position >= size.pixels() as f64 {
            return;
        }
        let t_s = tick.end_s - tick.dt_s() * position.fract();
        let pixel = position as u32;
        requests.push(Request { t_s, pixel, polarity, origin: Origin::Shot });
    }
}

impl UniformNoise {
    /// One trial per pixel: the gaps between successes are geometric.
    fn replace(
        &self,
        tick: &Tick,
        size: SensorSize,
        requests: &mut Vec<Request>,
        noise: StageNoise,
    ) {
        let rate_hz = self.on_hz + self.off_hz;
        // floor(E / -ln(1 - p)) of an exponential E is geometric with probability p.
        let mean = -(-(rate_hz * tick.dt_s()).min(1.0)).ln_1p();
        let mut noise_events = Vec::new();
        let mut next = 0.0;
        for draw in 0.. {
            next += (exponential(noise, EITHER_GAPS, draw) / mean).floor();
            if next >= size.pixels() as f64 {
                break;
            }
            let is_on = uniform(noise, POLARITIES, draw) * rate_hz <= self.on_hz;
            let polarity = Polarity::from_on(is_on);
            let origin = Origin::Shot;
            noise_events.push(Request { t_s: tick.end_s, pixel: next as u32, polarity, origin });
            next += 1.0;
        }
        // Noise events are in order of pixels, as they were drawn.
        requests.retain(|r| {
            noise_events.binary_search_by_key(&r.pixel, |noise_event| noise_event.pixel).is_err()
        });
        requests.append(&mut noise_events);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: SensorSize = SensorSize::DAVIS240C;
    const STEPS: u64 = 4_000;

    /// Noise of four seconds in steps of a millisecond.
    fn noise_of(stage: &UniformNoise) -> Vec<Request> {
        let mut requests = Vec::new();
        for index in 1..=STEPS {
            let (start_s, end_s) = ((index - 1) as f64 * 1e-3, index as f64 * 1e-3);
            let mut step = Vec::new();
            let noise = StageNoise::new(11, SPEC.name, index);
            stage.step(&Tick { start_s, end_s, index }, SIZE, &mut step, noise);
            assert!(step.iter().all(|r| (start_s..=end_s).contains(&r.t_s)));
            assert!(step.iter().all(|r| (r.pixel as usize) < SIZE.pixels()));
            requests.append(&mut step);
        }
        requests
    }

    fn assert_four_sigma(count: usize, mean: f64) {
        assert!((count as f64 - mean).abs() < 4.0 * mean.sqrt(), "{count} instead of {mean}");
    }

    #[test]
    fn both_forms_have_the_published_rates() {
        for replaces_signal in [false, true] {
            let stage = UniformNoise { on_hz: 0.055, off_hz: 0.0022, replaces_signal };
            let requests = noise_of(&stage);
            let on = requests.iter().filter(|r| r.polarity.is_on()).count();
            assert_four_sigma(on, 2376.0 * 4.0);
            assert_four_sigma(requests.len() - on, 95.04 * 4.0);
            // Every part of the image gets its share.
            for quarter in 0..4u32 {
                let here = requests.iter().filter(|r| r.pixel / 10_800 == quarter).count();
                assert_four_sigma(here, 2471.04);
            }
        }
    }

    #[test]
    fn poisson_times_are_spread_evenly_over_a_step() {
        let stage = UniformNoise { on_hz: 0.5, off_hz: 0.5, replaces_signal: false };
        let phases: Vec<f64> = noise_of(&stage).iter().map(|r| (r.t_s * 1e3).fract()).collect();
        let n = phases.len() as f64;
        let mean = phases.iter().sum::<f64>() / n;
        let variance = phases.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / n;
        assert!((mean - 0.5).abs() < 4.0 / (12.0 * n).sqrt(), "{mean}");
        assert!((variance - 1.0 / 12.0).abs() < 4.0 / (180.0 * n).sqrt(), "{variance}");
    }

    #[test]
    fn a_pixel_makes_one_replacing_event_at_most_and_all_at_certainty() {
        let tick = Tick { start_s: 0.0, end_s: 1e-3, index: 1 };
        let noise = StageNoise::new(3, SPEC.name, 1);
        for (on_hz, expected) in [(400.0, None), (1000.0, Some(SIZE.pixels()))] {
            let stage = UniformNoise { on_hz, off_hz: 0.0, replaces_signal: true };
            let mut requests = Vec::new();
            stage.step(&tick, SIZE, &mut requests, noise);
            assert!(requests.windows(2).all(|pair| pair[0].pixel < pair[1].pixel));
            match expected {
                Some(count) => assert_eq!(requests.len(), count),
                None => {
                    let n = SIZE.pixels() as f64;
                    let error = (requests.len() as f64 - 0.4 * n).abs();
                    assert!(error < 4.0 * (0.4 * 0.6 * n).sqrt(), "{error}");
                }
            }
        }
    }

    #[test]
    fn replaced_signal_is_gone_and_the_rest_stays() {
        let tick = Tick { start_s: 0.0, end_s: 1e-3, index: 1 };
        let (polarity, origin) = (Polarity::Off, Origin::Signal);
        let signal = |pixel| Request { t_s: 1e-3, pixel, polarity, origin };
        let mut requests: Vec<Request> =
            (0..SIZE.pixels() as u32).flat_map(|pixel| [signal(pixel), signal(pixel)]).collect();
        let stage = UniformNoise { on_hz: 10.0, off_hz: 0.0, replaces_signal: true };
        stage.step(&tick, SIZE, &mut requests, StageNoise::new(5, SPEC.name, 1));
        let on: Vec<u32> =
            requests.iter().filter(|r| r.polarity.is_on()).map(|r| r.pixel).collect();
        assert!(on.len() > 300);
        assert_eq!(requests.len(), 2 * SIZE.pixels() - on.len());
        assert!(requests.iter().all(|r| r.polarity.is_on() || !on.contains(&r.pixel)));
    }
}
