//! The published emulator of v2e, event for event.
//!
//! Golden values: `EventEmulator` of v2e 1.5.1 (commit cac6384, torch 2.15.0 on the CPU) was shown
//! the frames of [`frame`] in code values at 1000 frames per second, its thresholds replaced after
//! the first frame by those of [`thresholds`], `noise_rate_cov_decades` and `leak_jitter_fraction`
//! zero. Per setting: ON events, OFF events, and FNV-1a over the little-endian 16-bit counts ON and
//! OFF of every pixel, row by row.

use std::path::{Path, PathBuf};

use evpose_core::{Micros, Plane, SensorSize};
use evpose_sensor::{EffectConfig, Origin, SensorConfig, SensorError, SensorModel};
use npyz::WriterBuilder;

use crate::support::*;

const SIZE: SensorSize = SensorSize { width: 64, height: 48 };
const FRAMES: i64 = 200;

/// Up and down between 0 and `half`.
fn triangle(a: i64, half: i64) -> i64 {
    (a.rem_euclid(2 * half) - half).abs()
}

/// Code values of a textured disc that crosses a moving pattern, partly below the knee of the
/// linear-logarithmic law.
fn frame(k: i64, x: i64, y: i64) -> i64 {
    let ground = 6 + triangle(5 * x + 3 * k, 70) + triangle(7 * y - 2 * k, 50) / 2;
    let (cx, cy) = (256 + triangle(9 * k, 512), 256 + triangle(5 * k, 240));
    let (dx, dy) = (16 * x - cx, 16 * y - cy);
    if dx * dx + dy * dy < 192 * 192 {
        ground / 3 + 110 + triangle(11 * x + 13 * y + 4 * k, 60)
    } else {
        ground
    }
}

fn plane(k: i64) -> Plane<f32> {
    let mut plane = Plane::for_sensor(SIZE, 0.0);
    for (i, y) in (0..).zip(plane.data_mut()) {
        *y = frame(k, i % 64, i / 64) as f32 / 255.0;
    }
    plane
}

fn write_map(path: &Path, size: SensorSize, value: impl Fn(usize) -> f32) -> PathBuf {
    let shape = [u64::from(size.height), u64::from(size.width)];
    let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
    let mut npy = options.writer(std::fs::File::create(path).unwrap()).begin_nd().unwrap();
    npy.extend((0..size.pixels()).map(value)).unwrap();
    npy.finish().unwrap();
    path.to_owned()
}

/// Thresholds of every pixel as files: ON and OFF.
fn thresholds(folder: &Path) -> EffectConfig {
    let on = |p: usize| (150 + p * 7_919 % 101) as f32 / 1000.0;
    let off = |p: usize| (160 + p * 104_729 % 83) as f32 / 1000.0;
    let on = write_map(&folder.join("on.npy"), SIZE, on);
    let off = write_map(&folder.join("off.npy"), SIZE, off);
    let pattern = effect("fixed_pattern").with("threshold_on", on.to_str().unwrap());
    pattern.with("threshold_off", off.to_str().unwrap())
}

/// Counts and their digest with these effects beside those of the preset.
fn counts(effects: &[EffectConfig]) -> (u64, u64, u64) {
    let folder = tempfile::tempdir().unwrap();
    let mut config = SensorConfig::preset("v2e-clean").unwrap();
    config.effects.extend_from_slice(effects);
    config.effects.push(thresholds(folder.path()));
    let mut run = SensorModel::from_config(&config).unwrap().start(SIZE, 1);
    let mut counts = vec![[0u16; 2]; SIZE.pixels()];
    for k in 0..FRAMES {
        for event in run.expose(&plane(k), Micros(k * 1000)).unwrap().iter() {
            let pixel = usize::from(event.y) * 64 + usize::from(event.x);
            counts[pixel][usize::from(!event.polarity.is_on())] += 1;
        }
    }
    let total = |which: usize| counts.iter().map(|pixel| u64::from(pixel[which])).sum();
    let bytes = counts.iter().flatten().flat_map(|count| count.to_le_bytes());
    let digest = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    (total(0), total(1), digest)
}

/// v2e's 100 Hz times (x + 20) / 275 of the code value x.
fn lowpass() -> EffectConfig {
    let lowpass = effect("photoreceptor_lowpass").with("cutoff_hz", 100.0 * 255.0 / 275.0);
    lowpass.with("dark_light", 20.0 / 255.0).with("step", "euler")
}

fn refractory() -> EffectConfig {
    effect("refractory").with("period_us", 500.0).with("mode", "defer")
}

