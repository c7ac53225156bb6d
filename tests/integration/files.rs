//! Recordings converted and looked at on the command line.

use crate::harness::{Sandbox, bytes};

/// A dot that runs over a sensor of 40x30 for half a second, ON in front and OFF behind.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let mut text = "40 30\n".to_owned();
    for k in 0..500 {
        let (t, x) = (1_000_000 + 1000 * k, (k / 16) % 32);
        text += &format!("{t} {} {} 1\n{t} {} {} 0\n", x + 4, 10 + k % 7, x, 10 + k % 7);
    }
    sandbox.write("dot.txt", text);
    sandbox
}

#[test]
fn a_recording_comes_back_from_every_format_that_can_be_written() {
    let sandbox = sandbox();
    let help = sandbox.ok(&["convert", "--help"]);
    for format in &evpose_io::FORMATS {
        assert!(help.contains(&format!("\n  {} ", format.name)), "{}", format.name);
        if format.create.is_none() {
            let message = sandbox.fails(&["convert", "dot.txt", "no", "--format", format.name]);
            assert!(message.contains("can only be read"), "{message}");
            continue;
        }
        // Some formats count time from 0, and few hold more than some seconds.
        let file = format!("dot.{}.bin", format.name);
        let said =
            sandbox.ok(&["convert", "dot.txt", &file, "--format", format.name, "--zero-time"]);
        assert!(said.contains("1000 events of a 40x30 sensor"), "{said}");
        sandbox.ok(&["convert", &file, "back.txt", "--sensor", "40x30"]);
        let back = sandbox.text("back.txt");
        let want = sandbox.text("dot.txt");
        let sorted = |text: &str, shift: i64| {
            let mut events: Vec<(i64, String)> = text
                .lines()
                .skip(1)
                .map(|line| line.split_once(' ').unwrap())
                .map(|(t, rest)| (t.parse::<i64>().unwrap() - shift, rest.to_owned()))
                .collect();
            // Some formats have an order of their own within one time.
            events.sort();
            events
        };
        assert!(sorted(&back, 0) == sorted(&want, 1_000_000), "{}", format.name);
    }
}

#[test]
fn a_part_is_cut_out_by_the_time_since_the_first_event() {
    let sandbox = sandbox();
    sandbox.ok(&["convert", "dot.txt", "part.txt", "--from", "0.1", "--to", "0.2"]);
    let part = sandbox.text("part.txt");
    let lines: Vec<&str> = part.lines().collect();
    assert_eq!((lines[0], lines[1], lines.len()), ("40 30", "1100000 10 12 1", 201));
    let message = sandbox.fails(&["convert", "dot.txt", "no.txt", "--from", "2", "--to", "1"]);
    assert!(message.contains("--from lies behind --to"), "{message}");
    assert!(!sandbox.path("no.txt").exists());
}

#[test]
fn events_out_of_order_and_outside_the_sensor_are_said() {
    let sandbox = sandbox();
    sandbox.write("odd.txt", "4 3\n90000 1 1 1\n5 1 1 1\n90001 4 1 1\n");
    let said = sandbox.ok(&["convert", "odd.txt", "out.npz"]);
    assert!(said.contains("1 events outside the sensor: skipped"), "{said}");
    assert!(said.contains("1 events stood up to 89.995 ms behind later ones: sorted"), "{said}");
}

#[test]
fn what_is_readable_of_a_damaged_file_is_saved_only_when_asked() {
    let sandbox = sandbox();
    sandbox.write("cut.txt", "4 3\n1 1 1 1\n2 1 1 1\n3 1");
    let message = sandbox.fails(&["convert", "cut.txt", "out.txt"]);
    assert!(message.contains("byte 20") && message.contains("2 events readable"), "{message}");
    assert!(!sandbox.path("out.txt").exists());
    let said = sandbox.ok(&["convert", "cut.txt", "out.txt", "--salvage"]);
    assert!(said.contains("the rest is lost") && said.contains("2 events"), "{said}");
}

