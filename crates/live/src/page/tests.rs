#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity};
use evpose_pose::body::BODY_JOINTS;
use glam::Vec2;
use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use super::*;
use crate::sink::Sinks;
use crate::{LivePose, PoseOrigin};
use evpose_pose::PoseEstimate;

const SENSOR: SensorSize = SensorSize { width: 640, height: 480 };
const LONG: Duration = Duration::from_secs(20);

fn info(hosts: Vec<String>) -> PageInfo {
    PageInfo {
        title: "A <test>".to_owned(),
        source: "events made up".to_owned(),
        sensor: SENSOR,
        skeleton: Skeleton::Body,
        hosts,
        hand_mesh: None,
    }
}

fn page() -> (Page, Arc<Meter>) {
    let meter = Arc::new(Meter::new());
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    (Page::serve(address, info(Vec::new()), meter.clone()).unwrap(), meter)
}

fn noise(index: u64) -> EventStream {
    let mut rng = CounterRng::new(1, "noise", index);
    let event = |_| Event {
        t: Micros(index as i64),
        x: (rng.bits() % 640) as u16,
        y: (rng.bits() % 480) as u16,
        polarity: Polarity::from_on(rng.unit() < 0.5),
    };
    EventStream::from_events(SENSOR, (0..200_000).map(event)).unwrap()
}

fn pose(origin: PoseOrigin, x: f32) -> LivePose {
    let mut joints_px = [None; BODY_JOINTS];
    joints_px[3] = Some(Vec2::new(x, 20.0));
    joints_px[4] = Some(Vec2::NAN);
    let estimate = PoseEstimate::Body { joints_px, scores: [0.5; BODY_JOINTS], score: 0.5 };
    LivePose { t: Micros(77), latency: Duration::from_millis(12), origin, pose: estimate }
}

fn asked(address: SocketAddr, request: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(LONG)).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

fn upgrade(page: &Page, host: &str, origin: Option<&str>) -> Result<WebSocket<TcpStream>, u16> {
    let mut request = format!("ws://{}/ws", page.local_addr()).into_client_request().unwrap();
    request.headers_mut().insert("Host", host.parse().unwrap());
    if let Some(origin) = origin {
        request.headers_mut().insert("Origin", origin.parse().unwrap());
    }
    let stream = TcpStream::connect(page.local_addr()).unwrap();
    stream.set_read_timeout(Some(LONG)).unwrap();
    match tungstenite::client(request, stream) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
            Err(response.status().as_u16())
        }
        Err(error) => panic!("{error}"),
    }
}

fn watch(page: &Page) -> WebSocket<TcpStream> {
    upgrade(page, &page.local_addr().to_string(), None).unwrap()
}

fn next_text(socket: &mut WebSocket<TcpStream>) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            return serde_json::from_str(&text).unwrap();
        }
    }
}

