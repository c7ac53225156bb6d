use evpose_core::{EventStream, Micros, SensorSize};
use proptest::prelude::*;

use super::line::{Known, Line, parse};
use super::*;
use crate::golden::check;
use crate::sample::{event, file, read_all};
use crate::{
    Columns, Input, IoError, OpenOptions, SensorOrigin, TimeUnit, open, open_with, read_as,
};

const SENSOR: SensorSize = SensorSize { width: 240, height: 180 };

#[test]
fn seconds_and_microseconds_are_distinguished_by_the_first_event() {
    let want = EventStream::from_events(
        SENSOR,
        [event(3811, 96, 133, false), event(4_000_000, 1, 2, true)],
    )
    .unwrap();
    for text in [
        "240 180\n0.003811 96 133 0\n4 1 2 1\n",
        "# rpg\n\n240 180 # DAVIS\r\n3.811e-3 96 133 0\r\n4.0 1 2 1",
        "240 180\n3811 96 133 0\n4000000 1 2 1\n",
    ] {
        let (_directory, path) = file("events.txt", text);
        let recording = open(&path).unwrap();
        assert_eq!(recording.stream, want, "{text}");
        assert_eq!(recording.sensor_origin, SensorOrigin::Stated);
    }
    let (_directory, path) = file("events.txt", "240 180\n3811 96 133 0\n4.0 1 2 1\n");
    assert!(matches!(open(&path), Err(IoError::Damaged { byte: 22, events: 1, .. })));
}

#[test]
fn without_a_size_the_sensor_is_given_or_the_smallest_that_holds_the_events() {
    let (_directory, path) = file("events.txt", "1 96 133 0\n2 97 12 1\n");
    let recording = open(&path).unwrap();
    assert_eq!(recording.stream.sensor(), SensorSize { width: 98, height: 134 });
    assert_eq!(recording.sensor_origin, SensorOrigin::Inferred);
    let recording = open_with(&path, Some(SENSOR)).unwrap();
    assert_eq!((recording.stream.sensor(), recording.sensor_origin), (SENSOR, SensorOrigin::Given));
}

#[test]
fn events_outside_the_sensor_are_counted_and_those_out_of_order_sorted() {
    let (_directory, path) =
        file("events.txt", "240 180\n5 240 0 1\n6 1 1 1\n5 1 1 1\n7 -1 1 1\n7 1 99999 1\n");
    let recording = open(&path).unwrap();
    assert_eq!(recording.stream.t(), [Micros(5), Micros(6)]);
    assert_eq!(recording.outside, 3);
}

#[test]
fn what_other_programs_write_is_read() {
    let want = [event(0, 96, 133, false), event(2_000, 97, 12, true), event(2_500, 3, 4, true)];
    let want = EventStream::from_events(SENSOR, want).unwrap();
    for text in [
        // A first stamp without a fraction.
        "0 96 133 -1\n0.002 97 12 1\n0.0025 3 4 +1\n",
        // Names, commas, microseconds.
        "t,x,y,p\n0,96,133,0\n2000,97,12,1\n2500,3,4,1\n",
        "timestamp;x;y;polarity\n0;96;133;False\n2000;97;12;True\n2500;3;4;True\n",
        "x,y,t,pol\n96,133,0,0\n97,12,2000,1\n3,4,2500,1\n",
        // Everything a floating-point number.
        "0.0e+00 9.6e+01 1.33e+02 0.0e+00\n2.0e-03 9.7e+01 1.2e+01 1.0\n2.5e-3 3.0 4.0 1.0\n",
    ] {
        let (_directory, path) = file("events.txt", text);
        assert_eq!(open_with(&path, Some(SENSOR)).unwrap().stream, want, "{text}");
    }
    for text in [
        // Metavision's `metavision_file_to_csv`.
        "%geometry:240,180\n96,133,0,0\n97,12,1,2000\n3,4,1,2500\n",
        "%camera:davis\n%geometry:240,180\r\n96,133,0,0\r\n97,12,1,2000\r\n3,4,1,2500\r\n",
    ] {
        let (_directory, path) = file("events.txt", text);
        let recording = open(&path).unwrap();
        assert_eq!((recording.format, &recording.stream), ("csv", &want), "{text}");
        assert_eq!(recording.sensor_origin, SensorOrigin::Stated);
    }
    for text in [
        // `DataFrame.to_csv`, and R's `write.csv`: a row index first.
        ",t,x,y,p\n0,0,96,133,0\n1,2000,97,12,1\n2,2500,3,4,1\n",
        ",x,y,p,t\n10,96,133,False,0\n20,97,12,True,2000\n40,3,4,True,2500\n",
        "\"\",\"t\",\"x\",\"y\",\"p\"\n\"1\",0,96,133,0\n\"2\",2000,97,12,1\n\"3\",2500,3,4,1\n",
        "index;t;x;y;p;camera\n0;0;96;133;0;a\n1;2000;97;12;1;a\n2;2500;3;4;1;a\n",
    ] {
        let (_directory, path) = file("events.txt", text);
        let recording = open_with(&path, Some(SENSOR)).unwrap();
        assert_eq!((recording.format, recording.stream), ("csv", want.clone()), "{text}");
    }
    // Prophesee's tables, without names.
    let (_directory, path) = file("events.txt", "96,133,0,40\n97,12,1,2000\n");
    let stream = open_with(&path, Some(SENSOR)).unwrap().stream;
    let want = [event(40, 96, 133, false), event(2_000, 97, 12, true)];
    assert_eq!(stream, EventStream::from_events(SENSOR, want).unwrap());
}

