//! Formulas at their stages, against closed forms and against effects that do the same.

use evpose_core::{Event, Polarity};
use evpose_sensor::{EffectConfig, SensorConfig, SensorError, SensorModel, formula_curve};

use crate::support::*;

fn formula(stage: &str, expression: &str) -> EffectConfig {
    effect("formula").with("stage", stage).with("expression", expression)
}

fn thresholds(on: f64, off: f64) -> EffectConfig {
    effect("level_crossing").with("threshold_on", on).with("threshold_off", off)
}

/// A wave that runs over 24 x 16 pixels for 0.2 s.
fn waves(effects: &[EffectConfig]) -> Vec<Event> {
    let mut run = sensor(effects, size(24, 16), 7);
    record(&mut run, 200, 1_000, |x, y, t| {
        0.3 + 0.25 * (0.5 * x as f64 + 0.1 * y as f64 - 40.0 * t).sin()
    })
}

/// The same events of every pixel, at times that are rounded differently at most.
#[track_caller]
fn assert_alike(actual: &[Event], expected: &[Event]) {
    let by_pixel = |events: &[Event]| {
        let mut events = events.to_vec();
        events.sort_by_key(|e| (e.y, e.x, e.t));
        events
    };
    assert_eq!(actual.len(), expected.len());
    for (a, b) in by_pixel(actual).iter().zip(&by_pixel(expected)) {
        assert_eq!((a.x, a.y, a.polarity), (b.x, b.y, b.polarity));
        assert!((a.t.0 - b.t.0).abs() <= 1, "{a:?} {b:?}");
    }
}

#[test]
fn a_constant_factor_of_thresholds_is_a_chain_with_these_thresholds() {
    let halved = waves(&[thresholds(0.4, 0.5), formula("threshold", "0.5")]);
    assert!(halved.len() > 1_000);
    assert_eq!(halved, waves(&[thresholds(0.2, 0.25)]));
    // The sign is that of the threshold.
    let signed = formula("threshold", "1 + a*polarity").with("a", 0.25);
    assert_eq!(waves(&[thresholds(0.2, 0.2), signed]), waves(&[thresholds(0.25, 0.15)]));
}

/// The general way of thresholds that change, with a formula that does not.
#[test]
fn thresholds_that_could_change_but_do_not_are_constant_ones() {
    let expected = waves(&[thresholds(0.2, 0.25)]);
    for expression in ["0.5 + 0*age_ms", "0.5 + 0*light", "0.5 + 0*neighbour_age_ms*time_s"] {
        let found = waves(&[thresholds(0.4, 0.5), formula("threshold", expression)]);
        assert_alike(&found, &expected);
    }
}

#[test]
fn a_threshold_that_decays_behind_an_event_is_met_where_it_is_the_rise() {
    // A rise of 2 per second: the interval is that at which 2 T = 0.2 (1 + exp(-T / 30 ms)).
    let decaying = formula("threshold", "1 + exp(-age_ms/b)").with("b", 30.0);
    let mut run = sensor(&[thresholds(C, C), decaying], size(1, 1), 1);
    let events = record(&mut run, 800, 1_000, |_, _, t| light(-2.0 + 2.0 * t));
    let times: Vec<f64> = events.iter().map(|e| e.t.as_seconds()).collect();
    let mut interval = 0.1;
    for _ in 0..50 {
        interval = 0.5 * C * (1.0 + f64::exp(-interval / 0.03));
    }
    // The first has no event before it, and the threshold of ever.
    assert_near(times[0], 0.1, 1e-5);
    assert!(times.len() >= 7);
    for found in intervals(&times) {
        // The exponential is taken for a line in each millisecond.
        assert_near(found, interval, 2e-5);
    }
}

#[test]
fn a_threshold_that_drifts_is_that_of_the_time() {
    let drift = formula("threshold", "1 + time_s");
    let mut run = sensor(&[thresholds(0.1, 0.1), drift], size(1, 1), 1);
    let events = record(&mut run, 1_000, 1_000, |_, _, t| light(-2.0 + t));
    // V rises by 1 per second, so that t' = t + 0.1 (1 + t').
    let mut expected = 0.0;
    assert!(events.len() >= 6, "{}", events.len());
    for event in events {
        expected = (expected + 0.1) / 0.9;
        assert_near(event.t.as_seconds(), expected, 1e-5);
    }
}