fn leak(rate_hz: f64) -> EffectConfig {
    effect("leak_on").with("rate_hz", rate_hz).with("phase", "aligned")
}

#[test]
fn counts_are_those_published() {
    for (effects, expected) in [
        (vec![], (115_549, 115_357, 0xe12c_8331_bd6f_7f33)),
        (vec![lowpass()], (57_327, 56_209, 0xf6fc_2260_27a0_cd1b)),
        // Half a millisecond at 1000 frames per second: ties that rounding decides.
        (vec![refractory()], (99_666, 99_730, 0x580b_b213_ef1d_4c33)),
        // Without the low-pass, v2e keeps its memory in single precision: rounding makes the smaller
        // leak up to a hundredth larger or smaller.
        (vec![leak(2.0)], (116_232, 114_783, 0xfc2e_61d5_7e8b_aca2)),
        (vec![leak(0.1)], (115_575, 115_324, 0x1390_1b61_687c_9cfe)),
        // Bursts of which a part is lost leave the memory in single precision as well.
        (vec![leak(2.0), refractory()], (100_483, 99_275, 0xa9dd_465a_ebc6_0ad5)),
        (vec![lowpass(), refractory(), leak(2.0)], (57_787, 55_621, 0xf0ef_ba59_3c9d_c215)),
    ] {
        assert_eq!(counts(&effects), expected, "{effects:?}");
    }
}

/// v2e has neither intervals that scatter nor a leak by light; they go the same way.
#[test]
fn rounding_as_published_changes_leaks_of_all_kinds_by_little() {
    let at_rest = |rounding: &str, leak: &EffectConfig| {
        let mut config = SensorConfig::preset("v2e-clean").unwrap();
        let detector = config.effects.iter_mut().find(|e| e.name == "frame_count").unwrap();
        *detector = detector.clone().with("rounding", rounding);
        config.effects.push(leak.clone());
        let mut run = SensorModel::from_config(&config).unwrap().start(SIZE, 1);
        run.label_origins(true);
        let mut count = 0;
        for k in 0..1_000 {
            count += run.expose(&plane(0), Micros(k * 1000)).unwrap().len();
            assert!(run.origins().unwrap().iter().all(|origin| *origin == Origin::Leak));
        }
        count as f64
    };
    let leaks = [
        leak(5.0),
        leak(5.0).with("phase", "random").with("jitter", 0.2),
        leak(5.0).with("frame_jitter", 0.1),
        effect("parasitic_photo_leak").with("hz_per_white", 20.0),
    ];
    for leak in leaks {
        let exact = at_rest("exact", &leak);
        assert!(exact > 3_000.0, "{leak:?}: {exact}");
        assert_near(at_rest("published", &leak), exact, 0.01 * exact);
    }
}

#[test]
fn a_file_that_is_no_map_of_thresholds_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let message = |key: &str, path: &Path| {
        let pattern = effect("fixed_pattern").with(key, path.to_str().unwrap());
        SensorModel::from_config(&SensorConfig { effects: vec![pattern] }).unwrap_err().to_string()
    };
    assert!(message("threshold_on", &at("none.npy")).contains("none.npy: cannot be read"));
    let low = write_map(&at("low.npy"), SIZE, |p| if p == 65 { 0.001 } else { 0.2 });
    let found = message("threshold_off", &low);
    assert!(found.contains("threshold_off") && found.contains("pixel (1, 1)"), "{found}");
    let cut = std::fs::read(&low).unwrap();
    std::fs::write(at("cut.npy"), &cut[..cut.len() - 1]).unwrap();
    assert!(message("leak_hz", &at("cut.npy")).contains("cut.npy: cannot be read"));
    let other = write_map(&at("other.npy"), size(3, 2), |_| 0.3);
    let pattern = effect("fixed_pattern").with("threshold_off", other.to_str().unwrap());
    let config = SensorConfig { effects: vec![pattern.clone()] };
    let mut run = SensorModel::from_config(&config).unwrap().start(SIZE, 1);
    let refused = run.expose(&plane(0), Micros(0)).unwrap_err().to_string();
    assert!(refused.contains("3x2") && refused.contains("64x48"), "{refused}");
    let on = write_map(&at("on.npy"), SIZE, |_| 0.3);
    let both = pattern.with("threshold_on", on.to_str().unwrap());
    let refused = SensorModel::from_config(&SensorConfig { effects: vec![both] });
    assert!(matches!(refused, Err(SensorError::Map { key: "threshold_off", .. })));
}
