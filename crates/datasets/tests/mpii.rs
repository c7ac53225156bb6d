//! MPII's layout into images of persons, against what the published program makes of it.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use evpose_core::{Plane, seed_for};
use evpose_datasets::mpii::convert;
use evpose_datasets::stills::{CropFormat, SkipReason, StillOptions, StillStyle};
use evpose_datasets::{Annotation, read_annotations};
use evpose_pose::body::{Visibility, number};
use evpose_repr::ErosLike;
use glam::Vec2;
use tempfile::TempDir;

const SIZES: [(&str, usize, u32, u32); 8] = [
    ("a.png", 0, 64, 48),
    ("b.b.png", 1, 80, 60),
    ("c.png", 2, 40, 40),
    ("d.png", 3, 40, 40),
    ("f.png", 5, 50, 40),
    ("h.png", 7, 70, 50),
    ("i.png", 8, 50, 40),
    ("j.png", 9, 50, 40),
];

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/mpii").join(name)
}

fn pixels(photograph: usize, width: u32, height: u32) -> Vec<u8> {
    let pixel = |x, y| ((7 * x + 11 * y + x * y / 5 + 31 * photograph as u32) % 256) as u8;
    (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect()
}

/// A folder with the photographs, and options that write beside them.
fn set() -> (TempDir, StillOptions) {
    let directory = tempfile::tempdir().unwrap();
    let photographs = directory.path().join("photographs");
    std::fs::create_dir(&photographs).unwrap();
    for (name, index, width, height) in SIZES {
        let image = image::GrayImage::from_raw(width, height, pixels(index, width, height));
        image.unwrap().save(photographs.join(name)).unwrap();
    }
    let output = directory.path().join("out");
    let options = StillOptions {
        style: StillStyle::Grey,
        ..StillOptions::new(golden("release.mat"), photographs, output)
    };
    (directory, options)
}

fn labels(options: &StillOptions) -> BTreeMap<String, Annotation> {
    let annotations = read_annotations(&options.output.join("poses.json")).unwrap();
    annotations.into_iter().map(|annotation| (annotation.image.clone(), annotation)).collect()
}

fn crop(options: &StillOptions, name: &str) -> image::GrayImage {
    image::open(options.output.join("images").join(name)).unwrap().into_luma8()
}

/// Every file of a folder and its bytes.
fn files(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            let bytes = std::fs::read(&path).unwrap();
            found.insert(path, bytes);
        }
    }
    found
}

fn close(a: Vec2, b: Vec2) -> bool {
    a.abs_diff_eq(b, 1e-6)
}

#[test]
fn with_parity_labels_and_images_are_those_of_the_published_program() {
    let (_directory, mut options) = set();
    options.parity = true;
    let converted = convert(&options, &|_, _| {}).unwrap();
    let want = read_annotations(&golden("poses.json")).unwrap();
    assert_eq!((converted.persons, converted.images), (4, 3));
    let ours = labels(&options);
    assert_eq!(ours.len(), want.len());
    for want in want {
        let (name, want) = (want.image, want.label);
        let ours = &ours[&name].label;
        for (joint, (ours, want)) in ours.keypoints.iter().zip(&want.keypoints).enumerate() {
            assert!(close(ours.position, want.position), "{name} {joint}");
            assert_eq!(ours.visibility, want.visibility, "{name} {joint}");
        }
        assert!(close(ours.center, want.center), "{name}");
        let sizes = |label: &evpose_pose::body::BodyLabel| {
            Vec2::new(label.head_size.unwrap(), label.head_size_scaled.unwrap())
        };
        assert!(sizes(ours).abs_diff_eq(sizes(&want), 1e-5), "{name}");
        let points = |label: &evpose_pose::body::BodyLabel| {
            let joints = label.other_keypoints.iter().flatten();
            joints.chain(&label.other_centers).copied().collect::<Vec<_>>()
        };
        let counts = |label: &evpose_pose::body::BodyLabel| {
            label.other_keypoints.iter().map(Vec::len).collect::<Vec<_>>()
        };
        assert_eq!(counts(ours), counts(&want), "{name}");
        assert!(points(ours).iter().zip(&points(&want)).all(|(a, b)| close(*a, *b)), "{name}");
    }
    for (name, size, crc) in [
        ("a_0.png", (77, 78), 0x96ff_0eff),
        ("b.b_0.png", (74, 75), 0x299d_6765),
        ("b.b_1.png", (75, 74), 0xee3b_868e),
        ("h_0.png", (40, 39), 0xb5d4_dfab_u32),
    ] {
        let image = crop(&options, name);
        let mut sum = flate2::Crc::new();
        sum.update(image.as_raw());
        assert_eq!((image.dimensions(), sum.sum()), (size, crc), "{name}");
    }
    let skipped = converted.skipped_by_reason();
    assert_eq!(skipped[&SkipReason::NoVisibility], 1);
    // The person of c.png beside whom somebody has no points.
    assert_eq!(skipped[&SkipReason::IncompleteCompanion], 1);
}

