use std::fs;

use evpose_pose::body::number;
use proptest::prelude::*;

use super::*;

fn read(text: &str) -> Result<Vec<BodyPrediction>, IoError> {
    predictions_of(Input::memory("movenet.csv", text.as_bytes().to_vec()))
}

fn written(predictions: &[BodyPrediction]) -> String {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("results/movenet.csv");
    let mut writer = PredictionWriter::create(&path).unwrap();
    predictions.iter().for_each(|prediction| writer.write(prediction).unwrap());
    assert!(!path.exists(), "a file that is not whole has no name");
    writer.finish().unwrap();
    fs::read_to_string(path).unwrap()
}

/// Joint `k` of the file at `(10 k + 0.5, 200 + k)`, but for the left wrist, the file's joint 8.
fn sample(t_s: f64) -> BodyPrediction {
    let joint = |k: usize| (k != 8).then(|| Vec2::new(10.0 * k as f32 + 0.5, 200.0 + k as f32));
    let joints_px = network_from_file(&std::array::from_fn(joint));
    BodyPrediction { t_s, delay_s: 0.0125, joints_px }
}

const JOINTS: &str = "0.5 200 10.5 201 20.5 202 30.5 203 40.5 204 50.5 205 60.5 206 70.5 207 LOST 90.5 \
                      209 100.5 210 110.5 211 120.5 212";

#[test]
fn a_line_is_a_time_a_delay_and_thirteen_joints() {
    let line = format!("0.04 0.0125 {}\n", JOINTS.replace("LOST", "-1 -1"));
    assert_eq!(written(&[sample(0.04)]), line);
    assert_eq!(read(&line).unwrap(), [sample(0.04)]);
    assert_eq!(sample(0.0).joints_px[number::WRIST_L], None);
}

#[test]
fn lines_of_other_programs_are_read() {
    // Python's writer ends lines in two characters, its online program separates by commas, and the
    // one in C++ writes two digits and an exponent.
    let python = format!("0.04 0.0125 {}\r\n", JOINTS.replace("LOST", "-640.0 -480.0"));
    let online = python.replace(' ', ",");
    let cpp = "0.04000 1.25000e-02 0.50 200.00 10.50 201.00 20.50 202.00 30.50 203.00 40.50 204.00 50.50 \
               205.00 60.50 206.00 70.50 207.00 -1.00 -1.00 90.50 209.00 100.50 210.00 110.50 211.00 \
               120.50 212.00\n";
    let text = format!("# t delay joints\n{python}\n{online}{cpp}");
    assert_eq!(read(&text).unwrap(), vec![sample(0.04); 3]);
}

#[test]
fn joints_beyond_a_border_are_joints() {
    for pair in ["-0.5 -0.5", "-3 20", "20 -3", "0 0", "-2.5 -1"] {
        let line = format!("0.04 0.0125 {}\n", JOINTS.replace("LOST", pair));
        let wrist = read(&line).unwrap()[0].joints_px[number::WRIST_L];
        assert!(wrist.is_some(), "{pair}");
    }
    // One that lies where "not found" does is moved by next to nothing.
    let mut prediction = sample(0.0);
    prediction.joints_px[0] = Some(Vec2::new(-1.0, -1.0));
    let text = written(&[prediction]);
    let head = read(&text).unwrap()[0].joints_px[0].unwrap();
    assert!(head != Vec2::NEG_ONE && head.distance(Vec2::NEG_ONE) < 1e-6, "{head}");
}

#[test]
fn a_faulty_line_is_named_with_its_byte() {
    let good = format!("0.04 0.0125 {}\n", JOINTS.replace("LOST", "-1 -1"));
    let second = good.len();
    for (bad, reason) in [
        ("0.5\n".to_owned(), "28 values were expected, 1 found"),
        (good.replacen("0.04 ", "", 1), "28 values were expected, 27 found"),
        (good.replace(" 200 ", " 200 7 "), "28 values were expected, 29 found"),
        (good.replace("200", "x"), "column 4 is \"x\", no finite number"),
        (good.replace("200", "nan"), "column 4 is \"nan\", no finite number"),
        (good.trim_end().to_owned(), "the file ends in it, perhaps within a number"),
    ] {
        let message = read(&format!("{good}{bad}")).unwrap_err().to_string();
        let want =
            format!("movenet.csv: line 2 at byte {second}: {reason} (1 rows readable before it)");
        assert_eq!(message, want);
    }
    assert!(predictions_of(Input::memory("x", vec![0xff, b'\n'])).is_err());
}

#[test]
fn a_table_cut_at_any_byte_gives_an_error_or_the_exact_prefix() {
    let predictions = [sample(0.04), sample(0.06)];
    let text = written(&predictions);
    let line = text.find('\n').unwrap() + 1;
    for cut in 0..text.len() {
        match read(&text[..cut]) {
            Ok(rows) => assert!(cut % line == 0 && rows == predictions[..cut / line]),
            Err(error) => assert_eq!(error.byte(), Some((cut / line * line) as u64)),
        }
    }
}

#[test]
fn values_that_are_not_finite_are_not_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.csv");
    let mut writer = PredictionWriter::create(&path).unwrap();
    writer.write(&sample(0.0)).unwrap();
    let mut bad = sample(0.1);
    bad.joints_px[3] = Some(Vec2::new(f32::NAN, 0.0));
    let message = writer.write(&bad).unwrap_err().to_string();
    assert!(message.ends_with("prediction 1 holds a number that is not finite"), "{message}");
    assert!(writer.write(&BodyPrediction { delay_s: f64::INFINITY, ..sample(0.1) }).is_err());
    drop(writer);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_predictions_are_read_back(
        rows in prop::collection::vec(
            (any::<f64>(), any::<f64>(), prop::collection::vec(prop::option::of((-1e3_f32..1e3, any::<f32>())), 13)),
            0..6,
        ),
    ) {
        let finite = |number: f64| if number.is_finite() { number } else { 0.0 };
        let rows: Vec<_> = rows
            .iter()
            .map(|(t_s, delay_s, joints)| BodyPrediction {
                t_s: finite(*t_s),
                delay_s: finite(*delay_s),
                joints_px: std::array::from_fn(|k| {
                    let (x, y) = joints[k].filter(|(_, y)| y.is_finite())?;
                    (!stands_for_none([x, y])).then(|| Vec2::new(x, y))
                }),
            })
            .collect();
        let text = written(&rows);
        prop_assert_eq!(read(&text).unwrap(), rows);
    }

    #[test]
    fn changed_bytes_never_panic(changes in prop::collection::vec(any::<(usize, u8)>(), 1..20)) {
        let mut text = written(&[sample(0.0), sample(0.1)]).into_bytes();
        for (at, byte) in changes {
            let at = at % text.len();
            text[at] = byte;
        }
        let _ = predictions_of(Input::memory("x", text));
    }
}
