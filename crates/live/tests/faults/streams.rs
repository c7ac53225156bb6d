//! Sources that misbehave.

use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use evpose_core::{Event, EventStream, Micros, Polarity};
use evpose_live::sink::Sinks;
use evpose_live::source::StreamSource;
use evpose_live::{Control, LiveError, LiveOptions, PoseOrigin, Report, run};
use evpose_pose::stream::PoseStream;

use super::dummy::{
    ChannelReader, CollectingSink, CountingFrontend, EndlessStream, FrontendCounts, LONG, SENSOR,
    ScriptedWorker, events, framed, in_time, options, stream, task,
};

/// Runs a stream of bytes to its end, slowly enough for some inferences. Returns the poses of the
/// sink, the counts of the front end, the outcome and the report.
fn play(bytes: Vec<u8>) -> (CollectingSink, FrontendCounts, Result<(), LiveError>, Report) {
    in_time(move || {
        let (control, kept) = (Control::default(), CollectingSink::default());
        let frontend = CountingFrontend::slow(&control, Duration::from_millis(2));
        let seen = frontend.counts.clone();
        let mut sinks = Sinks::new();
        sinks.add(kept.clone());
        let ended = run(framed(bytes), task(frontend), &mut sinks, &options(), &control);
        sinks.finish().unwrap();
        let seen = seen.lock().unwrap().clone();
        (kept, seen, ended.map(drop), control.meter.report())
    })
}

#[test]
fn a_cut_stream_gives_every_pose_of_what_came_and_then_its_error() {
    // 20 packets of 5 ms each, the last without its last event and a half.
    let mut bytes = stream((0..20).map(|k| events(5_000 * k, 50, 100)));
    bytes.truncate(bytes.len() - 12);
    let length = bytes.len();
    let (kept, seen, ended, report) = play(bytes);
    let message = ended.unwrap_err().to_string();
    assert!(message.contains("the stream: byte ") && message.contains("1998 events readable"));
    let byte: usize = message.split([' ', ':']).find_map(|word| word.parse().ok()).unwrap();
    assert!(byte <= length, "{message}");
    assert_eq!((seen.events, report.followed, report.dropped_events), (1_998, 1_998, 0));
    // From the end of the first packet on, every 10 ms.
    let want: Vec<i64> = (0..9).map(|k| 14_950 + 10_000 * k).collect();
    assert_eq!(kept.times(PoseOrigin::Propagated), want);
    assert!(kept.times(PoseOrigin::Network).last().is_some_and(|t| *t > 0));
}

#[test]
fn a_stall_is_counted_and_the_pipeline_goes_on_when_events_come_again() {
    in_time(|| {
        let (feed, fed) = channel();
        let bytes = stream([events(0, 100, 100), events(5_000_000, 100, 100)]);
        let first = stream([events(0, 100, 100)]).len();
        feed.send(bytes[..first].to_vec()).unwrap();
        let (control, kept) = (Control::default(), CollectingSink::default());
        let (meter, frontend) = (control.meter.clone(), CountingFrontend::new(&control));
        let mut sinks = Sinks::new();
        sinks.add(kept.clone());
        let running = std::thread::spawn(move || {
            let options = LiveOptions { stall: Duration::from_millis(60), ..options() };
            let source = StreamSource::framed("fed", ChannelReader::new(fed), None).unwrap();
            let report =
                run(Box::new(source), task(frontend), &mut sinks, &options, &control).unwrap();
            sinks.finish().unwrap();
            report
        });
        let began = Instant::now();
        while meter.stalls.get() == 0 && began.elapsed() < LONG {
            std::thread::sleep(Duration::from_millis(5));
        }
        // It is one stall, however long it lasts.
        std::thread::sleep(Duration::from_millis(150));
        assert_eq!(meter.stalls.get(), 1);
        feed.send(bytes[first..].to_vec()).unwrap();
        drop(feed);
        let report = running.join().unwrap();
        assert_eq!((report.events, report.followed, report.restarts), (200, 200, 0));
        assert!(kept.times(PoseOrigin::Network).contains(&5_009_900));
    });
}

#[test]
fn a_source_that_is_given_up_ends_the_pipeline_with_an_error() {
    let (feed, fed) = channel();
    feed.send(stream([events(0, 100, 100)])).unwrap();
    let (ended, lasted) = in_time(|| {
        let control = Control::default();
        let (began, frontend) = (Instant::now(), CountingFrontend::new(&control));
        let give_up = Some(Duration::from_millis(200));
        let options = LiveOptions { give_up, ..options() };
        let source = StreamSource::framed("fed", ChannelReader::new(fed), None).unwrap();
        (
            run(Box::new(source), task(frontend), &mut Sinks::new(), &options, &control),
            began.elapsed(),
        )
    });
    let message = ended.unwrap_err().to_string();
    assert!(message.ends_with("no events for 0.2 s"), "{message}");
    assert!(lasted >= Duration::from_millis(200));
    drop(feed);
}

#[test]
fn time_that_jumps_back_begins_anew_and_poses_go_on() {
    let hour = 3_600_000_000;
    let bytes = stream((0..40).map(|k| events(if k < 20 { hour } else { 0 } + 5_000 * k, 50, 100)));
    let (kept, seen, ended, report) = play(bytes);
    ended.unwrap();
    assert_eq!((seen.events, seen.resets, report.restarts, report.rejected), (4_000, 1, 1, 0));
    let propagated = kept.times(PoseOrigin::Propagated);
    let (before, after): (Vec<i64>, Vec<i64>) = propagated.iter().partition(|t| **t >= hour);
    assert_eq!((before.len(), after.len()), (9, 9), "{propagated:?}");
    assert!(propagated.is_sorted_by_key(|t| *t < hour), "first those of before");
    assert!(kept.times(PoseOrigin::Network).iter().any(|t| *t < hour));
}

