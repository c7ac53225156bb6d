//! Tables against OpenCV's, and closed forms.

use std::fmt::Write as _;

use evpose_core::{Distortion, Event, Micros, Polarity};
use sha2::{Digest, Sha256};

use super::*;

/// SHA-256 of all destinations, row by row: column and row as little-endian `u16`, 65535 for none.
fn digest(sensor: SensorSize, undistort: &Undistort) -> String {
    let mut bytes = Vec::new();
    for (y, x) in (0..sensor.height).flat_map(|y| (0..sensor.width).map(move |x| (y, x))) {
        let (x, y) = undistort.destination(x, y).unwrap_or((u16::MAX, u16::MAX));
        bytes.extend(x.to_le_bytes().into_iter().chain(y.to_le_bytes()));
    }
    Sha256::digest(&bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// OpenCV 4.14.0 and 5.0.0: `undistortPoints` of all pixels with `P = K` and its default of five
/// steps, then NumPy's `clip` to the image and conversion to integers. No coordinate is nearer than
/// 9e-8 to a whole number but those that were clipped.
#[test]
fn the_preset_of_eventhands_is_opencvs_table_clipped_and_cut_off() {
    let file = CameraFile::davis240c_eventhands();
    let camera = file.camera().unwrap();
    let undistort = Undistort::new(file.sensor, &camera, UndistortOptions::EVENTHANDS);
    let wanted = "ca3a13879a7af25752d4a4841105cb5f19bb91229e010406d9c127539eb72420";
    assert_eq!(digest(file.sensor, &undistort), wanted);
}

/// The same with 500 steps or one below 1e-12, rounded, none where that lies beyond the image. No
/// coordinate is nearer than 5e-6 to a half.
#[test]
fn converged_tables_are_opencvs_of_eight_and_of_all_fourteen_coefficients() {
    let davis = CameraFile::davis240c_eventhands();
    let all = CameraFile {
        sensor: SensorSize { width: 346, height: 260 },
        focal_px: [300.0, 305.0],
        principal_px: [170.5, 131.5],
        distortion: vec![
            -0.31, 0.12, 8e-4, -5e-4, -0.02, 0.05, -0.01, 0.004, 3e-3, -2e-3, -1e-3, 4e-3, 0.02,
            -0.035,
        ],
        fisheye: false,
    };
    let wanted = [
        (davis, "255c06234096a49c12547285cfd41c1ef93b7663574f9b874a7af9e970d84581", 5_405),
        (all, "7905d49bf74883fb16b6421607d3fbf157ecb63b2fae8d128952df07595e20a5", 17_918),
    ];
    for (file, sha, outside) in wanted {
        let camera = file.camera().unwrap();
        let undistort = Undistort::new(file.sensor, &camera, UndistortOptions::default());
        assert_eq!(undistort.unsettled_pixels(), 0);
        assert_eq!(digest(file.sensor, &undistort), sha);
        let lost = undistort.places.iter().filter(|place| place.fate == Fate::Outside).count();
        assert_eq!(lost, outside);
    }
}

const SENSOR: SensorSize = SensorSize { width: 64, height: 48 };

fn camera(coefficients: &[f64]) -> LensCamera {
    let distortion = Distortion::from_opencv(coefficients).unwrap();
    LensCamera::from_opencv([50.0, 50.0].into(), [31.5, 23.5].into(), distortion)
}

#[test]
fn without_distortion_every_event_stays_where_it_is() {
    let undistort = Undistort::new(SENSOR, &camera(&[]), UndistortOptions::default());
    for (x, y) in (0..48).flat_map(|y| (0..64).map(move |x| (x, y))) {
        assert_eq!(undistort.destination(x, y), Some((x, y)));
    }
    assert_eq!(undistort.destination(64, 0), None);
}

/// Outwards along the axis, by the formula of one coefficient: `seen = r (1 - 0.2 r²)`.
#[test]
fn a_barrel_is_undistorted_outwards() {
    let undistort = Undistort::new(SENSOR, &camera(&[-0.2, 0.0, 0.0, 0.0]), Default::default());
    let (x, y) = undistort.destination(54, 23).unwrap();
    let r = (f64::from(x) - 31.5) / 50.0;
    let seen = 50.0 * r * (1.0 - 0.2 * r * r) + 31.5;
    // The destination is rounded to a pixel, which moves it by half of one at most.
    assert!(y == 23 && x > 54 && (seen - 54.0).abs() < 0.6, "{x}, {y}: {seen}");
}

#[test]
fn what_leaves_the_image_and_what_has_no_inverse_is_counted() {
    // From 0.5774 focal lengths on, 2/3 of that are seen at most: 0.385, or 19.2 pixels.
    let camera = camera(&[-1.0, 0.0, 0.0, 0.0]);
    let event = |t, x| Event { t: Micros(t), x, y: 23, polarity: Polarity::On };
    let events = [event(0, 31), event(1, 40), event(2, 63), event(3, 63)];
    let mut stream = EventStream::from_events(SENSOR, events).unwrap();
    let mut undistort = Undistort::new(SENSOR, &camera, UndistortOptions::default());
    undistort.clean(&mut stream);
    assert_eq!(stream.x(), [31, 40]);
    assert_eq!(undistort.events, [2, 0, 0, 2]);
    let beyond = (0..48).flat_map(|y| (0..64).map(move |x| (x, y))).filter(|(x, y)| {
        let (x, y) = (f64::from(*x) - 31.5, f64::from(*y) - 23.5);
        x.hypot(y) > 50.0 * 2.0 / 27_f64.sqrt()
    });
    assert_eq!(undistort.unsettled_pixels(), beyond.count());

    // A pincushion's inverse only shrinks; a barrel pushes the corner out.
    let barrel = self::camera(&[-0.2, 0.0, 0.0, 0.0]);
    for (outside, left, wanted) in
        [(Outside::Drop, 0, [0, 0, 1, 0]), (Outside::Clip, 1, [0, 1, 0, 0])]
    {
        let options = UndistortOptions { outside, ..UndistortOptions::default() };
        let mut undistort = Undistort::new(SENSOR, &barrel, options);
        let corner = Event { t: Micros(0), x: 63, y: 47, polarity: Polarity::Off };
        let mut stream = EventStream::from_events(SENSOR, [corner]).unwrap();
        undistort.clean(&mut stream);
        assert_eq!((stream.len(), undistort.events), (left, wanted));
        assert!(stream.iter().all(|event| event == corner));
    }
}

/// Every format that `--camera` takes, and what a fisheye lens shows beyond the image.
#[test]
fn calibrations_of_other_programs_are_read_and_fisheyes_undistorted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("camera.yaml");
    let yaml = "image_width: 64\nimage_height: 48\ncamera_matrix:\n  data: [30.0, 0, 31.5, 0, 30.0, 23.5, 0, 0, \
                1]\ndistortion_model: equidistant\ndistortion_coefficients:\n  data: [0, 0, 0, 0]\n";
    std::fs::write(&path, yaml).unwrap();
    let request = format!("undistort:file={}", path.display());
    assert!(
        crate::CleanerChain::new(SENSOR, &[request.parse::<crate::CleanRequest>().unwrap()])
            .is_ok()
    );
    let camera = Calibration::of_file(&path, SENSOR).unwrap().camera;
    let undistort = Undistort::new(SENSOR, &camera, UndistortOptions::default());
    // 19.5 pixels from the axis are 0.65 radians: 30 tan 0.65 = 22.8 pixels.
    assert_eq!(undistort.destination(51, 23), Some((54, 23)));
    assert_eq!(undistort.destination(0, 0), None);
}