#[test]
fn a_refractory_period_of_a_formula_is_that_of_the_effect() {
    let own = effect("refractory").with("period_us", 4_000.0);
    let expected = waves(&[own]);
    assert_alike(&waves(&[formula("refractory", "4000")]), &expected);
    // Behind ON events alone.
    let busy = |sign: f64| {
        let mut run = sensor(&[formula("refractory", "4000*step(polarity)")], size(4, 4), 1);
        record(&mut run, 100, 1_000, |_, _, t| light(-2.0 + sign * (10.0 * t)))
    };
    let least = |events: &[Event]| {
        let times = times_by_pixel(events, size(4, 4));
        times.iter().flat_map(|times| intervals(times)).fold(f64::INFINITY, f64::min)
    };
    assert_near(least(&busy(1.0)), 0.024, 1e-5);
    assert_near(least(&busy(-1.0)), 0.02, 1e-5);
}

#[test]
fn a_constant_delay_shifts_every_stamp() {
    let late = waves(&[formula("delay", "250")]);
    let on_time = waves(&[]);
    assert!(!late.is_empty());
    // The last stamps are behind the last exposure.
    for (late, event) in late.iter().zip(&on_time) {
        assert_eq!((late.t.0, late.x, late.y), (event.t.0 + 250, event.x, event.y));
    }
    let delayed = effect("pixel_latency").with("delay_us", 250.0);
    assert_eq!(late, waves(&[delayed]));
    // The right half of the image alone.
    let rolling = waves(&[formula("delay", "250*step(column - 0.5)")]);
    let half = |events: &[Event], is_right: bool| {
        let own = events.iter().filter(move |e| (e.x >= 12) == is_right && e.t.0 < 199_000);
        own.map(|e| (e.t.0, e.x, e.y)).collect::<Vec<_>>()
    };
    assert_eq!(half(&rolling, false), half(&on_time, false));
    assert_eq!(half(&rolling, true), half(&late, true));
}

#[test]
fn a_loss_takes_its_share_of_the_events() {
    let (all, kept) = (waves(&[]), waves(&[formula("loss", "0.3")]));
    let n = all.len() as f64;
    assert_near(kept.len() as f64, 0.7 * n, 4.0 * (n * 0.3 * 0.7).sqrt());
    let mut rest = all.iter();
    assert!(kept.iter().all(|event| rest.any(|other| other == event)));
    // Of OFF events all, of ON events none.
    let on = waves(&[formula("loss", "step(-polarity)")]);
    assert!(on.iter().all(|event| event.polarity.is_on()));
    assert_eq!(on.len(), all.iter().filter(|event| event.polarity.is_on()).count());
    // Within 5 ms of the last event that was read out: a dead time of all that asks.
    let rare = waves(&[formula("loss", "step(5 - age_ms)")]);
    assert!(rare.len() < all.len());
}

#[test]
fn an_echo_comes_after_its_event_at_its_place() {
    let all = waves(&[]);
    let again = formula("echo", "0.25").with("after_us", 3_000.0).with("place", "right");
    let mut echoes = waves(&[again]);
    let mut missing = 0;
    for event in &all {
        let at = echoes.iter().position(|echo| echo == event);
        missing += usize::from(at.map(|at| echoes.remove(at)).is_none());
    }
    assert_eq!(missing, 0);
    let n = all.len() as f64;
    // Echoes of the last column and of the last 3 ms are not there.
    let has_place = |e: &&Event| e.x < 23 && e.t.0 + 3_000 <= 200_000;
    let shown = all.iter().filter(has_place).count() as f64;
    assert_near(echoes.len() as f64, 0.25 * shown, 4.0 * (n * 0.25 * 0.75).sqrt());
    for echo in echoes {
        let is_source = |e: &Event| {
            (e.t.0 + 3_000, e.x + 1, e.y, e.polarity) == (echo.t.0, echo.x, echo.y, echo.polarity)
        };
        assert!(all.iter().any(is_source), "{echo:?}");
    }
}

#[test]
fn further_events_have_the_rate_of_the_formula() {
    let still = |expression: &str| {
        let mut run = sensor(&[formula("events", expression)], size(40, 30), 3);
        record(&mut run, 500, 1_000, |_, _, _| 0.5)
    };
    assert_poisson(still("20*light*step(polarity)").len(), 1200.0 * 0.5 * 10.0);
    let left = still("30*step(0.5 - column)");
    assert!(left.iter().all(|event| event.x < 20));
    assert_poisson(left.iter().filter(|e| e.polarity == Polarity::Off).count(), 600.0 * 0.5 * 30.0);
}

