//! Frames to events on the command line.

use image::{GrayImage, ImageBuffer, Luma};

use crate::harness::{Sandbox, bytes, stderr};

const WIDTH: u32 = 24;
const HEIGHT: u32 = 16;
const FRAMES: u32 = 12;

/// A bright square that moves over a dark ground.
fn code(frame: u32, x: u32, y: u32) -> u8 {
    let is_inside = x.abs_diff(4 + frame) < 4 && y.abs_diff(8) < 4;
    if is_inside { 180 + (3 * y) as u8 } else { 40 + (2 * x) as u8 }
}

fn frame(index: u32) -> GrayImage {
    GrayImage::from_fn(WIDTH, HEIGHT, |x, y| Luma([code(index, x, y)]))
}

/// An array as NumPy writes it.
fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    [b"\x93NUMPY\x01\x00\x76\x00", format!("{header:<117}\n").as_bytes(), data].concat()
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("images")).unwrap();
    let mut all = Vec::new();
    for index in 0..FRAMES {
        // Names in natural order only: 0.png to 11.png.
        frame(index).save(sandbox.path(&format!("images/{index}.png"))).unwrap();
        all.extend_from_slice(frame(index).as_raw());
    }
    let shape = format!("({FRAMES}, {HEIGHT}, {WIDTH})");
    sandbox.write("frames.npy", npy("|u1", &shape, &all));
    sandbox
}

fn args<'a>(frames: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let usual =
        ["events", "--frames", frames, "--fps", "500", "--sensor", "v2e-noisy", "--out", out];
    usual.iter().chain(more).copied().collect()
}

#[test]
fn images_and_arrays_of_the_same_frames_give_the_same_bytes() {
    let sandbox = sandbox();
    let said = sandbox.ok(&args("images", "a.npz", &[]));
    for part in ["12 of 24x16", "linear", "white at 255", " ON, ", "steps/s", "a.npz.toml"] {
        assert!(said.contains(part), "{part}:\n{said}");
    }
    sandbox.ok(&args("frames.npy", "b.npz", &[]));
    assert!(bytes(&sandbox.path("a.npz")) == bytes(&sandbox.path("b.npz")));
    // Another seed must change something, or it is ignored.
    sandbox.ok(&args("images", "c.npz", &["--seed", "5"]));
    assert!(bytes(&sandbox.path("a.npz")) != bytes(&sandbox.path("c.npz")));
    let info = sandbox.ok(&["info", "a.npz"]);
    assert!(info.contains("24x16"), "{info}");
    let how = sandbox.text("a.npz.toml");
    let how: toml::Table = how.parse().unwrap();
    assert_eq!(how["frames"]["fps"].as_float(), Some(500.0));
    assert_eq!(how["sensor"]["effect"][0]["name"].as_str(), Some("lin_log"));
}

#[test]
fn white_and_depth_do_not_matter_where_light_is_the_same() {
    let sandbox = sandbox();
    std::fs::create_dir(sandbox.path("deep")).unwrap();
    for index in 0..FRAMES {
        let deep = |x, y| Luma([16 * u16::from(code(index, x, y))]);
        let image = ImageBuffer::<Luma<u16>, Vec<u16>>::from_fn(WIDTH, HEIGHT, deep);
        image.save(sandbox.path(&format!("deep/{index}.png"))).unwrap();
    }
    sandbox.ok(&args("images", "a.txt", &[]));
    sandbox.ok(&args("deep", "b.txt", &["--white", "4080"]));
    assert!(bytes(&sandbox.path("a.txt")) == bytes(&sandbox.path("b.txt")));
    sandbox.ok(&args("images", "c.txt", &["--encoding", "srgb"]));
    assert!(bytes(&sandbox.path("a.txt")) != bytes(&sandbox.path("c.txt")));
}

#[test]
fn a_map_of_thresholds_takes_the_place_of_those_of_the_sensor() {
    let sandbox = sandbox();
    let map: Vec<u8> = (0..WIDTH * HEIGHT).flat_map(|_| 3f32.to_le_bytes()).collect();
    let shape = format!("({HEIGHT}, {WIDTH})");
    sandbox.write("high.npy", npy("<f4", &shape, &map));
    let clean = |out, more: &[&str]| {
        let usual = ["events", "--frames", "images", "--fps", "500", "--sensor", "v2e-clean"];
        sandbox.ok(&[&usual[..], &["--out", out], more].concat())
    };
    assert!(!clean("a.npz", &[]).contains("events    0:"));
    // No contrast of the scene is an e-fold of three.
    let said = clean("b.npz", &["--threshold-map", "high.npy"]);
    assert!(said.contains("events    0:"), "{said}");
    sandbox.write("low.npy", npy("<f4", "(1, 1)", &0.2f32.to_le_bytes()));
    let wrong = args("images", "c.npz", &["--threshold-map", "low.npy"]);
    let message = sandbox.fails(&wrong);
    assert!(message.contains("1x1") && message.contains("24x16"), "{message}");
}