#[test]
fn columns_without_names_are_found_by_their_values_or_asked_for() {
    let lines = (0..300).map(|k| format!("{} {} {} {}\n", (37 * k) % 101, k % 90, 50 * k, k % 2));
    let (_directory, path) = file("events.txt", lines.clone().collect::<String>());
    let found = open_with(&path, Some(SENSOR)).unwrap();
    let (_directory, named) = file("events.txt", format!("x y t p\n{}", lines.collect::<String>()));
    assert_eq!(found.stream, open_with(&named, Some(SENSOR)).unwrap().stream);
    assert_eq!((found.stream.len(), found.outside), (300, 0));
    // A column more than an event has, in the place of time.
    let lines = (0..300).map(|k| format!("{} {} {} {}\n", (37 * k) % 101, k % 90, k % 2, k % 7));
    let (_directory, path) = file("events.txt", lines.collect::<String>());
    let message = open_with(&path, Some(SENSOR)).unwrap_err().to_string();
    assert!(message.contains("polarity") || message.contains("--columns"), "{message}");
}

#[test]
fn names_units_and_marks_of_other_programs_are_understood() {
    let open = |text: &str, options: &OpenOptions| {
        let input = Input::memory("events.csv", text.as_bytes().to_vec());
        read_as(input, options).map(|read| read.stream)
    };
    let options = OpenOptions { sensor: Some(SENSOR), ..OpenOptions::default() };
    let want = [event(1_500, 96, 133, false), event(2_500, 97, 12, true)];
    let want = EventStream::from_events(SENSOR, want).unwrap();
    for text in [
        "\u{feff}t,x,y,p\n1500,96,133,0\n2500,97,12,1\n",
        "t_us,x,y,p\n1500,96,133,0\n2500,97,12,1\n",
        "timestamp [ns],x_pos,y_pos,is_increase\n1500000,96,133,False\n2500000,97,12,True\n",
        "time_ms,x,y,on\n1.5,96,133,-1\n2.5,97,12,1\n",
        "x@346,y@260,on,t\n96,133,0,1500\n97,12,1,2500\n",
        "t,x,y,p\n1500,96,133,4294967295\n2500,97,12,1\n",
    ] {
        assert_eq!(open(text, &options).unwrap(), want, "{text}");
    }
    let stated = OpenOptions { time_unit: Some(TimeUnit::Nanoseconds), ..options.clone() };
    assert_eq!(open("t,x,y,p\n1500999,96,133,0\n2500000,97,12,1\n", &stated).unwrap(), want);
    let columns = "t=a,x=b,y=c,p=d".parse().unwrap();
    let named = OpenOptions { columns, ..options.clone() };
    let table = "d,c,b,a\n0,133,96,1500\n1,12,97,2500\n";
    assert_eq!(open(table, &named).unwrap(), want);
    let message = open(table, &options).unwrap_err().to_string();
    assert!(message.contains("--columns t=NAME"), "{message}");
    let columns = "t=4,x=2,y=1,p=0".parse().unwrap();
    let numbered = OpenOptions { columns, ..options.clone() };
    assert_eq!(open("0,133,96,9,1500\n1,12,97,9,2500\n", &numbered).unwrap(), want);
    let swapped = OpenOptions { swap_xy: true, ..options.clone() };
    assert_eq!(open("t,x,y,p\n1500,133,96,0\n2500,12,97,1\n", &swapped).unwrap(), want);
    let zero = OpenOptions { zero_time: true, ..options };
    assert_eq!(
        open("t,x,y,p\n1500,9,9,0\n2500,9,9,1\n", &zero).unwrap().t(),
        [Micros(0), Micros(1_000)]
    );
}