#[test]
fn photocurrent_and_voltage_are_what_the_formula_says() {
    assert_eq!(
        waves(&[formula("photocurrent", "light + 0.05")]),
        waves(&[effect("dark_current").with("current", 0.05)])
    );
    // A gain on the light of time is an offset of the voltage: one event per 0.2 of both.
    for effect in [
        formula("photocurrent", "(light + 0.001)*exp(2*min(time_s, 1)) - 0.001"),
        formula("voltage", "2*time_s"),
    ] {
        let mut run = sensor(&[effect], size(2, 1), 1);
        let events = record(&mut run, 1_000, 1_000, |_, _, _| 0.5);
        let times = times_by_pixel(&events, size(2, 1));
        // Rounded, the last may be behind the end.
        assert!(times.iter().all(|times| (9..=10).contains(&times.len())), "{times:?}");
        for (k, t) in times[0].iter().enumerate() {
            assert_near(*t, 0.1 * (k + 1) as f64, 1e-4);
        }
    }
    // The ghost of a light on the left is on the right.
    let mut run = sensor(&[formula("photocurrent", "light + 0.1*ghost")], size(10, 2), 1);
    let events = record(&mut run, 100, 1_000, |x, _, t| if x < 2 { 0.1 + 5.0 * t } else { 0.01 });
    assert!(events.iter().any(|e| e.x >= 8) && events.iter().all(|e| e.x < 2 || e.x >= 8));
}

/// The same events on any number of threads, in blocks of any size, and of any detector and readout.
#[test]
fn formulas_do_not_depend_on_threads() {
    let detectors = [
        vec![],
        vec![effect("frame_difference").with("threshold_on", C).with("threshold_off", C)],
        vec![
            effect("arbiter").with("rate_hz", 1e6),
            effect("leak_on").with("rate_hz", 20.0),
            effect("threshold_temporal_noise").with("sigma", 0.02),
        ],
    ];
    let all = "1 + 0.2*exp(-age_ms/30) + 0.1*exp(-neighbour_age_ms/5)*last_polarity \
               + 0.1*pixel*exp(-light) + 0.05*patch + 0.01*d_light + 0.1*row*column_noise";
    for beside in detectors {
        for stage in ["threshold", "refractory", "loss", "echo", "events", "delay"] {
            let scaled = match stage {
                "threshold" => all.to_owned(),
                "refractory" | "delay" => format!("1000*({all})"),
                _ => format!("0.2*({all})"),
            };
            let mut effects = beside.clone();
            effects.push(formula(stage, &scaled).with("after_us", 2_500.0));
            let model = SensorModel::from_config(&SensorConfig { effects }).unwrap();
            let events = |threads, block| {
                let model = model.clone().with_threads(threads).with_block_pixels(block);
                let mut run = model.start(size(40, 20), 5);
                record(&mut run, 60, 1_130, |x, y, t| {
                    0.3 + 0.25 * (0.4 * x as f64 + 0.2 * y as f64 - 60.0 * t).sin()
                })
            };
            let expected = events(1, 4_096);
            assert!(expected.len() > 500, "{stage}: {}", expected.len());
            for (threads, block) in [(2, 4_096), (3, 64), (1, 100)] {
                assert!(events(threads, block) == expected, "{stage} {threads} {block}");
            }
        }
    }
}

#[test]
fn what_is_no_formula_is_refused_with_what_there_is() {
    let refusal = |stage: &str, expression: &str| {
        let config = SensorConfig { effects: vec![formula(stage, expression)] };
        let error = SensorModel::from_config(&config).unwrap_err();
        assert!(matches!(error, SensorError::Formula { .. }), "{error}");
        error.to_string()
    };
    let unknown = refusal("loss", "0.1 + lght");
    assert!(unknown.starts_with("effect `formula`: `expression` = \"0.1 + lght\""), "{unknown}");
    assert!(unknown.contains("stage `loss`, column 7") && unknown.contains("neighbour_age_ms"));
    // Light knows of no events.
    let of_events = refusal("photocurrent", "light*exp(-age_ms/3)");
    assert!(of_events.contains("column 12: unknown name `age_ms`"), "{of_events}");
    let infinite = refusal("threshold", "1/light");
    assert!(infinite.contains("is inf at light = 0; it has to be finite"), "{infinite}");
}

#[test]
fn a_curve_is_the_formula_along_a_variable() {
    let decaying = formula("threshold", "1 + a*exp(-age_ms/b)").with("a", 0.5).with("b", 30.0);
    let curve = formula_curve(&decaying, "age_ms", &[0.0, 30.0]).unwrap();
    assert_near(curve[0], 1.5, 1e-6);
    assert_near(curve[1], 1.0 + 0.5 * f64::exp(-1.0), 1e-6);
}
