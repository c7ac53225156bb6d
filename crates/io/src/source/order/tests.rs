use evpose_core::Polarity;
use proptest::prelude::*;

use super::*;

fn columns(times: impl IntoIterator<Item = i64>) -> Columns {
    let event = |(k, t): (usize, i64)| Event {
        t: Micros(t),
        x: (k % 60_000) as u16,
        y: 0,
        polarity: Polarity::On,
    };
    times.into_iter().enumerate().map(event).collect()
}

/// Times of the events that come out, in batches of `batch`, and what was found.
fn ordered(
    times: &[i64],
    restarts: Restarts,
    batch: usize,
) -> Result<(Vec<i64>, Disorder), ClockFault> {
    let (mut order, mut out) = (Order::new(restarts), Columns::new());
    for times in times.chunks(batch) {
        order.push(&columns(times.iter().copied()))?;
        let ready = order.ready();
        order.give(ready, &mut out);
    }
    order.finish(&mut out)?;
    Ok((out.t.iter().map(|t| t.0).collect(), order.disorder()))
}

fn refused(times: &[i64]) -> ClockFault {
    ordered(times, Restarts::Refuse, 64).unwrap_err()
}

#[test]
fn what_is_in_order_comes_as_it_is() {
    let times: Vec<i64> = (0..5_000).map(|k| 37 * k).collect();
    for batch in [1, 7, 5_000] {
        let found = ordered(&times, Restarts::Refuse, batch).unwrap();
        assert_eq!(found, (times.clone(), Disorder::default()));
    }
}

proptest! {
    /// Whatever the delays below 10 ms and the batches, events come sorted and none is lost.
    #[test]
    fn small_disorder_is_sorted(
        delays in proptest::collection::vec(0..9_999_i64, 50..400),
        batch in 1..200_usize,
    ) {
        let times: Vec<i64> =
            delays.iter().enumerate().map(|(k, d)| 700 * k as i64 + 20_000 - d).collect();
        let (out, found) = ordered(&times, Restarts::Refuse, batch).unwrap();
        let mut want = times.clone();
        want.sort_unstable();
        prop_assert_eq!(out, want);
        prop_assert_eq!(found.strays, 0);
        let (mut newest, mut late) = (i64::MIN, 0);
        for t in times {
            late += u64::from(t < newest);
            newest = newest.max(t);
        }
        prop_assert_eq!(found.sorted, late);
    }
}

#[test]
fn a_clock_that_starts_again_is_refused_parted_or_joined() {
    let run: Vec<i64> = (0..2_000).map(|k| 450 * k).collect();
    let times = [run.clone(), run.clone()].concat();
    let (from, to) = (Micros(450 * 1_999), Micros(0));
    assert_eq!(refused(&times), ClockFault::Restart { event: 2_000, from, to });
    for batch in [1, 64, 4_000] {
        for part in [1, 2] {
            let found = ordered(&times, Restarts::Part(part), batch).unwrap();
            assert_eq!(found.0, run, "part {part}, batches of {batch}");
        }
        let (joined, found) = ordered(&times, Restarts::Join, batch).unwrap();
        assert_eq!((joined.len(), found.restarts), (4_000, 1));
        let second: Vec<i64> = run.iter().map(|t| t + 450 * 1_999).collect();
        assert_eq!(joined[2_000..], second);
    }
}

#[test]
fn a_few_stamps_far_from_all_others_are_left_out_wherever_they_are() {
    let run: Vec<i64> = (0..3_000).map(|k| 2_000_000 + 667 * k).collect();
    let stray = |at: usize, t: i64| {
        let mut times = run.clone();
        times.splice(at..at, [t, t + 1, t + 2]);
        times
    };
    for (at, t) in [(0, 3_000_000_000), (1_500, 3_000_000_000), (1_500, 5), (3_000, 3_000_000_000)]
    {
        let (out, found) = ordered(&stray(at, t), Restarts::Refuse, 64).unwrap();
        assert_eq!(out, run, "{at}, {t}");
        assert_eq!((found.strays, found.first_stray), (3, Some((at as u64, Micros(t)))));
    }
}

#[test]
fn a_silence_of_any_length_is_none() {
    let far = 10 * 24 * 3600 * 1_000_000_i64;
    let times: Vec<i64> = (0..100).map(|k| 1_000 * k).chain((0..100).map(|k| far + k)).collect();
    let (out, found) = ordered(&times, Restarts::Refuse, 7).unwrap();
    assert_eq!((out, found), (times, Disorder::default()));
}

#[test]
fn a_counter_of_32_bits_that_begins_again_is_unwrapped() {
    let times: Vec<i64> = (0..6_000).map(|k| (1 << 32) - 2_000_000 + 1_000 * k).collect();
    let mut wrapped: Vec<i64> = times.iter().map(|t| t % (1 << 32)).collect();
    // Behind the wraparound, an event of before it.
    wrapped.swap(1_999, 2_000);
    let (out, found) = ordered(&wrapped, Restarts::Refuse, 64).unwrap();
    assert_eq!(out, times);
    assert_eq!((found.wraparounds, found.strays, found.sorted), (1, 0, 1));
}

#[test]
fn a_file_that_runs_backwards_or_at_random_is_refused_and_a_tiny_one_sorted() {
    let backwards = |interval| (0..5_000_i64).rev().map(|k| interval * k).collect::<Vec<i64>>();
    let random = |span| (0..5_000_i64).map(|k| (k * 7_919_993) % span).collect::<Vec<i64>>();
    assert!(matches!(refused(&backwards(500)), ClockFault::Restart { .. }));
    refused(&random(100_000_000));
    // Slow recordings, too.
    refused(&backwards(20_000));
    refused(&random(600_000_000));
    let (out, _) = ordered(&[9_000_000, 3, 1, 2], Restarts::Refuse, 64).unwrap();
    assert_eq!(out, [1, 2, 3, 9_000_000]);
}

#[test]
fn one_stray_is_left_out_whatever_its_number() {
    let run: Vec<i64> = (0..3_000).map(|k| 1_700_000_000_000_000 + 667 * k).collect();
    for at in [0, 1, 11, 50, 101, 2_000] {
        let mut times = run.clone();
        times.insert(at, 0);
        let (out, disorder) = ordered(&times, Restarts::Refuse, 64).unwrap();
        assert_eq!((out, disorder.strays), (run.clone(), 1), "{at}");
    }
}

#[test]
fn behind_a_seek_the_last_events_before_a_silence_are_no_faults() {
    let times: Vec<i64> = (0..8).chain((0..500).map(|k| 90_000_000 + k)).collect();
    let (mut order, mut out) = (Order::behind_seek(Restarts::Refuse), Columns::new());
    order.push(&columns(times.iter().copied())).unwrap();
    order.finish(&mut out).unwrap();
    assert_eq!(out.t.iter().map(|t| t.0).collect::<Vec<_>>(), times);
}

#[test]
fn events_of_one_time_stamp_do_not_wait_for_ever() {
    let mut order = Order::new(Restarts::Refuse);
    let mut out = Columns::new();
    let batch = columns(std::iter::repeat_n(5, 1 << 16));
    let mut waiting = 0;
    for _ in 0..200 {
        order.push(&batch).unwrap();
        waiting = order.waiting().max(waiting);
        let ready = order.ready();
        order.give(ready, &mut out);
        out.clear();
    }
    assert!(waiting <= MAX_WAITING + batch.len(), "{waiting}");
}