#[test]
fn steps_between_frames_make_events_between_frames() {
    let sandbox = sandbox();
    let times = |out: &str, more: &[&str]| {
        let sensor = ["--sensor", "eventhands"];
        let usual = ["events", "--frames", "images", "--fps", "100", "--out", out];
        sandbox.ok(&[&usual[..], &sensor, more].concat());
        let text = sandbox.text(out);
        let times = text.lines().skip(1).map(|line| line.split(' ').next().unwrap().to_owned());
        times.map(|t| t.parse::<i64>().unwrap()).collect::<Vec<_>>()
    };
    assert!(times("a.txt", &[]).iter().all(|t| t % 10_000 == 0));
    let fine = times("b.txt", &["--upsample", "4"]);
    assert!(fine.iter().all(|t| t % 2_500 == 0) && fine.iter().any(|t| t % 10_000 != 0));
}

#[test]
fn what_is_wrong_is_said_before_anything_is_written() {
    let sandbox = sandbox();
    let message = |args: &[&str]| sandbox.fails(args);
    assert!(message(&args("images", "a.jpg", &[])).contains(".npz"));
    assert!(message(&args("nowhere", "a.npz", &[])).contains("nowhere"));
    // The config that a run writes beside its events is no sensor of the same run.
    sandbox.write("a.npz.toml", "");
    let again = ["events", "--frames", "images", "--fps", "100", "--sensor", "a.npz.toml"];
    let again = message(&[&again[..], &["--out", "a.npz"]].concat());
    assert!(again.contains("a.npz.toml: is read, and written"), "{again}");
    std::fs::remove_file(sandbox.path("a.npz.toml")).unwrap();
    std::fs::create_dir(sandbox.path("empty")).unwrap();
    assert!(message(&args("empty", "a.npz", &[])).contains("no .png"));
    // One byte short: the last frame is cut.
    let cut = bytes(&sandbox.path("frames.npy"));
    sandbox.write("cut.npy", &cut[..cut.len() - 1]);
    assert!(message(&args("cut.npy", "a.npz", &[])).contains("11 of its 12 frames"));
    // An image of another size among the frames.
    GrayImage::new(3, 3).save(sandbox.path("images/3.png")).unwrap();
    let found = message(&args("images", "a.npz", &[]));
    assert!(found.contains("3.png") && found.contains("3x3"), "{found}");
    // Found before writing: no file is left half written.
    assert!(!sandbox.path("a.npz").exists() && !sandbox.path("a.npz.toml").exists());
}

/// A peer that says how many frames there are, which takes the place of its time.
#[cfg(unix)]
#[test]
fn the_sensor_bench_times_peers_on_its_frames() {
    let sandbox = Sandbox::new();
    sandbox.write("peer.sh", "test -s $1 && echo measuring $3 && echo $2\n");
    let peer = "other=sh peer.sh {frames} {fps} {setting}";
    let said = sandbox.run("bench sensor --seconds 0.05 --json sensor.json", &["--peer", peer]);
    // The peer answers 1000, the rate of its frames, in place of a time.
    assert!(said.contains("other") && said.contains("1000.00 ns"), "{said}");
    let report = sandbox.json("sensor.json");
    for (index, setting) in ["thresholds", "all"].into_iter().enumerate() {
        let measured = &report["settings"][index];
        assert_eq!(measured["setting"], setting);
        assert_eq!(measured["peers"][0]["ns"], 1000.0);
        assert!(measured["median_ns"].as_f64().is_some_and(|ns| ns > 0.0));
    }
}