fn wait_until(name: &str, mut is_so: impl FnMut() -> bool) {
    let end = Instant::now() + LONG;
    while !is_so() {
        assert!(Instant::now() < end, "{name} did not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn the_page_is_one_document_without_anything_from_elsewhere() {
    let (page, _) = page();
    let answer = asked(page.local_addr(), "GET / HTTP/1.1\r\nHost: localhost:1\r\n\r\n");
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.contains(&format!("Content-Length: {}", body.len())));
    assert!(body.starts_with("<!doctype html>"));
    let links = body.replace("http://www.w3.org/2000/svg", "");
    for elsewhere in ["http://", "https://", "src=", "import ", "url("] {
        assert!(!links.contains(elsewhere), "{elsewhere}");
    }
}

#[test]
fn what_is_no_request_for_the_page_is_refused() {
    let (page, _) = page();
    let status = |request: &str| asked(page.local_addr(), request)[9..12].to_owned();
    assert_eq!(status("GET /favicon.ico HTTP/1.1\r\nHost: localhost\r\n\r\n"), "404");
    assert_eq!(status("GET /../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n"), "404");
    assert_eq!(status("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n"), "405");
    assert_eq!(status("GET /ws HTTP/1.1\r\nHost: localhost\r\n\r\n"), "400");
    assert_eq!(status("GET / HTTP/1.1\r\n\r\n"), "400");
    assert_eq!(status("GET / HTTP/1.1\r\nHost: camera.example.org\r\n\r\n"), "403");
    assert_eq!(status("GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n"), "400");
    assert_eq!(status("GET / HTTP/1.1\r\nHost: localhost:80@evil.com\r\n\r\n"), "400");
    assert_eq!(status("GET / HTTP/1.1\r\nHost: [::1].evil.com\r\n\r\n"), "400");
    assert_eq!(status("\u{1}\u{2}\u{3}\r\n\r\n"), "400");
    let long = format!("GET / HTTP/1.1\r\nHost: localhost\r\nX: {}", "x".repeat(16 * 1024 - 32));
    assert_eq!(status(&long[..16 * 1024]), "400");
}

#[test]
fn pages_of_other_sites_may_not_watch() {
    let (page, _) = page();
    let own = page.local_addr().to_string();
    for (host, origin) in [
        (own.as_str(), Some("http://example.org")),
        (own.as_str(), Some("null")),
        ("example.org", Some("http://example.org")),
    ] {
        assert_eq!(upgrade(&page, host, origin).err(), Some(403), "{host} {origin:?}");
    }
    assert!(upgrade(&page, &own, Some(&format!("http://{own}"))).is_ok());
    assert!(upgrade(&page, "localhost:80", Some("http://localhost:80")).is_ok());
}

#[test]
fn a_page_for_other_machines_answers_to_stated_names_alone() {
    let any = SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0));
    let page = Page::serve(any, info(vec!["camera.local".to_owned()]), Arc::default()).unwrap();
    let to = SocketAddr::from((Ipv4Addr::LOCALHOST, page.local_addr().port()));
    let status = |host: &str| {
        let head = format!("GET / HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n\r\n");
        asked(to, &head)[9..12].to_owned()
    };
    // A name that its owner points at this address would make its pages ours.
    assert_eq!(status("evil.com:8765"), "403");
    for host in ["camera.local:8765", "CAMERA.local", "127.0.0.1:1", "192.168.1.7:8765"] {
        assert_eq!(status(host), "200", "{host}");
    }
}

#[test]
fn a_client_sees_events_poses_and_figures() {
    let (page, meter) = page();
    let mut sinks = Sinks::new();
    sinks.add(page.sink());
    let mut socket = watch(&page);
    let about = next_text(&mut socket);
    assert_eq!(about["kind"], "about");
    assert_eq!((&about["title"], &about["joints"][3]), (&"A <test>".into(), &"elbow_l".into()));
    assert_eq!(about["sensor"]["width"], 640);
    assert_eq!(next_text(&mut socket)["state"], "waiting");

    let view = page.view();
    for origin in [PoseOrigin::Network, PoseOrigin::Propagated] {
        let pose = pose(origin, if origin == PoseOrigin::Network { 10.25 } else { 30.0 });
        meter.record(&pose);
        sinks.send(&Arc::new(pose));
    }
    let mut pushed = 0;
    let (mut brightest, mut shown) = (0, Value::Null);
    wait_until("a frame with all of it", || {
        meter.events.add(1_000);
        pushed += 1;
        view.push(&noise(pushed));
        if let Message::Binary(image) = socket.read().unwrap() {
            brightest = brightest.max(image.iter().skip(4).copied().max().unwrap());
            assert_eq!(image[..4], [128, 2, 224, 1], "640 x 480");
        }
        shown = next_text(&mut socket);
        !shown["propagated"].is_null() && shown["figures"]["rates"]["events"].as_f64() > Some(0.0)
    });
    assert!(brightest > 0);
    assert_eq!(shown["state"], "live");
    assert_eq!(shown["network"]["joints"][3], serde_json::json!([10.3, 20.0]));
    assert_eq!(
        (&shown["network"]["joints"][4], &shown["network"]["tenths"][3]),
        (&Value::Null, &5.0.into())
    );
    assert_eq!(shown["propagated"]["joints"][3][0], 30.0);
    wait_until("the latency", || next_text(&mut socket)["figures"]["point"]["network"].is_array());

    wait_until("a stall", || next_text(&mut socket)["state"] == "stalled");
    sinks.finish().unwrap();
    wait_until("the end", || next_text(&mut socket)["state"] == "ended");
}

#[test]
fn a_client_that_never_reads_is_left_and_holds_up_nobody() {
    let (page, _) = page();
    let (silent, mut awake) = (watch(&page), watch(&page));
    wait_until("both", || page.watchers() == 2);
    let view = page.view();
    let (mut pushed, mut longest) = (0, Duration::ZERO);
    let mut events = noise(0);
    wait_until("the end of patience", || {
        pushed += 1;
        if pushed % 10 == 0 {
            events = noise(pushed);
        }
        let before = Instant::now();
        view.push(&events);
        awake.read().unwrap();
        longest = longest.max(before.elapsed());
        page.watchers() == 1
    });
    assert!(longest < Duration::from_secs(2), "held up for {longest:?}");
    drop(silent);
    awake.read().unwrap();
}