#[test]
fn a_jump_to_a_far_future_and_back_costs_no_more_than_its_packet() {
    // One event an hour ahead, as a flipped bit makes it, in every fifth packet.
    let packets = (0..40).map(|k| {
        let mut packet = events(5_000 * k, 50, 100);
        if k % 5 == 4 {
            let far = Event { t: Micros(3_600_000_000), x: 0, y: 0, polarity: Polarity::On };
            packet.push(far).unwrap();
        }
        packet
    });
    let (kept, seen, ended, report) = play(stream(packets));
    ended.unwrap();
    // The last packet is one of them, and nothing comes behind it.
    assert_eq!((seen.events, seen.resets, report.restarts), (4_008, 7, 7));
    // 500 ms of silence, at most, are filled with poses.
    assert!(kept.times(PoseOrigin::Propagated).len() < 40, "{}", kept.len());
}

#[test]
fn a_hot_pixel_fills_no_memory() {
    // 100 packets of 10 ms: 200 events all over the sensor, and 20,000 of one pixel.
    let packet = |k: i64| {
        let event = |n: i64| {
            let (t, polarity) = (Micros(10_000 * k + n * 10_000 / 20_200), Polarity::On);
            let (x, y) = if n % 101 == 0 { ((n % 64) as u16, (n % 48) as u16) } else { (5, 5) };
            Event { t, x, y, polarity }
        };
        EventStream::from_events(SENSOR, (0..20_200).map(event)).unwrap()
    };
    let bytes = stream((0..100).map(packet));
    let (seen, report) = in_time(move || {
        let control = Control::default();
        let frontend = CountingFrontend::slow(&control, Duration::from_millis(5));
        let seen = frontend.counts.clone();
        let options = LiveOptions { max_packets: 8, max_events: 60_000, ..options() };
        let mut sinks = Sinks::new();
        sinks.add(CollectingSink::default());
        let report = run(framed(bytes), task(frontend), &mut sinks, &options, &control).unwrap();
        sinks.finish().unwrap();
        let seen = seen.lock().unwrap().clone();
        (seen, report)
    });
    assert_eq!(report.events, 2_020_000);
    assert!(report.dropped_packets > 10, "{report:?}");
    assert_eq!(report.followed + report.dropped_events, report.events);
    assert_eq!(seen.events, report.followed);
    // The queue, the packet that the front end has, and one that is about to be queued, each of 32,766 at most.
    assert!(seen.max_waiting <= 60_000 + 2 * 32_766, "{seen:?}");
    assert!(report.network.poses > 0 && report.propagated.poses > 0, "{report:?}");
}

#[test]
fn packets_that_make_no_sense_are_passed_over_and_counted() {
    let header = stream([]).len();
    let packets: Vec<Vec<u8>> =
        (0..20).map(|k| stream([events(5_000 * k, 50, 100)]).split_off(header)).collect();
    let mut bytes = stream([]);
    for (k, packet) in packets.iter().enumerate() {
        let at = bytes.len();
        bytes.extend(packet);
        match k {
            // A marker, a count, and noise in front of a packet.
            3 => bytes[at] ^= 0xff,
            9 => bytes[at + 7] = 0x7f,
            15 => drop(bytes.splice(at..at, (0..500_u32).map(|n| ((n * 37) >> 2) as u8))),
            _ => {}
        }
    }
    let (kept, seen, ended, report) = play(bytes);
    ended.unwrap();
    assert_eq!((report.malformed, seen.events, report.rejected), (3, 1_800, 0));
    assert_eq!((seen.resets, kept.times(PoseOrigin::Propagated).len()), (0, 9));
}

#[test]
fn events_that_cannot_be_are_rejected_and_counted() {
    // The second half is as if its bytes had been lost: rows and columns beyond the sensor.
    let mut bytes = stream([events(0, 50, 100), events(5_000, 50, 100)]);
    let second = stream([events(0, 50, 100)]).len() + 16;
    for record in bytes[second..].chunks_mut(8).step_by(2) {
        record[4..8].fill(0xff);
    }
    let (_, seen, ended, report) = play(bytes);
    ended.unwrap();
    assert_eq!((seen.events, report.rejected, report.events), (150, 50, 150));
}

#[test]
fn a_network_that_fails_ends_the_pipeline_with_its_error() {
    let kept = CollectingSink::default();
    let mut sinks = Sinks::new();
    sinks.add(kept.clone());
    let (ended, sinks) = in_time(move || {
        let control = Control::default();
        let then = || Err(evpose_pose::stream::StreamError("no device memory is left".into()));
        let network = ScriptedWorker { times: 5, then };
        let task = PoseStream::new(CountingFrontend::new(&control), network);
        (run(EndlessStream::source(), task, &mut sinks, &options(), &control), sinks)
    });
    assert_eq!(ended.unwrap_err().to_string(), "no device memory is left");
    in_time(|| sinks.finish()).unwrap();
    assert_eq!(kept.times(PoseOrigin::Network).len(), 5);
}

#[test]
fn a_network_that_panics_does_not_leave_the_pipeline_waiting() {
    let ended = std::panic::catch_unwind(|| {
        in_time(|| {
            let control = Control::default();
            let network = ScriptedWorker { times: 2, then: || panic!("a bug of a network") };
            let task = PoseStream::new(CountingFrontend::new(&control), network);
            drop(run(EndlessStream::source(), task, &mut Sinks::new(), &options(), &control));
        });
    });
    let panic = ended.unwrap_err();
    let message = panic.downcast_ref::<&str>().copied().unwrap_or_default();
    assert_eq!(message, "a scoped thread panicked");
}
