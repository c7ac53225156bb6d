//! Camera parameters, from frames and events that another command makes.

use crate::harness::{Sandbox, bytes};

const WIDTH: usize = 32;
const HEIGHT: usize = 24;
const FRAMES: usize = 400;

/// A wave of light that moves to and fro, as f32.
fn light() -> Vec<u8> {
    let value = |k: usize, x: usize, y: usize| {
        // To and fro, so that both polarities come everywhere.
        let shift = 9.0 * (0.012 * k as f32).sin();
        let wave = (0.4 * (x as f32 - shift)).sin() * (0.3 * y as f32).cos();
        0.3 * (0.9 * wave).exp()
    };
    let mut all = Vec::new();
    for k in 0..FRAMES {
        for i in 0..WIDTH * HEIGHT {
            all.extend(value(k, i % WIDTH, i / WIDTH).to_le_bytes());
        }
    }
    let shape = format!("({FRAMES}, {HEIGHT}, {WIDTH})");
    // The header is padded to a multiple of 64 bytes, as NumPy does.
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
    [b"\x93NUMPY\x01\x00\x76\x00", format!("{header:<117}\n").as_bytes(), &all].concat()
}

/// Events of a camera with these effects.
fn recorded(sandbox: &Sandbox, frames: &[u8], fps: &str, effects: &str) {
    std::fs::write(sandbox.path("frames.npy"), frames).unwrap();
    std::fs::write(sandbox.path("camera.toml"), effects).unwrap();
    let to = ["events", "--frames", "frames.npy", "--fps", fps, "--out", "rec.npz"];
    sandbox.ok(&[&to[..], &["--sensor", "camera.toml"]].concat());
}

/// The number behind a word of a line.
fn number(said: &str, line: &str, word: &str) -> f64 {
    let line = said.lines().find(|l| l.contains(line)).unwrap();
    let mut words = line.split_whitespace().skip_while(|w| *w != word).skip(1);
    words.next().unwrap().parse().unwrap()
}

const PIXEL: &str = "[[effect]]\nname = 'logarithmic'\ndark_offset = 1e-6\n
[[effect]]\nname = 'level_crossing'\nthreshold_on = 0.15\nthreshold_off = 0.22\n";

#[test]
fn thresholds_come_back_and_make_a_sensor() {
    let sandbox = Sandbox::new();
    recorded(&sandbox, &light(), "1000", PIXEL);
    let args = ["calibrate", "threshold", "--events", "rec.npz", "--frames", "frames.npy"];
    let said = sandbox.ok(&[&args[..], &["--fps", "1000", "--out", "found.toml"]].concat());
    assert!((number(&said, "by steps", "ON") - 0.15).abs() < 0.002, "{said}");
    assert!(said.contains("OFF 0.22") || said.contains("OFF 0.219"), "{said}");
    let shown = sandbox.ok(&["sensor", "show", "found.toml"]);
    assert!(shown.contains("level_crossing"), "{shown}");
    let never = sandbox.fails(&[&args[..], &["--fps", "1e9"]].concat());
    assert!(never.contains("--fps"), "{never}");
}

#[test]
fn frames_of_a_video_are_at_the_times_that_it_states() {
    let sandbox = Sandbox::new();
    let light = light();
    let codes = light[128..].as_chunks::<4>().0.iter();
    let codes: Vec<u8> = codes.map(|y| (255.0 * f32::from_le_bytes(*y)).round() as u8).collect();
    let mut video = format!("YUV4MPEG2 W{WIDTH} H{HEIGHT} F1000:1 Cmono\n").into_bytes();
    for frame in codes.chunks(WIDTH * HEIGHT) {
        video.extend_from_slice(b"FRAME\n");
        video.extend_from_slice(frame);
    }
    std::fs::write(sandbox.path("clip.y4m"), video).unwrap();
    std::fs::write(sandbox.path("camera.toml"), PIXEL).unwrap();
    let events = ["events", "--frames", "clip.y4m", "--sensor", "camera.toml", "--out", "rec.npz"];
    sandbox.ok(&events);
    let args = ["calibrate", "threshold", "--events", "rec.npz", "--frames", "clip.y4m"];
    let at = |fps| sandbox.ok(&[&args[..], &["--fps", fps]].concat());
    let stated = sandbox.ok(&args);
    assert_eq!(stated, at("1000"));
    assert_ne!(stated, at("700"));
}

#[test]
fn rates_come_back_and_hot_pixels_are_listed() {
    let sandbox = Sandbox::new();
    let moving = light();
    // One frame over and over.
    let (head, frame) = (&moving[..128], &moving[128..128 + 4 * WIDTH * HEIGHT]);
    let still = [head, &frame.repeat(FRAMES)].concat();
    let noise = "\n[[effect]]\nname = 'uniform_noise'\non_hz = 8.0\noff_hz = 2.0\n
[[effect]]\nname = 'hot_pixels'\nfraction = 0.004\nmedian_hz = 2000.0\non_share = 0.5\n";
    recorded(&sandbox, &still, "200", &format!("{PIXEL}{noise}"));
    let args = ["calibrate", "noise", "--events", "rec.npz", "--out", "n.toml", "--hot", "hot.csv"];
    let said = sandbox.ok(&args);
    let on = number(&said, "ON  ", "ON");
    assert!((on / 8.0 - 1.0).abs() < 0.05, "{said}");
    let table = String::from_utf8(bytes(&sandbox.path("hot.csv"))).unwrap();
    assert!(table.starts_with("x,y,on_hz,off_hz\n") && table.lines().count() > 1, "{table}");
    assert!(sandbox.ok(&["sensor", "show", "n.toml"]).contains("uniform_noise"));
    let skip = |seconds| ["calibrate", "noise", "--events", "rec.npz", "--skip", seconds];
    let short = sandbox.ok(&skip("1.5"));
    assert!((number(&short, "ON  ", "ON") / 8.0 - 1.0).abs() < 0.1, "{short}");
    assert!(short.contains("are short"), "{short}");
    let late = sandbox.fails(&skip("60"));
    assert!(late.contains("--skip") && late.contains("rec.npz"), "{late}");
}