#[test]
fn a_recording_is_seen_as_a_page_a_sheet_and_an_animation() {
    let sandbox = sandbox();
    let said = sandbox.ok(&["view", "dot.txt", "--out", "view.html", "--frames", "10"]);
    assert!(said.contains("10 frames, one every 49.900 ms up to 0.499 s"), "{said}");
    let page = sandbox.text("view.html");
    assert_eq!(page.matches("iVBORw0KGgo").count(), 11, "every frame, and the one to begin with");
    assert!(page.contains("40x30") && !page.contains("http"), "a page on its own");
    // What its script looks for is there: a name that is not ends the script at the first frame.
    let names: Vec<&str> =
        page.split("at('").skip(1).filter_map(|rest| rest.split('\'').next()).collect();
    assert!(names.len() > 5 && names.contains(&"caption"), "{names:?}");
    for name in names {
        assert!(page.contains(&format!("id=\"{name}\"")), "nothing is called {name}");
    }
    for part in ["ON events<", "OFF events<", "class=\"axis\"", "events/s", "first event, s"] {
        assert!(page.contains(part), "{part}");
    }

    sandbox.ok(&["view", "dot.txt", "--out", "sheet.png", "--of", "eci", "--frames", "5"]);
    let sheet = image::open(sandbox.path("sheet.png")).unwrap();
    // Below each frame is a line of 22 pixels, below the sheet one of 44 with the colours of ON and OFF.
    assert_eq!((sheet.width(), sheet.height()), (4 * 326 + 6, 2 * 268 + 6 + 44));

    sandbox.ok(&["view", "dot.txt", "--out", "dot.apng", "--frames", "7", "--from", "0.1"]);
    let animation = bytes(&sandbox.path("dot.apng"));
    let control = animation.windows(4).position(|part| part == b"acTL").unwrap();
    assert_eq!(animation[control + 4..control + 8], 7u32.to_be_bytes());

    let message = sandbox.fails(&["view", "dot.txt", "--out", "view.mp4"]);
    assert!(message.contains(".html, .png, .apng, .gif or .rrd"), "{message}");
    let message = sandbox.fails(&["view", "dot.txt", "--out", "a.png", "--of", "nonsense"]);
    assert!(message.contains("there are") && message.contains("lnes"), "{message}");
    let message =
        sandbox.fails(&["view", "dot.txt", "--out", "a.png", "--from", "9", "--to", "10"]);
    assert!(message.contains("behind the last event"), "{message}");
}

#[test]
fn a_page_begins_where_most_happens() {
    let sandbox = sandbox();
    // Nine events in one pixel at one time, between two others.
    let mut text = "4 3\n0 1 1 1\n".to_owned();
    for _ in 0..9 {
        text += "700 2 2 1\n";
    }
    sandbox.write("burst.txt", text + "999 1 1 1\n");
    let of_a_frame = ["--frames", "10", "--window-ms", "0.1"];
    sandbox.ok(&[["view", "burst.txt", "--out", "burst.html"], of_a_frame].concat());
    let page = sandbox.text("burst.html");
    assert!(
        page.contains("0.001 s, 9 events") && page.contains("value=\"7\""),
        "the eighth of ten"
    );
}

#[test]
fn sheets_of_wide_frames_have_fewer_columns() {
    let sandbox = sandbox();
    sandbox.ok(&["view", "dot.txt", "--out", "v.png", "--of", "voxel-grid", "--frames", "3"]);
    let sheet = image::open(sandbox.path("v.png")).unwrap();
    let five_bins = 5 * 320 + 4 * 4;
    assert_eq!(sheet.width(), five_bins + 12);
    assert!(sheet.height() > 3 * 240, "one below the other");
}