#[test]
fn a_faulty_line_is_named_with_its_byte() {
    let cases = [
        ("9 1 2 1\n8 1 2", "byte 8: line 2: 3 fields instead of t x y p"),
        ("9 1 2 1\n8 1 2 1 1\n", "byte 8: line 2: 5 fields instead of t x y p"),
        ("9 1 2 1\n9 1 2 2\n", "byte 8: line 2: `2` is no polarity, 0 or 1, or -1 or 1"),
        ("9 1 2 1\n9 1.5 2 1\n", "byte 8: line 2: `1.5` is no column"),
        (
            ",t,x,y,p\n0,9,1,2,1\n1,9,1,2\n",
            "byte 19: line 3: 4 fields instead of the 5 that are named",
        ),
        ("%geometry:9,9\n1,2,1,9\n1,2,1\n", "byte 22: line 3: 3 fields instead of t x y p"),
        ("9 1 2 1\n240 180\n", "byte 8: line 2: 2 fields instead of t x y p"),
    ];
    for (text, want) in cases {
        let (_directory, path) = file("events.txt", text);
        let message = open(&path).unwrap_err().to_string();
        assert_eq!(message, format!("{}: {want} (1 events readable before it)", path.display()));
    }
    for nonsense in [
        "%geometry:9\n1,2,1,9\n",
        "%geometry:9,0\n1,2,1,9\n",
        "0 nan 2 1",
        "1e300 1 2 1",
        "0 180\n",
        "99999999999999999999 1 2 1",
    ] {
        let (_directory, path) = file("events.txt", nonsense);
        assert!(matches!(open(&path), Err(IoError::Damaged { byte: 0, .. })), "{nonsense}");
    }
}

#[test]
fn a_line_without_end_does_not_fill_the_memory() {
    let (_directory, path) = file("events.txt", "1 ".repeat(100_000));
    let error = open(&path).unwrap_err();
    assert!(error.to_string().contains("line 1: longer than any line of events"), "{error}");
}

