//! The page in a headless browser; ignored where none is installed.
//!
//! The variable `EVPOSE_CHROMIUM` says which; else the usual names are tried. With
//! `EVPOSE_SCREENSHOTS`, screenshots of the page are written to that folder.

#![allow(clippy::unwrap_used, reason = "tests")]

mod chromium;

use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_live::page::{Page, PageInfo, Skeleton};
use evpose_live::sink::Sinks;
use evpose_live::{LivePose, Meter, PoseOrigin};
use evpose_pose::PoseEstimate;
use evpose_pose::body::BODY_JOINTS;
use glam::Vec2;
use libtest_mimic::{Arguments, Completion, Trial};

use chromium::Chromium;

const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

fn serve(address: SocketAddr, meter: &Arc<Meter>) -> Page {
    let info = PageInfo {
        title: "A <b>title</b>".to_owned(),
        source: "made up".to_owned(),
        sensor: SENSOR,
        skeleton: Skeleton::Body,
        hosts: Vec::new(),
        hand_mesh: None,
    };
    Page::serve(address, info, meter.clone()).unwrap()
}

/// Feeds a page a thousand events and a pose of each kind every ten milliseconds, until `is_over`.
fn feed(page: &Page, meter: &Meter, is_over: &AtomicBool) {
    let (view, mut sinks) = (page.view(), Sinks::new());
    sinks.add(page.sink());
    let mut t = Micros(0);
    while !is_over.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(10));
        t = t + Micros(10_000);
        let event = |k: u16| Event { t, x: 100 + k % 20, y: 50 + k % 30, polarity: Polarity::On };
        view.push(&EventStream::from_events(SENSOR, (0..1_000).map(event)).unwrap());
        meter.events.add(1_000);
        for (origin, latency_us) in [(PoseOrigin::Network, 12_500), (PoseOrigin::Propagated, 400)] {
            let joint = |k| Some(Vec2::new(60.0 + 10.0 * k as f32, 120.0 + 5.0 * k as f32));
            let estimate = PoseEstimate::Body {
                joints_px: std::array::from_fn(joint),
                scores: [0.7; BODY_JOINTS],
                score: 0.7,
            };
            let pose =
                LivePose { t, latency: Duration::from_micros(latency_us), origin, pose: estimate };
            meter.record(&pose);
            sinks.send(&Arc::new(pose));
        }
    }
    sinks.finish().unwrap();
}

/// Waits until a piece of JavaScript says so.
fn wait_until(browser: &mut Chromium, is_so: &str) {
    let end = Instant::now() + Duration::from_secs(60);
    while browser.says(is_so) != true {
        let text = browser.says("document.body.innerText");
        assert!(Instant::now() < end, "{is_so}: {text}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn main() -> ExitCode {
    let test = Trial::ignorable_test("the_page_shows_what_happens", || {
        let Some(browser) = Chromium::start() else {
            let reason = "no Chromium: install one, or name it in EVPOSE_CHROMIUM";
            return Ok(Completion::ignored_with(reason));
        };
        the_page_shows_what_happens(browser);
        Ok(Completion::Completed)
    });
    libtest_mimic::run(&Arguments::from_args(), vec![test]).exit_code()
}

fn the_page_shows_what_happens(mut browser: Chromium) {
    let folder = std::env::var_os("EVPOSE_SCREENSHOTS").map(PathBuf::from);
    let save = |browser: &mut Chromium, name: &str| {
        if let Some(folder) = &folder {
            std::fs::write(folder.join(name), browser.screenshot()).unwrap();
        }
    };
    let text = |id: &str| format!("document.getElementById('{id}').textContent");
    let (meter, is_over) = (Arc::new(Meter::new()), AtomicBool::new(false));
    let page = serve(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)), &meter);
    let address = page.local_addr();
    browser.open(&format!("http://{address}/"));
    wait_until(&mut browser, &format!("{} === 'waiting for events'", text("state")));

    std::thread::scope(|scope| {
        scope.spawn(|| feed(&page, &meter, &is_over));
        wait_until(&mut browser, &format!("{} === 'live'", text("state")));
        let rate = format!("parseFloat({})", text("events-rate"));
        // A hundred thousand events and a hundred poses a second, on a busy machine fewer.
        wait_until(&mut browser, &format!("{rate} > 10 && {rate} < 150"));
        assert_eq!(browser.says(&text("events-unit")), "k events/s");
        wait_until(&mut browser, &format!("parseFloat({}) > 10", text("network-rate")));
        assert_eq!(browser.says(&text("network-late")), "12.5 ms late");
        assert_eq!(browser.says(&text("propagated-late")), "0.40 ms late");
        assert_eq!(browser.says(&text("title")), "A <b>title</b>");
        assert_eq!(browser.says("document.querySelectorAll('.stage').length"), 5);
        // Blue where events are, and nothing where there are none.
        let colour = |x: u32, y: u32| {
            let at = format!("getImageData({x}, {y}, 1, 1).data");
            format!("(([r, g, b]) => b > 100 && b > r + 50)(scene.cells.getContext('2d').{at})")
        };
        wait_until(&mut browser, &colour(110, 60));
        assert_eq!(browser.says(&colour(10, 10)), false);
        assert_eq!(browser.says("document.documentElement.scrollWidth <= innerWidth"), true);
        std::thread::sleep(Duration::from_secs(2));
        save(&mut browser, "live.png");
        is_over.store(true, Ordering::Relaxed);
    });
    wait_until(&mut browser, &format!("{} === 'ended'", text("state")));
    save(&mut browser, "ended.png");

    drop(page);
    wait_until(&mut browser, &format!("{} === 'disconnected, trying again'", text("state")));
    save(&mut browser, "lost.png");
    let _page = serve(address, &meter);
    wait_until(&mut browser, &format!("{} !== 'disconnected, trying again'", text("state")));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
