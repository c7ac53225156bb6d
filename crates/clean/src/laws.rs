//! Laws that hold for every cleaner.

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use proptest::prelude::*;

use crate::{
    Background, BackgroundOptions, CLEANERS, CleanError, CleanReport, CleanRequest, Cleaner,
    CleanerChain, Deflicker, DeflickerOptions, Mask, Rectangle, Rule,
};

/// Events in time order, many of them at equal times and places.
pub(crate) fn events(sensor: SensorSize, max_us: i64) -> impl Strategy<Value = Vec<Event>> {
    let event = (0..max_us, 0..sensor.width, 0..sensor.height, any::<bool>());
    prop::collection::vec(event, 0..120).prop_map(|mut events| {
        events.sort_by_key(|&(t, ..)| t);
        let event = |(t, x, y, on)| Event { t: Micros(t), x, y, polarity: Polarity::from_on(on) };
        events.into_iter().map(event).collect()
    })
}

pub(crate) fn stream(sensor: SensorSize, events: &[Event]) -> EventStream {
    EventStream::from_events(sensor, events.iter().copied()).unwrap()
}

const SENSOR: SensorSize = SensorSize { width: 9, height: 7 };

/// A mask and a camera for the sensor.
struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let rectangles = vec![Rectangle { x: 2, y: 3, width: 4, height: 2 }];
        let mask = Mask { sensor: SENSOR, pixels: vec![(8, 6), (0, 0)], rectangles };
        mask.save(&folder.path().join("mask.toml")).unwrap();
        let camera = "sensor = { width = 9, height = 7 }\nfocal_px = [8.0, 8.0]\n\
                      principal_px = [4.5, 3.5]\ndistortion = [-0.25, 0.05, 0.01, 0.0]\n";
        std::fs::write(folder.path().join("camera.toml"), camera).unwrap();
        Self(folder)
    }

    /// Every cleaner, as it comes and with other parameters, and some together.
    fn requests(&self) -> Vec<Vec<String>> {
        let file = |name: &str| self.0.path().join(name).display().to_string();
        let alone = [
            "hot".to_owned(),
            "hot:count=4".to_owned(),
            "hot:preset=dhp19".to_owned(),
            format!("mask:file={}", file("mask.toml")),
            "background:tau_ms=5".to_owned(),
            "background:tau_ms=5,own=yes,polarity=same".to_owned(),
            "background:preset=dhp19".to_owned(),
            "deflicker:window_ms=7".to_owned(),
            "deflicker:rule=and,polarity=off".to_owned(),
            format!("undistort:file={}", file("camera.toml")),
            format!("undistort:file={},outside=clip", file("camera.toml")),
        ];
        let mut requests: Vec<Vec<String>> = alone.iter().map(|r| vec![r.clone()]).collect();
        // Surveys behind a cleaner that releases events late need its last events too.
        requests.push(vec![alone[7].clone(), alone[1].clone(), alone[4].clone(), alone[1].clone()]);
        requests.push(vec![alone[9].clone(), alone[7].clone(), alone[3].clone(), alone[8].clone()]);
        requests
    }
}

fn chain(sensor: SensorSize, requests: &[String]) -> Result<CleanerChain, CleanError> {
    let parsed: Result<Vec<CleanRequest>, _> = requests.iter().map(|text| text.parse()).collect();
    CleanerChain::new(sensor, &parsed?)
}

/// Runs a recording that comes in batches.
fn cleaned(requests: &[String], batches: &[EventStream]) -> (Vec<Event>, Vec<CleanReport>) {
    let mut chain = chain(SENSOR, requests).unwrap();
    while chain.surveys() > 0 {
        batches.iter().for_each(|batch| chain.survey(batch).unwrap());
        chain.end_survey().unwrap();
    }
    let mut out = Vec::new();
    for batch in batches {
        let mut batch = batch.clone();
        chain.clean(&mut batch).unwrap();
        out.extend(batch.iter());
    }
    out.extend(chain.finish().unwrap().iter());
    (out, chain.report())
}