/// Frames of 8 bits in other clothes: as floating-point values, as a Y4M and as a GIF.
#[test]
fn floats_of_bytes_and_videos_give_the_events_of_their_images() {
    let sandbox = sandbox();
    let codes: Vec<u8> = (0..FRAMES).flat_map(|index| frame(index).into_raw()).collect();
    let floats: Vec<u8> = codes.iter().flat_map(|code| f32::from(*code).to_le_bytes()).collect();
    let shape = format!("({FRAMES}, {HEIGHT}, {WIDTH})");
    sandbox.write("floats.npy", npy("<f4", &shape, &floats));
    let mut video = format!("YUV4MPEG2 W{WIDTH} H{HEIGHT} F500:1 Cmono\n").into_bytes();
    for planes in codes.chunks((WIDTH * HEIGHT) as usize) {
        video.extend_from_slice(b"FRAME\n");
        video.extend_from_slice(planes);
    }
    sandbox.write("clip.y4m", video);
    let file = std::fs::File::create(sandbox.path("clip.gif")).unwrap();
    let mut encoder = image::codecs::gif::GifEncoder::new(file);
    for index in 0..FRAMES {
        let image = image::DynamicImage::from(frame(index)).into_rgba8();
        let delay = image::Delay::from_numer_denom_ms(40, 1);
        encoder.encode_frame(image::Frame::from_parts(image, 0, 0, delay)).unwrap();
    }
    drop(encoder);
    fn line<'a>(frames: &'a str, out: &'a str) -> [&'a str; 7] {
        ["events", "--frames", frames, "--sensor", "v2e-clean", "--out", out]
    }
    let at = |frames: &'static str, fps: &'static str, out: &'static str| {
        sandbox.ok(&[&line(frames, out)[..], &["--fps", fps]].concat())
    };
    at("images", "500", "images.txt");
    let said = at("floats.npy", "500", "floats.txt");
    assert!(said.contains("`white` is not stated: it is taken to be 255"), "{said}");
    // Their own times.
    sandbox.ok(&line("clip.y4m", "y4m.txt"));
    let images = bytes(&sandbox.path("images.txt"));
    assert!(bytes(&sandbox.path("floats.txt")) == images);
    assert!(bytes(&sandbox.path("y4m.txt")) == images);
    at("images", "25", "slow.txt");
    sandbox.ok(&line("clip.gif", "gif.txt"));
    assert!(bytes(&sandbox.path("gif.txt")) == bytes(&sandbox.path("slow.txt")));
}

/// A program in place of ffmpeg: the same words about the same frames, at uneven times.
#[cfg(unix)]
#[test]
fn frames_of_a_video_have_the_times_that_it_states() {
    use std::os::unix::fs::PermissionsExt as _;

    let sandbox = sandbox();
    let programs = sandbox.path("programs");
    std::fs::create_dir(&programs).unwrap();
    let mut pixels = Vec::new();
    let mut said = "Input #0, avi\n".to_owned();
    for index in 0..FRAMES {
        // Every second pause is three times as long.
        let time_s = 7.0 + 0.02 * f64::from(index) + 0.02 * f64::from(index / 2);
        said += &format!(
            "[Parsed_showinfo_0 @ 0x5] n:{index} pts:{index} pts_time:{time_s} fmt:rgb24 s:{WIDTH}x{HEIGHT}\n"
        );
        pixels.extend(frame(index).as_raw().iter().flat_map(|code| [*code; 3]));
    }
    sandbox.write("said", said);
    sandbox.write("pixels", pixels);
    sandbox.write("clip.avi", "a video");
    let script =
        "#!/bin/sh\ncase \"$*\" in *showinfo*) /bin/cat said >&2 ;; *) /bin/cat pixels ;; esac\n";
    let program = programs.join("ffmpeg");
    std::fs::write(&program, script).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();

    let line = ["events", "--frames", "clip.avi", "--sensor", "eventhands", "--out", "clip.txt"];
    let run = |path: &std::path::Path, more: &[&str]| {
        sandbox.evpose(&[&line[..], more].concat()).env("PATH", path).output().unwrap()
    };
    let output = run(&programs, &[]);
    assert!(output.status.success(), "{}", stderr(&output));
    let times = |name: &str| {
        let text = sandbox.text(name);
        let times = text.lines().skip(1).map(|line| line.split(' ').next().unwrap().to_owned());
        let mut times: Vec<i64> = times.map(|t| t.parse().unwrap()).collect();
        times.dedup();
        times
    };
    let stated: Vec<i64> = (0..12).map(|n| 20_000 * (n + n / 2)).collect();
    assert_eq!(times("clip.txt"), stated);
    // A rate that is given wins; the pixels are those of the images.
    assert!(run(&programs, &["--fps", "1000"]).status.success());
    let video = bytes(&sandbox.path("clip.txt"));
    let of_images = "events --frames images --fps 1000 --sensor eventhands --out images.txt";
    sandbox.run(of_images, &[]);
    assert_eq!(video, bytes(&sandbox.path("images.txt")));

    // Without the program, with one that fails, and with frames that end too early.
    let output = run(&sandbox.path("images"), &[]);
    assert!(
        !output.status.success() && stderr(&output).contains("install it"),
        "{}",
        stderr(&output)
    );
    sandbox.write("pixels", "too few");
    let output = run(&programs, &[]);
    assert!(stderr(&output).contains("frame 0 of 12"), "{}", stderr(&output));
    std::fs::write(&program, "#!/bin/sh\necho 'clip.avi: Invalid data found' >&2\nexit 1\n")
        .unwrap();
    let output = run(&programs, &[]);
    assert!(stderr(&output).contains("Invalid data"), "{}", stderr(&output));
}
