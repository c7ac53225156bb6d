//! Writes skeletons as a log.

use std::fmt::Write as _;
use std::path::Path;

use evpose_core::{Micros, atomic_write};

use super::bottle::MAX_SECONDS;
use super::skeleton::YarpSkeleton;
use crate::IoError;

/// How joints are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CoordinateFormat {
    /// Rounded to whole pixels: hpe-core reads nothing else.
    #[default]
    Whole,
    /// As they are.
    Exact,
}

/// Writes a folder of `info.log` and `data.log`, which comes last, as hpe-core does: lines such as
/// `7 000.12 SKLT (26 values) -1.0 104.3`, sizes that are not known as -1. Where skeletons have
/// confidences, these follow the joints in the brackets, and sizes are left out if none is known.
///
/// `channel` is a name such as `ch0GTskeleton`. hpe-core looks for folders with `skeleton` in their
/// name.
///
/// # Errors
/// If the channel is not a word, a number is not finite, a size negative or a time too late to be
/// read, or a file cannot be written. Files have their names only when they are whole.
pub fn write_skeletons(
    folder: impl AsRef<Path>,
    channel: &str,
    skeletons: &[YarpSkeleton],
    format: CoordinateFormat,
) -> Result<(), IoError> {
    let [info, data] = ["info.log", "data.log"].map(|name| folder.as_ref().join(name));
    if channel.is_empty() || channel.contains(|c: char| c.is_whitespace() || c.is_control()) {
        return Err(IoError::unwritable(&info, format!("the channel {channel:?} is not a word")));
    }
    let mut lines = String::new();
    for (counter, skeleton) in skeletons.iter().enumerate() {
        if let Some(reason) = fault(skeleton) {
            return Err(IoError::unwritable(&data, format!("skeleton {counter}: {reason}")));
        }
        lines += &format!("{counter} {} SKLT (", seconds(skeleton.t));
        put(&mut lines, skeleton, format);
    }
    let write = |path: &Path, text: &str| {
        atomic_write(path, text.as_bytes()).map_err(|e| IoError::file(path, "write", e))
    };
    // The data come last: a folder with them is complete.
    write(&info, &format!("Type: Bottle;\n[0.0] /file/{channel}:o [connected]\n"))?;
    write(&data, &lines)
}

/// Why a skeleton could not be read again.
fn fault(skeleton: &YarpSkeleton) -> Option<&'static str> {
    let mut values = skeleton.joints.iter().flatten().chain(skeleton.confidences.iter().flatten());
    let mut sizes = [skeleton.head_size_px, skeleton.torso_size_px].into_iter().flatten();
    if !values.all(|value| value.is_finite()) {
        Some("a joint or a confidence is not finite")
    } else if !sizes.all(|size| size.is_finite() && size >= 0.0) {
        Some("a size is negative or not finite")
    } else if skeleton.t.as_seconds().abs() >= MAX_SECONDS {
        Some("no log is that long")
    } else {
        None
    }
}

/// Appends the content behind the opening bracket.
fn put(lines: &mut String, skeleton: &YarpSkeleton, format: CoordinateFormat) {
    let position = |&value: &f32| match format {
        CoordinateFormat::Whole => format!("{}", value.round_ties_even() as i64),
        CoordinateFormat::Exact => format!("{value:?}"),
    };
    let mut inside: Vec<_> = skeleton.joints.iter().flatten().map(position).collect();
    inside
        .extend(skeleton.confidences.iter().flatten().map(|confidence| format!("{confidence:?}")));
    lines.push_str(&inside.join(" "));
    lines.push(')');
    let sizes = [skeleton.head_size_px, skeleton.torso_size_px];
    if skeleton.confidences.is_none() || sizes.iter().any(Option::is_some) {
        for size in sizes {
            // Text takes all that is written to it.
            let _ = write!(lines, " {:?}", size.unwrap_or(-1.0));
        }
    }
    lines.push('\n');
}