#[test]
fn every_cleaner_of_the_registry_is_tried_here_and_has_a_name_of_its_own() {
    let files = Files::new();
    for (i, spec) in CLEANERS.iter().enumerate() {
        assert!(CLEANERS[..i].iter().all(|other| other.name != spec.name), "{}", spec.name);
        let tried = files.requests().concat();
        assert!(tried.iter().any(|text| text.starts_with(spec.name)), "{} is not", spec.name);
        for (k, param) in spec.params.iter().enumerate() {
            assert!(spec.params[..k].iter().all(|other| other.name() != param.name()));
            let request = format!("{}:{}=", spec.name, param.name());
            if let Some(default) = param.default() {
                format!("{request}{default}").parse::<CleanRequest>().unwrap();
            }
        }
    }
}

/// Four lit corners that fire in every other millisecond, a column that is busy, and noise.
fn busy() -> EventStream {
    let mut rng = evpose_core::CounterRng::new(3, "busy", 0);
    let mut below = |side: usize| rng.below(side) as u16;
    let event = |k: i64| {
        let (x, y, on) = match k % 5 {
            0 => (4, below(7), below(2) > 0),
            1 | 2 => (below(2) * 2 + 5, below(2) + 4, below(4) > 0),
            _ => (below(9), below(7), below(2) > 0),
        };
        let t = Micros(k / 2 * 300 + k / 40 * 9_000);
        Event { t, x, y, polarity: Polarity::from_on(on) }
    };
    EventStream::from_events(SENSOR, (0..600).map(event)).unwrap()
}

#[test]
fn requests_build_what_their_words_say() {
    let background = BackgroundOptions::default();
    let deflicker = DeflickerOptions::default();
    let built: [(&str, Box<dyn Cleaner>); 7] = [
        ("background", Box::new(Background::new(SENSOR, background))),
        (
            "background:neighbours=3,own=yes",
            Box::new(Background::new(
                SENSOR,
                BackgroundOptions { neighbours: 3, own_pixel: true, ..background },
            )),
        ),
        (
            "background:tau_ms=2,polarity=same",
            Box::new(Background::new(
                SENSOR,
                BackgroundOptions { tau: Micros(2_000), same_polarity: true, ..background },
            )),
        ),
        ("background:preset=dhp19", Box::new(Background::new(SENSOR, BackgroundOptions::DHP19))),
        ("deflicker", Box::new(Deflicker::new(SENSOR, deflicker))),
        (
            "deflicker:window_ms=7,rule=and",
            Box::new(Deflicker::new(
                SENSOR,
                DeflickerOptions { bins: 7, rule: Rule::And, ..deflicker },
            )),
        ),
        (
            "deflicker:polarity=off",
            Box::new(Deflicker::new(
                SENSOR,
                DeflickerOptions { counted: Polarity::Off, ..deflicker },
            )),
        ),
    ];
    for (request, mut cleaner) in built {
        let mut events = busy();
        cleaner.clean(&mut events);
        let mut last = EventStream::empty(SENSOR);
        cleaner.finish(&mut last);
        let wanted: Vec<Event> = events.iter().chain(last.iter()).collect();
        assert_eq!(cleaned(&[request.to_owned()], &[busy()]).0, wanted, "{request}");
    }
}