#[cfg(not(feature = "rerun"))]
#[test]
fn a_build_without_rerun_says_how_to_get_one_with_it() {
    let sandbox = sandbox();
    for place in [["--out", "dot.rrd"].as_slice(), &["--rerun"], &["--rerun=127.0.0.1:9876"]] {
        let message = sandbox.fails(&[&["view", "dot.txt"], place].concat());
        assert!(message.contains("build it with `--features rerun`"), "{message}");
    }
    assert!(!sandbox.path("dot.rrd").exists());
}

#[cfg(feature = "rerun")]
#[test]
fn a_recording_goes_to_a_file_of_rerun_or_says_that_no_viewer_answers() {
    let sandbox = sandbox();
    let said = sandbox.ok(&["view", "dot.txt", "--out", "dot.rrd", "--of", "eros"]);
    assert!(said.contains("dot.rrd: 300 frames"), "{said}");
    assert!(bytes(&sandbox.path("dot.rrd")).starts_with(b"RRF2"));
    let message = sandbox.fails(&["view", "dot.txt", "--rerun=127.0.0.1:1"]);
    assert!(message.contains("the Rerun viewer at rerun+http://127.0.0.1:1/proxy"), "{message}");
}

/// A spot that runs along the rows of a sensor of 40x30, with a hot pixel at (39, 29) and lone
/// events at (38, 3).
fn noisy() -> String {
    let mut text = "40 30\n".to_owned();
    for k in 0..4000 {
        let (t, x, y) = (7_000_000 + 500 * k, k % 36, k / 36 % 26);
        text += &format!("{t} {x} {y} 1\n{t} {x} {} 0\n", y + 1);
        if k % 2 == 0 {
            text += &format!("{t} 39 29 1\n");
        }
        if k % 500 == 0 {
            text += &format!("{t} 38 3 0\n");
        }
    }
    text
}

/// A spot that wanders over a sensor of 40x30 and is ON in one half of it.
fn wandering() -> String {
    let mut text = "40 30\n".to_owned();
    for k in 0..4000 {
        let (t, a) = (7_000_000 + 500 * k, f64::from(k) * 2e-3);
        let (x, y) = ((20.0 + 12.0 * a.sin()) as i32, (14.0 + 9.0 * (1.7 * a).cos()) as i32);
        let p = i32::from(a.cos() > 0.0);
        text += &format!("{t} {x} {y} {p}\n{t} {} {} {p}\n", x + 1, y + k % 3);
    }
    text
}

#[test]
fn a_noisy_recording_is_cleaned_and_its_mask_serves_again() {
    let sandbox = Sandbox::new();
    sandbox.write("noisy.txt", noisy());
    // First without any filter: `clean` alone only looks.
    let checked = sandbox.ok(&["clean", "noisy.txt"]);
    assert!(checked.contains("check     10008 events"), "{checked}");
    assert!(checked.contains("time stamps are multiples of 500"), "{checked}");
    let with = ["--with", "hot", "--with", "background:tau_ms=5", "--masks", "masks"];
    let said = sandbox.ok(&[&["clean", "noisy.txt", "clean.txt"][..], &with].concat());
    assert!(said.contains("hot       removed 2000 of 10008 events"), "{said}");
    assert!(said.contains("1 hot pixels"), "{said}");
    let left = sandbox.text("clean.txt");
    // Neither the hot pixel nor the isolated one is left.
    assert!(!left.contains(" 39 29 "), "{said}");
    assert!(!left.contains(" 38 3 "), "{said}");
    assert!(left.lines().count() > 7800, "{said}");
    let mask = "mask:file=masks/1-hot.toml";
    let said = sandbox.ok(&["clean", "noisy.txt", "masked.txt", "--with", mask]);
    assert!(said.contains("mask      removed 2000 of 10008 events"), "{said}");
    // A misspelt parameter is refused before a file is made.
    let message = sandbox.fails(&["clean", "noisy.txt", "no.txt", "--with", "hot:factr=3"]);
    assert!(message.contains("factor"), "{message}");
    assert!(!sandbox.path("no.txt").exists());
}