#[test]
fn a_client_that_goes_away_is_forgotten() {
    let (page, _) = page();
    for is_polite in [false, true] {
        let mut socket = watch(&page);
        wait_until("the client", || page.watchers() == 1);
        if is_polite {
            socket.close(None).unwrap();
            // The farewell is answered.
            wait_until("its end", || match socket.read() {
                Ok(message) => message.is_close(),
                Err(error) => panic!("{error}"),
            });
        }
        drop(socket);
        wait_until("nobody", || page.watchers() == 0);
    }
}

#[test]
fn a_client_that_sends_too_much_is_left() {
    let (page, _) = page();
    let mut socket = watch(&page);
    wait_until("the client", || page.watchers() == 1);
    let _ = socket.send(Message::binary(vec![0; 100_000]));
    wait_until("nobody", || page.watchers() == 0);
}

#[test]
fn a_storm_of_viewers_takes_no_more_places_than_there_are_and_gives_them_back() {
    let (page, _) = page();
    let host = page.local_addr().to_string();
    for _ in 0..3 {
        let storm = || {
            std::thread::scope(|scope| {
                let one = || upgrade(&page, &host, None).map_err(|status| assert_eq!(status, 503));
                let asked: Vec<_> = (0..30).map(|_| scope.spawn(one)).collect();
                asked.into_iter().filter_map(|one| one.join().unwrap().ok()).collect::<Vec<_>>()
            })
        };
        let let_in = storm();
        assert_eq!(let_in.len(), MAX_WATCHERS);
        assert_eq!(page.watchers(), MAX_WATCHERS);
        drop(let_in);
        wait_until("nobody", || page.watchers() == 0);
    }
}

#[test]
fn slow_requests_hold_up_nobody() {
    let (page, _) = page();
    // More than there are places, all at their first bytes.
    let slow: Vec<TcpStream> = (0..60)
        .map(|_| {
            let mut stream = TcpStream::connect(page.local_addr()).unwrap();
            stream.write_all(b"GET / HT").unwrap();
            stream
        })
        .collect();
    let before = Instant::now();
    let answer = asked(page.local_addr(), "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
    // Two rounds of them have half a second each; one round of whole deadlines would be five.
    assert!(before.elapsed() < Duration::from_secs(4), "{:?}", before.elapsed());
    drop(slow);
}

#[test]
fn a_page_that_is_dropped_ends_whatever_its_clients_do() {
    let (page, _) = page();
    let mut socket = watch(&page);
    let silent = TcpStream::connect(page.local_addr()).unwrap();
    wait_until("the client", || page.watchers() == 1);
    let (address, before) = (page.local_addr(), Instant::now());
    drop(page);
    assert!(before.elapsed() < Duration::from_secs(2));
    wait_until("its end", || socket.read().is_err());
    assert!(TcpStream::connect(address).is_err());
    drop(silent);
}

#[test]
fn an_address_in_use_is_an_error() {
    let (page, _) = page();
    let error = Page::serve(page.local_addr(), info(Vec::new()), Arc::default()).err().unwrap();
    assert!(error.to_string().starts_with(&format!("http://{}: ", page.local_addr())), "{error}");
}

#[test]
fn events_cost_little() {
    let (page, _) = page();
    let socket = watch(&page);
    wait_until("the client", || page.watchers() == 1);
    let view = page.view();
    // A millisecond of five million events a second.
    let packets: Vec<EventStream> = (0..50)
        .map(|k| {
            let all = noise(k);
            let kept = (0..5_000).map(|index| all.get(index).unwrap());
            EventStream::from_events(SENSOR, kept).unwrap()
        })
        .collect();
    // The fastest of many: a busy machine says nothing about what it costs.
    let mut best = Duration::MAX;
    for _ in 0..20 {
        let before = Instant::now();
        packets.iter().for_each(|packet| view.push(packet));
        best = best.min(before.elapsed());
    }
    let share = best.as_secs_f64() / 0.05;
    println!("5 M events/s cost {:.2}% of a core", 100.0 * share);
    assert!(share < 0.2, "{share}");
    drop(socket);
}