#[test]
fn every_parameter_of_the_registry_counts() {
    let files = Files::new();
    let file = |name: &str| files.0.path().join(name).display().to_string();
    let (mask, camera) = (file("mask.toml"), file("camera.toml"));
    let davis346 = SensorSize { width: 346, height: 260 };
    // The cleaner with everything it needs, and the parameter with a value that is not the default.
    let mut changed = vec![
        ("hot", String::new(), "factor", "1.2"),
        ("hot", String::new(), "count", "20"),
        ("mask", String::new(), "file", mask.as_str()),
        ("background", String::new(), "tau_ms", "0.5"),
        ("background", String::new(), "neighbours", "3"),
        ("background", "neighbours=2".to_owned(), "own", "yes"),
        ("background", "tau_ms=1".to_owned(), "polarity", "same"),
        ("background", String::new(), "preset", "dhp19"),
        ("deflicker", String::new(), "window_ms", "3"),
        ("deflicker", String::new(), "rule", "and"),
        ("deflicker", String::new(), "polarity", "off"),
        ("undistort", String::new(), "file", camera.as_str()),
        ("undistort", format!("file={camera}"), "outside", "clip"),
    ];
    let batches = [busy()];
    for (cleaner, given, key, value) in &changed {
        let request = |settings: &[String]| -> Vec<String> {
            let settings: Vec<&str> =
                settings.iter().map(String::as_str).filter(|text| !text.is_empty()).collect();
            let colon = if settings.is_empty() { "" } else { ":" };
            vec![format!("{cleaner}{colon}{}", settings.join(","))]
        };
        let with = cleaned(&request(&[given.clone(), format!("{key}={value}")]), &batches).0;
        let needs_it = given.is_empty() && ["mask", "undistort"].contains(cleaner);
        let without = if needs_it {
            batches[0].iter().collect()
        } else {
            cleaned(&request(std::slice::from_ref(given)), &batches).0
        };
        assert_ne!(with, without, "{cleaner}: {key} = {value}");
    }
    // Those for other sensors, or for more events than here, are tried where they are defined.
    changed.push(("hot", String::new(), "preset", "dhp19"));
    changed.push(("mask", String::new(), "preset", "dhp19-camera2"));
    changed.push(("undistort", String::new(), "preset", "davis240c-eventhands"));
    assert!(chain(davis346, &["mask:preset=dhp19-camera2".to_owned()]).is_ok());
    for spec in &CLEANERS {
        for param in spec.params {
            let is_changed = |(cleaner, _, key, _): &(&str, String, &str, &str)| {
                (*cleaner, *key) == (spec.name, param.name())
            };
            assert!(changed.iter().any(is_changed), "{}: {} is not tried", spec.name, param.name());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn a_cleaner_makes_no_events_keeps_their_order_and_does_not_care_for_batches(
        events in events(SENSOR, 30_000), cuts in prop::collection::vec(0_usize..120, 0..6),
    ) {
        let mut cuts: Vec<_> = cuts.into_iter().map(|cut| cut.min(events.len())).collect();
        cuts.extend([0, events.len()]);
        cuts.sort_unstable();
        let batches: Vec<EventStream> =
            cuts.windows(2).map(|cut| stream(SENSOR, &events[cut[0]..cut[1]])).collect();
        let whole = [stream(SENSOR, &events)];
        for requests in Files::new().requests() {
            let (kept, report) = cleaned(&requests, &whole);
            prop_assert_eq!(&cleaned(&requests, &whole), &(kept.clone(), report.clone()));
            prop_assert_eq!(&cleaned(&requests, &batches), &(kept.clone(), report.clone()));

            let displaces = requests.iter().any(|r| r.starts_with("undistort"));
            let mut rest = events.iter();
            for event in &kept {
                let same = |given: &&Event| {
                    let is_there = displaces || (given.x, given.y) == (event.x, event.y);
                    is_there && (given.t, given.polarity) == (event.t, event.polarity)
                };
                prop_assert!(rest.find(same).is_some(), "{:?} made {:?}", requests, event);
            }
            prop_assert!(kept.iter().all(|event| SENSOR.contains(event.x, event.y)));
            prop_assert_eq!(report[0].entered, events.len() as u64);
            for pair in report.windows(2) {
                prop_assert_eq!(pair[0].left, pair[1].entered);
            }
            prop_assert_eq!(report[report.len() - 1].left, kept.len() as u64);
        }
    }
}

fn refusal(sensor: SensorSize, request: &str) -> String {
    chain(sensor, &[request.to_owned()]).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn requests_that_cannot_be_served_say_why() {
    for (request, message) in [
        (
            "hott",
            "no cleaner is called `hott`; there are hot, mask, background, deflicker, undistort",
        ),
        ("hot:count", "\"hot:count\" is not written as `name:key=value,key=value`"),
        (
            "background:tau=3",
            "`background` has no parameter `tau`; it has preset, tau_ms, neighbours, own, polarity",
        ),
        (
            "background:tau_ms=-1",
            "`tau_ms` of `background` is \"-1\", expected a number in 0.001..=1000000",
        ),
        (
            "background:tau_ms=NaN",
            "`tau_ms` of `background` is \"NaN\", expected a number in 0.001..=1000000",
        ),
        ("background:own=1", "`own` of `background` is \"1\", expected one of no, yes"),
        ("background:preset=dhp19,tau_ms=3", "`background` takes `preset` or `tau_ms`, not both"),
        ("mask", "`mask` needs a file or a preset"),
        (
            "mask:preset=dhp19-camera2",
            "the mask `dhp19-camera2` is for a 346x260 sensor, the events come from one of 9x7",
        ),
        ("undistort", "`undistort` needs a file or a preset"),
        (
            "undistort:preset=davis240c-eventhands",
            "the camera of EventHands is for a 240x180 sensor, the events come from one of 9x7",
        ),
    ] {
        assert_eq!(refusal(SENSOR, request), message);
    }
    assert!(refusal(SENSOR, "mask:file=/no/such/file").starts_with("/no/such/file: "));
}

#[test]
fn a_chain_refuses_other_sensors_earlier_events_and_cleaning_before_its_survey() {
    let event = |t| Event { t: Micros(t), x: 1, y: 1, polarity: Polarity::On };
    let mut hot = chain(SENSOR, &["hot".to_owned()]).unwrap();
    let mut batch = stream(SENSOR, &[event(5)]);
    let refused = hot.clean(&mut batch).unwrap_err().to_string();
    assert_eq!(refused, "`hot` must see the whole recording before it cleans");
    let mut background = chain(SENSOR, &["background".to_owned()]).unwrap();
    let other = background.clean(&mut EventStream::empty(SensorSize::DAVIS240C)).unwrap_err();
    let wanted = "events of a 240x180 sensor, the cleaners are made for one of 9x7";
    assert_eq!(other.to_string(), wanted);
    background.clean(&mut batch).unwrap();
    let earlier = background.clean(&mut stream(SENSOR, &[event(4)])).unwrap_err().to_string();
    assert_eq!(earlier, "events start at 4 µs, before the last ones, which end at 5 µs");
}

#[test]
fn a_hot_pixel_is_found_in_the_survey_and_its_mask_can_be_kept() {
    let pixel = |t: i64| Event { t: Micros(1_000 * t), x: 4, y: 5, polarity: Polarity::On };
    let mut events: Vec<Event> = (0..50).map(pixel).collect();
    events.push(Event { x: 1, ..pixel(60) });
    let batch = stream(SENSOR, &events);
    let mut chain = chain(SENSOR, &["hot".to_owned()]).unwrap();
    chain.survey(&batch).unwrap();
    chain.end_survey().unwrap();
    let (name, mask) = chain.masks().next().unwrap();
    assert_eq!((name, mask), ("hot", &Mask { pixels: vec![(4, 5)], ..Mask::new(SENSOR) }));
    let mut batch = batch;
    chain.clean(&mut batch).unwrap();
    assert_eq!(batch, stream(SENSOR, &events[50..]));
    let report = &chain.report()[0];
    assert_eq!((report.removed(), report.notes[0].count), (50, 1));
}