#[test]
fn valid_persons_are_converted_and_the_rest_is_reported() {
    let (_directory, options) = set();
    let converted = convert(&options, &|_, _| {}).unwrap();
    let ours = labels(&options);
    let names: Vec<&str> = ours.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        ["a_0.png", "b.b_0.png", "b.b_1.png", "c_0.png", "h_0.png", "i_0.png", "j_0.png"]
    );
    assert_eq!((converted.persons, converted.images, converted.not_for_training), (7, 6, 1));
    let skipped: Vec<_> =
        converted.skipped.iter().map(|s| (s.image.as_str(), s.person, s.reason)).collect();
    assert_eq!(
        skipped,
        [
            ("c.png", Some(1), SkipReason::NoPoints),
            ("d.png", None, SkipReason::NoPersons),
            ("f.png", Some(0), SkipReason::NoExtent),
            ("g.png", None, SkipReason::NoImage),
            ("j.png", Some(1), SkipReason::NoCenter),
        ]
    );
    let report = std::fs::read_to_string(options.output.join("conversion.json")).unwrap();
    assert!(report.contains("no_center"), "{report}");
    assert!(converted.to_string().starts_with("7 persons of 6 photographs"), "{converted}");

    // Nobody else has joints beside c_0, but a middle.
    let c = &ours["c_0.png"].label;
    assert_eq!((c.other_centers.len(), c.other_keypoints.iter().flatten().count()), (1, 0));
    // The head of h_0 is above its image.
    let h = &ours["h_0.png"].label.keypoints;
    assert_eq!(h[number::HEAD].visibility, Visibility::Unlabelled);
    assert_eq!(h[number::HEAD].position, Vec2::ZERO);
    // Part 1 there is '1', a text.
    assert_eq!(h[number::KNEE_R].visibility, Visibility::Visible);
    let i = &ours["i_0.png"].label.keypoints;
    assert!(i[1..].iter().all(|joint| joint.visibility == Visibility::Hidden));
}

#[test]
fn persons_are_cut_out_of_the_whole_photograph_in_its_style() {
    let (_directory, mut options) = set();
    convert(&options, &|_, _| {}).unwrap();
    let grey = crop(&options, "i_0.png");
    options.style = StillStyle::ErosLike(ErosLike::default());
    options.output = options.output.with_file_name("eros");
    options.seed = 5;
    convert(&options, &|_, _| {}).unwrap();
    let ours = crop(&options, "i_0.png");
    let photograph = Plane::from_vec(50, 40, pixels(8, 50, 40)).unwrap();
    let image = ErosLike::default().convert(&photograph, seed_for(5, "mpii", 8));
    assert_eq!(ours.dimensions(), grey.dimensions());
    // Points from (8, 8), 22.5 pixels wide and 26.25 high: half a side is 24.375, the middle (19.25, 21.125).
    let (left, top) = (-5, -3);
    for (x, y, pixel) in ours.enumerate_pixels() {
        let (x, y) = (x as i32 + left, y as i32 + top);
        let inside = (0..50).contains(&x) && (0..40).contains(&y);
        let want = if inside { *image.at(x as usize, y as usize) } else { 0 };
        assert_eq!(pixel.0[0], want, "{x} {y}");
    }
}

