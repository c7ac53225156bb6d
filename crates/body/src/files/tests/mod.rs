//! Files in the published shapes: what they hold, and every way they can be wrong.

mod forward;
mod synthetic;

use proptest::prelude::*;

use super::*;
use synthetic::{Field, body, hand, npz, pkl};

fn read(bytes: Vec<u8>) -> Result<ModelFile, ModelFileError> {
    ModelFile::from_bytes(Path::new("MODEL"), bytes)
}

/// A hand with one field changed, as an archive.
fn changed(name: &str, change: impl FnOnce(&mut Field)) -> String {
    let mut fields = hand(-1.0);
    change(fields.iter_mut().find(|field| field.name == name).unwrap());
    read(npz(&fields)).unwrap_err().to_string()
}

#[test]
fn a_pickle_and_an_archive_of_a_hand_are_the_same_hand() {
    let (a, b) = (read(pkl(&hand(-1.0))).unwrap(), read(npz(&hand(-1.0))).unwrap());
    assert_eq!((a.format, b.format), ("Python pickle", "NumPy archive"));
    assert_eq!(
        (a.kind, b.kind),
        (ModelKind::Hand(HandSide::Right), ModelKind::Hand(HandSide::Right))
    );
    let (a, b) = (a.model, b.model);
    assert_eq!((a.template_m, a.shape_directions_m), (b.template_m, b.shape_directions_m));
    assert_eq!((a.pose_directions_m, a.skin), (b.pose_directions_m, b.skin));
    assert_eq!((a.further_weights, a.faces), (b.further_weights, b.faces));
    // The rows list vertices in another order.
    let sorted = |mut rows: Vec<Vec<(u32, f32)>>| {
        rows.iter_mut().for_each(|row| row.sort_by_key(|&(vertex, _)| vertex));
        rows
    };
    assert_eq!(sorted(a.joint_regressor), sorted(b.joint_regressor));
    assert_eq!(a.right_hand, b.right_hand);
}

#[test]
fn the_direction_of_the_fingers_distinguishes_left_from_right() {
    assert_eq!(read(npz(&hand(1.0))).unwrap().kind, ModelKind::Hand(HandSide::Left));
}

/// The first shape direction makes a hand larger, but for the signs of a published file.
#[test]
fn shape_directions_of_a_left_hand_that_are_those_of_the_right_one_are_mirrored() {
    for (side, sign, is_mirrored) in [(1.0, 1.0, false), (1.0, -1.0, true), (-1.0, -1.0, false)] {
        let mut fields = hand(side);
        let template =
            fields.iter().find(|field| field.name == "v_template").unwrap().values.clone();
        let shapes = fields.iter_mut().find(|field| field.name == "shapedirs").unwrap();
        let axis_mean = |axis: usize| template.iter().skip(axis).step_by(3).sum::<f64>() / 778.0;
        let mean: [f64; 3] = std::array::from_fn(axis_mean);
        for (k, value) in template.iter().enumerate() {
            let sign = if k % 3 == 0 { sign } else { 1.0 };
            shapes.values[10 * k] = 0.1 * sign * (value - mean[k % 3]);
        }
        let [first, second] = [0, 1].map(|k| shapes.values[k] as f32);
        let read = read(npz(&fields)).unwrap();
        let turned = if is_mirrored { -1.0 } else { 1.0 };
        assert_eq!(read.model.shape_directions_m[0][0].x, turned * first, "{side} {sign}");
        assert_eq!(read.model.shape_directions_m[1][0].x, turned * second, "{side} {sign}");
        let says_so = read.missing.iter().any(|note| note.contains("mirrored"));
        assert_eq!(says_so, is_mirrored, "{side} {sign}");
    }
}

#[test]
fn a_regressor_may_be_listed_entry_by_entry() {
    let mut fields = hand(-1.0);
    let dense = read(npz(&fields)).unwrap();
    let regressor = fields.iter_mut().find(|field| field.name == "J_regressor").unwrap();
    let entries = regressor.values.iter().enumerate().filter(|(_, value)| **value != 0.0);
    let rows: Vec<f64> =
        entries.flat_map(|(at, &value)| [(at / 778) as f64, (at % 778) as f64, value]).collect();
    regressor.shape = vec![rows.len() / 3, 3];
    regressor.values = rows;
    let listed = read(npz(&fields)).unwrap();
    assert_eq!(dense.model.joint_regressor, listed.model.joint_regressor);
}

#[test]
fn errors_name_the_field_and_what_was_expected() {
    let error = changed("v_template", |f| {
        f.shape[0] -= 1;
        f.values.truncate(3 * 777);
    });
    assert_eq!(error, "MODEL: field `v_template`: of shape [777, 3], expected [778, 3]");
    let error = changed("shapedirs", |f| f.values[7] = f64::NAN);
    assert!(error.contains("`shapedirs`: value 7 is NaN"), "{error}");
    let error = changed("f", |f| f.values[4] = 778.0);
    assert!(
        error.contains("`f`: value 4 is 778, expected a whole number from 0 to 777"),
        "{error}"
    );
    let error = changed("weights", |f| f.values[16..32].fill(0.5));
    assert_eq!(error, "MODEL: field `weights`: the weights of vertex 1 have sum 8, expected 1");
    let error = changed("kintree_table", |f| f.values[3] = 3.0);
    assert!(error.contains("`kintree_table`: joint 3 hangs on another"), "{error}");
    let error = changed("hands_mean", |f| f.name = "hand_mean");
    assert!(
        error.contains("no field `hands_mean`: the hand's mean pose (available: J_reg"),
        "{error}"
    );
}

#[test]
fn bodies_without_hands_and_other_pickles_are_no_models() {
    let error = changed("kintree_table", |f| {
        f.shape[1] = 8;
        f.values.truncate(16);
    });
    assert!(error.contains("a hand has 16 joints, a body with hands 52"), "{error}");
    let error = read(b"\x80\x02K\x01.".to_vec()).unwrap_err().to_string();
    assert!(error.contains("expected MANO_RIGHT.pkl"), "{error}");
}

#[test]
fn a_file_without_pose_correctives_says_what_that_means() {
    let mut fields = hand(-1.0);
    fields.retain(|field| field.name != "posedirs");
    let file = read(npz(&fields)).unwrap();
    assert!(file.missing.iter().any(|missing| missing.contains("posedirs")));
    assert!(file.model.pose_directions_m.is_empty());
}

/// A hand of few bytes: zeros, but for what must not be zero.
fn small() -> Vec<Field> {
    let mut fields = hand(-1.0);
    fields.retain(|field| field.name != "posedirs");
    fields
}

#[test]
fn files_that_are_cut_off_are_refused_and_say_where() {
    for (whole, stride) in [(pkl(&small()), 997), (npz(&small()), 997)] {
        let ends = (0..whole.len().min(600)).chain((600..whole.len()).step_by(stride));
        for end in ends.chain(whole.len() - 40..whole.len()) {
            let error = read(whole[..end].to_vec()).unwrap_err();
            let message = error.to_string();
            assert!(
                matches!(error, ModelFileError::Pickle { .. } | ModelFileError::Archive { .. }),
                "{end}: {message}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn changed_bytes_never_panic(
        is_pickle in any::<bool>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 1u8..), 1..8),
        is_early in any::<bool>(),
    ) {
        let mut bytes = if is_pickle { pkl(&small()) } else { npz(&small()) };
        for (at, value) in flips {
            // Half of the time where instructions and headers are dense.
            let at = at.index(if is_early { 400 } else { bytes.len() });
            bytes[at] ^= value;
        }
        let _ = read(bytes);
    }
}