/// As Python's `{:06}`, without exponents: at least one digit behind the point and six characters.
fn seconds(t: Micros) -> String {
    let (whole, micros) = (t.0.unsigned_abs() / 1_000_000, t.0.unsigned_abs() % 1_000_000);
    let behind = format!("{micros:06}");
    let behind = match behind.trim_end_matches('0') {
        "" => "0",
        digits => digits,
    };
    let digits = format!("{whole}.{behind}");
    if t.0 < 0 { format!("-{digits:0>5}") } else { format!("{digits:0>6}") }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use proptest::prelude::*;

    use super::*;
    use crate::yarp::{JOINTS, read_skeletons};

    fn skeleton(t: i64) -> YarpSkeleton {
        YarpSkeleton {
            t: Micros(t),
            joints: std::array::from_fn(|k| [10.0 * k as f32, 400.0 - k as f32]),
            confidences: None,
            head_size_px: None,
            torso_size_px: Some(104.3),
        }
    }

    #[test]
    fn a_log_looks_as_hpe_core_writes_it() {
        let directory = tempfile::tempdir().unwrap();
        let folder = directory.path().join("ch0GT50Hzskeleton");
        let mut online = skeleton(1_234_567_890);
        online.confidences = Some([0.5; JOINTS]);
        online.torso_size_px = None;
        let skeletons = [skeleton(0), skeleton(20_000), skeleton(-1_500_000), online];
        write_skeletons(&folder, "ch0GTskeleton", &skeletons, CoordinateFormat::Whole).unwrap();
        let info = fs::read_to_string(folder.join("info.log")).unwrap();
        assert_eq!(info, "Type: Bottle;\n[0.0] /file/ch0GTskeleton:o [connected]\n");
        let joints = "0 400 10 399 20 398 30 397 40 396 50 395 60 394 70 393 80 392 90 391 100 390 \
                      110 389 120 388";
        let halves = ["0.5"; JOINTS].join(" ");
        let want = format!(
            "0 0000.0 SKLT ({joints}) -1.0 104.3\n1 000.02 SKLT ({joints}) -1.0 104.3\n\
             2 -001.5 SKLT ({joints}) -1.0 104.3\n3 1234.56789 SKLT ({joints} {halves})\n"
        );
        assert_eq!(fs::read_to_string(folder.join("data.log")).unwrap(), want);
        assert_eq!(read_skeletons(&folder).unwrap(), skeletons);
    }

    #[test]
    fn what_could_not_be_read_again_is_not_written() {
        let directory = tempfile::tempdir().unwrap();
        let fails = |channel: &str, change: fn(&mut YarpSkeleton)| {
            let mut bad = skeleton(0);
            change(&mut bad);
            let written = write_skeletons(
                directory.path(),
                channel,
                &[skeleton(0), bad],
                CoordinateFormat::Exact,
            );
            let message = written.unwrap_err().to_string();
            assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0, "{message}");
            message
        };
        assert!(fails("", |_| ()).ends_with("the channel \"\" is not a word"));
        assert!(fails("a b", |_| ()).ends_with("the channel \"a b\" is not a word"));
        let message = fails("x", |bad| bad.joints[4][1] = f32::NAN);
        assert!(
            message.ends_with("skeleton 1: a joint or a confidence is not finite"),
            "{message}"
        );
        fails("x", |bad| bad.confidences = Some([f32::INFINITY; JOINTS]));
        fails("x", |bad| bad.head_size_px = Some(-0.5));
        fails("x", |bad| bad.t = Micros(i64::MAX));
    }

    #[test]
    fn joints_that_are_not_known_have_no_point() {
        let mut skeleton = skeleton(20_000);
        skeleton.joints[5] = [-1.0, -1.0];
        skeleton.joints[6] = [-2.0, -1.0];
        // The left hip is joint 7 of networks.
        let points = skeleton.points_px();
        assert!(points[7].is_none() && points[8].is_some());
        // Online, all pairs of negative whole numbers stand for nothing.
        skeleton.confidences = Some([0.0; JOINTS]);
        assert_eq!(skeleton.points_px()[8], None);
        assert_eq!(
            skeleton.clone().transposed().points_px()[0],
            skeleton.points_px()[0].map(|at| [at.y, at.x].into())
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn any_skeletons_are_read_back(
            rows in prop::collection::vec(
                (
                    -1_000_000_000_i64..4_000_000_000,
                    prop::collection::vec(-2e3_f32..2e3, 2 * JOINTS),
                    prop::option::of(0.0_f32..1.0),
                    prop::option::of(0.0_f32..300.0),
                ),
                0..8,
            ),
        ) {
            let skeletons: Vec<_> = rows
                .iter()
                .map(|(t, values, confidence, size)| YarpSkeleton {
                    t: Micros(*t),
                    joints: std::array::from_fn(|k| [values[2 * k], values[2 * k + 1]]),
                    confidences: confidence.map(|confidence| [confidence; JOINTS]),
                    head_size_px: *size,
                    torso_size_px: size.map(|size| size / 3.0),
                })
                .collect();
            let directory = tempfile::tempdir().unwrap();
            write_skeletons(directory.path(), "x", &skeletons, CoordinateFormat::Exact).unwrap();
            prop_assert_eq!(&read_skeletons(directory.path()).unwrap(), &skeletons);
            write_skeletons(directory.path(), "x", &skeletons, CoordinateFormat::Whole).unwrap();
            for (read, written) in read_skeletons(directory.path()).unwrap().iter().zip(&skeletons) {
                prop_assert_eq!(read.joints, written.joints.map(|joint| joint.map(f32::round_ties_even)));
            }
        }
    }
}