#[test]
fn mirrored_columns_are_detected_by_events_of_the_same_scene_and_corrected() {
    let sandbox = Sandbox::new();
    let right = wandering();
    let mirrored: String = right
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            // Columns from the other end, as of a camera behind a mirror.
            [t, x, y, p] => format!("{t} {} {y} {p}\n", 39 - x.parse::<i32>().unwrap()),
            _ => format!("{line}\n"),
        })
        .collect();
    sandbox.write("right.txt", &right);
    sandbox.write("mirrored.txt", mirrored);
    let said = sandbox.ok(&["clean", "mirrored.txt", "back.txt", "--reference", "right.txt"]);
    assert!(said.contains("axes      columns mirrored"), "{said}");
    assert!(bytes(&sandbox.path("back.txt")) == right.into_bytes());
    let said = sandbox.ok(&["clean", "right.txt", "--reference", "right.txt"]);
    assert!(said.contains("as they are"), "{said}");
}

#[test]
fn an_animation_is_a_gif_where_that_is_asked() {
    let sandbox = sandbox();
    sandbox.ok(&["view", "dot.txt", "--out", "dot.gif", "--frames", "6", "--fps", "25"]);
    let file = std::io::BufReader::new(std::fs::File::open(sandbox.path("dot.gif")).unwrap());
    let gif = image::codecs::gif::GifDecoder::new(file).unwrap();
    let frames = image::AnimationDecoder::into_frames(gif).collect_frames().unwrap();
    assert_eq!(frames.len(), 6);
    let delay = std::time::Duration::from(frames[0].delay());
    assert_eq!((delay.as_millis(), frames[0].buffer().dimensions()), (40, (320, 284)));
    // ON is blue, OFF red, as on a sheet.
    let is_near =
        |pixel: &[u8], rgb: [u8; 3]| pixel.iter().zip(rgb).all(|(a, b)| a.abs_diff(b) < 20);
    let has = |rgb| frames[3].buffer().pixels().any(|pixel| is_near(&pixel.0[..3], rgb));
    assert!(has([30, 100, 200]) && has([200, 50, 60]));
    let message = sandbox.fails(&["view", "dot.txt", "--out", "no.gif", "--fps", "60"]);
    assert!(message.contains("at most 50 frames a second"), "{message}");
}

/// Exit code and the command that `evpose check` says to go on with.
fn checked(sandbox: &Sandbox, file: &str, text: &str) -> (Option<i32>, String) {
    sandbox.write(file, text);
    let (code, said) = sandbox.ends(&["check", file]);
    let next = said.lines().find_map(|line| line.trim_start().strip_prefix("next"));
    (code, next.unwrap_or_else(|| panic!("{said}")).trim().to_owned())
}

#[test]
fn check_says_whether_a_recording_can_be_used_and_what_comes_next() {
    let sandbox = sandbox();
    let dot = sandbox.text("dot.txt");
    let infer = "evpose infer --checkpoint body --events a.txt --out poses.csv";
    assert_eq!(checked(&sandbox, "a.txt", &dot), (Some(0), infer.to_owned()));
    // Three pixels that have an event every 100 us.
    let hot = (0..15_000).map(|k| format!("{} {} 3 1\n", 1_000_000 + 100 * (k / 3), 35 + k % 3));
    let mut lines: Vec<String> = dot.lines().skip(1).map(|line| format!("{line}\n")).collect();
    lines.extend(hot);
    lines.sort_by_key(|line| line.split(' ').next().unwrap().parse::<i64>().unwrap());
    let hot = "40 30\n".to_owned() + &lines.concat();
    let clean = "evpose clean b.txt clean.npz --with hot";
    assert_eq!(checked(&sandbox, "b.txt", &hot), (Some(10), clean.to_owned()));
    let stopped = "40 30\n5 1 2 1\n5 3 4 0\n";
    assert_eq!(checked(&sandbox, "c.txt", stopped), (Some(11), "evpose info c.txt".to_owned()));
}