#[test]
fn bytes_depend_neither_on_threads_nor_on_interruptions() {
    let (_directory, mut options) = set();
    options.style = StillStyle::ErosLike(ErosLike::default());
    let on = |threads: usize, options: &StillOptions| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| convert(options, &|_, _| {})).unwrap()
    };
    let first = on(1, &options);
    let one = files(&options.output);
    // An interruption leaves images without the list of them.
    std::fs::remove_file(options.output.join("poses.json")).unwrap();
    std::fs::remove_file(options.output.join("images/b.b_1.png")).unwrap();
    assert_eq!(on(3, &options), first);
    assert_eq!(files(&options.output), one);

    options.seed = 1;
    let message = convert(&options, &|_, _| {}).unwrap_err().to_string();
    assert!(message.contains("settings.json") && message.contains("take another"), "{message}");
    assert_eq!(files(&options.output), one);
}

#[test]
fn images_may_be_jpeg_and_progress_counts_photographs() {
    let (_directory, mut options) = set();
    options.format = CropFormat::Jpeg { quality: 95 };
    let done = std::sync::atomic::AtomicU64::new(0);
    let count = |more, all| {
        assert_eq!(all, 9);
        done.fetch_add(more, std::sync::atomic::Ordering::Relaxed);
    };
    convert(&options, &count).unwrap();
    assert_eq!(done.into_inner(), 9);
    assert!(labels(&options).contains_key("a_0.jpg"));
    assert_eq!(crop(&options, "a_0.jpg").dimensions(), (77, 78));
}

#[test]
fn what_is_odd_is_skipped_by_itself() {
    let (_directory, mut options) = set();
    options.annotations = golden("odd.mat");
    std::fs::copy(options.images.join("a.png"), options.images.join("b.png")).unwrap();
    std::fs::write(options.images.join("c.png"), b"no image").unwrap();
    let converted = convert(&options, &|_, _| {}).unwrap();
    let skipped: Vec<_> =
        converted.skipped.iter().map(|s| (s.image.as_str(), s.person, s.reason)).collect();
    assert_eq!(
        skipped,
        [
            ("../a.png", None, SkipReason::BadName),
            ("a.jpg", None, SkipReason::BadName),
            ("b.png", Some(1), SkipReason::BadField),
            ("b.png", Some(2), SkipReason::PointsOutside),
            ("c.png", None, SkipReason::UnreadableImage),
        ]
    );
    let detail = converted.skipped[2].detail.as_deref().unwrap();
    let path = "RELEASE.annolist(4).annorect(2).annopoints.point(5).x";
    assert!(detail.starts_with(path) && detail.contains("found text of 1×5"), "{detail}");
}

#[test]
fn what_is_wrong_with_the_whole_set_is_an_error() {
    let (directory, mut options) = set();
    let complaint = |options: &StillOptions| convert(options, &|_, _| {}).unwrap_err().to_string();
    options.annotations = golden("flags.mat");
    let message = complaint(&options);
    assert!(message.contains("RELEASE.img_train: 2 flags for 1 images"), "{message}");
    options.annotations = golden("poses.json");
    assert!(complaint(&options).contains("no MAT-file"));
    options.annotations = golden("release.mat");
    options.images = directory.path().join("elsewhere");
    let message = complaint(&options);
    assert!(message.contains("elsewhere") && message.contains("missing"), "{message}");
    assert!(!options.output.join("poses.json").exists());
}