#[test]
fn a_number_that_may_be_cut_is_not_taken_for_one() {
    for (text, byte) in [
        ("t x y p\n1 2 3 1\n2 2 3 1", None),
        ("x y p t\n2 3 1 100\n2 3 1 10", Some(18)),
        ("2 3 0 100\n2 3 1 10", Some(10)),
        // Perhaps `x y p t`, with more digits to come.
        ("2 3 0 1", Some(0)),
        ("240 18", Some(0)),
        ("%geometry:240,18", Some(0)),
        (",p,x,y,t\n0,1,2,3,100\n1,1,2,3,10", Some(21)),
    ] {
        let (_directory, path) = file("events.txt", text);
        let fault = open(&path).err().map(|error| {
            assert!(error.to_string().contains("the file ends in it"), "{error}");
            error.byte().unwrap()
        });
        assert_eq!(fault, byte, "{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_stream_survives_the_file(
        mut times in prop::collection::vec(any::<i64>(), 0..40), seed in any::<u8>(),
    ) {
        times.sort_unstable();
        let events = times.iter().map(|&t| event(t, seed.into(), 7, t % 3 == 0));
        let stream = EventStream::from_events(SensorSize { width: 256, height: 8 }, events)?;
        let (_directory, path) = file("events.txt", "");
        FORMAT.write(&path, &stream).unwrap();
        prop_assert_eq!(&open(&path).unwrap().stream, &stream);
        CSV.write(&path, &stream).unwrap();
        prop_assert_eq!(open_with(&path, Some(stream.sensor())).unwrap().stream, stream);
    }
}

/// As the file would be read without the way for usual lines.
fn line_by_line(text: &str) -> (Columns, bool) {
    let mut known = Known { is_first: true, ..Known::default() };
    let mut columns = Columns::new();
    for line in text.split_inclusive('\n') {
        match parse(line.as_bytes(), &mut known) {
            Ok(Some(Line::Event(event))) => {
                known.is_first = false;
                columns.push(event);
            }
            Ok(_) => {}
            Err(_) => return (columns, false),
        }
    }
    (columns, true)
}

fn all_of(text: &str) -> (Columns, bool) {
    let input = Input::memory("events.txt", text.into());
    let mut source = (FORMAT.open)(input, &OpenOptions::default()).unwrap();
    let (columns, _, fault) = read_all(&mut *source);
    (columns, fault.is_none())
}

/// Times in seconds with up to twelve decimals, some of them near half a microsecond.
fn seconds() -> impl Strategy<Value = String> {
    let whole = prop_oneof![0..3_u64, 0..10_000_000_u64, 0..3_000_000_000_u64];
    let near = prop::sample::select(vec!["0005", "0004999", "0005001", "9999995", "49999", "5"]);
    let decimals = prop_oneof![
        (0..1_000_000_000_u64, 1..10_usize)
            .prop_map(|(n, digits)| format!("{n:09}")[..digits].into()),
        (0..1000_u64, near).prop_map(|(n, near)| format!("{n:03}{near}")),
        (0..1_000_000_000_000_u64).prop_map(|n| format!("{n:012}")),
        Just(String::new()),
    ];
    (whole, decimals).prop_map(|(whole, decimals)| format!("{whole}.{decimals}"))
}

/// A line, most often a usual one.
fn any_line(time: impl Strategy<Value = String>) -> impl Strategy<Value = String> {
    let separator = prop::sample::select(vec![" ", " ", ",", "\t", ";", "  "]);
    let polarity = prop::sample::select(vec!["0", "1", "0", "1", "-1", "+1", "True", "1.0"]);
    let end = prop::sample::select(vec!["\n", "\n", "\r\n", " \n", " # end\n", "\n\n"]);
    let place = prop_oneof![0..400_u32, 0..100_000_u32];
    (time, place.clone(), place, polarity, separator, end)
        .prop_map(|(t, x, y, p, s, end)| format!("{t}{s}{x}{s}{y}{s}{p}{end}"))
}

fn agree(lines: &[String], damage: Option<(usize, u8)>) -> Result<(), TestCaseError> {
    let mut text = lines.concat();
    if let Some((at, byte)) = damage {
        // The end of the last line stays: what is read of an open one is another test's.
        let at = at % (text.len() - 1);
        text.replace_range(at..=at, &char::from(byte % 128).to_string());
    }
    prop_assert_eq!(all_of(&text), line_by_line(&text), "{}", text);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn usual_lines_of_seconds_are_read_as_any_line_is(
        lines in prop::collection::vec(any_line(seconds()), 1..100),
        damage in prop::option::weighted(0.2, any::<(usize, u8)>()),
    ) {
        agree(&lines, damage)?;
    }

    #[test]
    fn usual_lines_of_microseconds_are_read_as_any_line_is(
        lines in prop::collection::vec(
            any_line((any::<u64>(), 1..64_u32).prop_map(|(t, bits)| (t >> bits).to_string())),
            1..100,
        ),
        damage in prop::option::weighted(0.2, any::<(usize, u8)>()),
    ) {
        agree(&lines, damage)?;
    }

    #[test]
    fn usual_lines_with_times_last_are_read_as_any_line_is(
        lines in prop::collection::vec((0..2000, 0..1000, 0..2, 2..1_000_000_000_000_i64), 1..100),
    ) {
        let line = |(x, y, p, t): &(i32, i32, i32, i64)| format!("{x},{y},{p},{t}\n");
        agree(&lines.iter().map(line).collect::<Vec<_>>(), None)?;
    }
}

#[test]
fn more_lines_than_are_gathered_at_once_are_read_in_order() {
    let text: String =
        (0..3000).map(|k| format!("{k} {} {} {}\n", k % 640, k % 48, k % 2)).collect();
    let (columns, is_whole) = all_of(&text);
    let want = (0..3000).map(|k| event(k, (k % 640) as u16, (k % 48) as u16, k % 2 == 1));
    assert!(is_whole && columns.iter().eq(want));
}

#[test]
fn a_fault_behind_many_usual_lines_has_its_line_and_byte() {
    let text = format!("{}5 5 5\n", "1000 96 133 0\n".repeat(1000));
    let (_directory, path) = file("events.txt", &text);
    let message = open(&path).unwrap_err().to_string();
    assert!(message.contains("byte 14000: line 1001: 3 fields instead"), "{message}");
    assert!(message.ends_with("(1000 events readable before it)"), "{message}");
}

/// See `tests/golden/text`.
#[test]
fn files_that_numpy_and_pandas_wrote_hold_the_events_that_it_was_given() {
    let files = [
        ("seconds.txt", "text"),
        ("nanoseconds.txt", "text"),
        ("named.csv", "csv"),
        ("pandas.csv", "csv"),
    ];
    check("text", &files);
}
