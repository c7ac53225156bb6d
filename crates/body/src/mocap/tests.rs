//! A made-up skeleton with CMU's names, axes and directions, and motions whose poses are known.

use std::fmt::Write as _;
use std::fs;

use super::*;

/// Sine and cosine of the 20° by which legs are apart at rest.
const APART: (f32, f32) = (0.342_020_15, 0.939_692_6);

/// Bones: name, parent, direction, axis, degrees of freedom. Lengths are one.
const BONES: &[(&str, &str, &str, &str, &str)] = &[
    ("lhipjoint", "root", "1 0 0", "0 0 0", ""),
    ("lfemur", "lhipjoint", "0.34202015 -0.9396926 0", "0 0 20", "rx ry rz"),
    ("ltibia", "lfemur", "0.34202015 -0.9396926 0", "0 0 20", "rx"),
    ("lfoot", "ltibia", "0 0 1", "-90 0 20", "rx rz"),
    ("ltoes", "lfoot", "0 0 1", "-90 0 20", "rx"),
    ("rhipjoint", "root", "-1 0 0", "0 0 0", ""),
    ("rfemur", "rhipjoint", "-0.34202015 -0.9396926 0", "0 0 -20", "rx ry rz"),
    ("rtibia", "rfemur", "-0.34202015 -0.9396926 0", "0 0 -20", "rx"),
    ("rfoot", "rtibia", "0 0 1", "-90 0 -20", "rx rz"),
    ("rtoes", "rfoot", "0 0 1", "-90 0 -20", "rx"),
    ("lowerback", "root", "0 1 0", "0 0 0", "rx ry rz"),
    ("upperback", "lowerback", "0 1 0", "0 0 0", "rx ry rz"),
    ("thorax", "upperback", "0 1 0", "0 0 0", "rx ry rz"),
    ("lowerneck", "thorax", "0 1 0", "0 0 0", "rx ry rz"),
    ("upperneck", "lowerneck", "0 1 0", "0 0 0", "rx ry rz"),
    ("head", "upperneck", "0 1 0", "0 0 0", "rx ry rz"),
    ("lclavicle", "thorax", "1 0 0", "0 0 0", "ry rz"),
    ("lhumerus", "lclavicle", "1 0 0", "180 -30 -90", "rx ry rz"),
    ("lradius", "lhumerus", "1 0 0", "180 -30 -90", "rx"),
    ("lwrist", "lradius", "1 0 0", "0 90 90", "ry"),
    ("lhand", "lwrist", "1 0 0", "0 90 90", "rx rz"),
    ("rclavicle", "thorax", "-1 0 0", "0 0 0", "ry rz"),
    ("rhumerus", "rclavicle", "-1 0 0", "180 30 90", "rx ry rz"),
    ("rradius", "rhumerus", "-1 0 0", "180 30 90", "rx"),
    ("rwrist", "rradius", "-1 0 0", "0 -90 -90", "ry"),
    ("rhand", "rwrist", "-1 0 0", "0 -90 -90", "rx rz"),
];

fn skeleton_text() -> String {
    let mut text = String::from(
        "# made up\n:version 1.10\n:name VICON\n:units\n  mass 1.0\n  length 0.45\n  angle deg\n\
         :root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n  orientation 0 0 0\n\
         :bonedata\n",
    );
    for (name, _, direction, axis, freedom) in BONES {
        let _ = writeln!(
            text,
            "begin\n name {name}\n direction {direction}\n length 1\n axis {axis} XYZ"
        );
        if !freedom.is_empty() {
            let _ = writeln!(text, " dof {freedom}\n limits (-160.0 20.0)\n (-70.0 70.0)");
        }
        text += "end\n";
    }
    text += ":hierarchy\nbegin\n";
    for (name, parent, ..) in BONES {
        let _ = writeln!(text, "{parent} {name}");
    }
    text + "end\n"
}

/// A motion of one pose for each of `frames`: the lines of bones that do not rest.
fn motion(frames: &[&str]) -> String {
    let mut text = String::from("#!OML:ASF\n:FULLY-SPECIFIED\n:DEGREES\n");
    for (number, lines) in frames.iter().enumerate() {
        let _ = writeln!(text, "{}\nroot 0 0 0 0 0 0\n{lines}", number + 1);
    }
    text
}

fn library(files: &[(&str, String)]) -> Result<(tempfile::TempDir, MotionLibrary), FolderError> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("created");
        fs::write(path, text).expect("written");
    }
    let library = MotionLibrary::read(folder.path())?;
    Ok((folder, library))
}

/// Joints in the first pose of a motion, turned to face z.
fn joints_of(frames: &[&str], t_s: f32) -> Vec<Vec3> {
    let files = [("03/03.asf", skeleton_text()), ("03/03_01.amc", motion(frames))];
    let (_folder, library) = library(&files).expect("listed");
    let capture = library.draw(&mut CounterRng::new(1, "capture", 0), 1.0).expect("read");
    let capture = Capture { turn_rad: 0.0, start_s: 0.0, speed: 1.0, ..capture };
    let (model, mut posed) = (BodyModel::procedural_human(), PosedBody::default());
    capture.pose(t_s, &model, &model.shaped(&[]), &mut posed);
    posed.joints.iter().map(|joint| joint.translation.into()).collect()
}

fn assert_along(joints_m: &[Vec3], [from, to]: [usize; 2], want: Vec3) {
    let found = (joints_m[to] - joints_m[from]).normalize();
    assert!(found.distance(want.normalize()) < 2e-3, "{from} to {to}: {found}, expected {want}");
}

#[test]
fn without_angles_limbs_point_as_in_the_file() {
    let joints_m = joints_of(&[""], 0.0);
    let (sin, cos) = APART;
    assert_along(&joints_m, [1, 4], Vec3::new(sin, -cos, 0.0));
    assert_along(&joints_m, [5, 8], Vec3::new(-sin, -cos, 0.0));
    assert_along(&joints_m, [16, 18], Vec3::X);
    assert_along(&joints_m, [19, 21], Vec3::NEG_X);
    // The soles are on the floor.
    let lowest_m = joints_m.iter().map(|joint_m| joint_m.y).fold(f32::INFINITY, f32::min);
    assert!((0.0..0.12).contains(&lowest_m), "{lowest_m}");
}

#[test]
fn angles_turn_limbs_about_the_axes_of_their_bones() {
    // The right thigh level and forwards with a hanging shank, the left elbow bent by 90°.
    let joints_m = joints_of(&["rfemur -90 0 0\nrtibia 90\nlradius 90"], 0.0);
    assert_along(&joints_m, [2, 5], Vec3::Z);
    let (sin, cos) = APART;
    assert_along(&joints_m, [5, 8], Vec3::new(-sin, -cos, 0.0));
    assert_along(&joints_m, [18, 20], Vec3::new(0.0, 0.5, 0.75f32.sqrt()));
    assert_along(&joints_m, [1, 4], Vec3::new(sin, -cos, 0.0));
    assert_along(&joints_m, [19, 21], Vec3::NEG_X);
}

#[test]
fn the_root_turns_everything_and_lifts_it_from_the_floor() {
    let rest = "root 0 5 0 0 0 0";
    let leap = "root 0 6 0 0 90 0";
    // Frames are used by twos: the second one is passed over.
    let frames = [&[rest; 20][..], &[rest, "root 0 50 0 0 0 0", leap]].concat();
    let at_rest = joints_of(&frames, 0.0);
    let joints_m = joints_of(&frames, 22.0 / 120.0);
    assert_along(&joints_m, [16, 18], Vec3::NEG_Z);
    // One unit of two that a leg is long.
    let leg_m = leg_length(&BodyModel::procedural_human().shaped(&[]).joints_m);
    let risen_m = joints_m[0].y - at_rest[0].y;
    assert!((risen_m - 0.5 * leg_m).abs() < 1e-3, "{risen_m} {leg_m}");
}

#[test]
fn subjects_that_are_kept_for_tests_are_not_listed() {
    let files = |subjects: &[&str]| -> Vec<(String, String)> {
        let of = |subject: &&str| {
            let skeleton = (format!("all/{subject}/{subject}.asf"), skeleton_text());
            [skeleton, (format!("all/{subject}/{subject}_01.amc"), motion(&["", "", ""]))]
        };
        subjects.iter().flat_map(of).collect()
    };
    let list = |subjects: &[&str]| {
        let files = files(subjects);
        let files: Vec<(&str, String)> =
            files.iter().map(|(n, t)| (n.as_str(), t.clone())).collect();
        library(&files)
    };
    let (_folder, library) = list(&["01", "02", "03", "104"]).expect("listed");
    let names: Vec<_> = library.motions().filter_map(|path| path.file_stem()).collect();
    assert_eq!(names, ["03_01", "104_01"]);
    let draw = |index| library.draw(&mut CounterRng::new(7, "capture", index), 1.0).expect("read");
    for index in 0..20 {
        let (a, b) = (draw(index), draw(index));
        assert!(!a.name().starts_with("01") && !a.name().starts_with("02"));
        let key = |c: &Capture| (c.name.clone(), c.start_s, c.speed, c.turn_rad);
        assert_eq!(key(&a), key(&b));
    }
    let refused = list(&["01", "02"]).expect_err("nothing is left").to_string();
    assert!(refused.contains("01 and 02"), "{refused}");
}

#[test]
fn faults_are_found_with_their_line() {
    let message = |frame: &str| {
        let files = [("3/3.asf", skeleton_text()), ("3/3_1.amc", motion(&[frame]))];
        let (_folder, library) = library(&files).expect("listed");
        library.draw(&mut CounterRng::new(1, "capture", 0), 1.0).expect_err("refused").to_string()
    };
    assert!(message("lradius 1 2").contains("line 6: 1 values expected"));
    assert!(message("ltail 1").contains("line 6: no bone `ltail`"));
    assert!(message("7").contains("line 6: frame 7 out of order"));
    let skeleton = skeleton_text().replace("angle deg", "angle rad");
    let files = [("3/3.asf", skeleton), ("3/3_1.amc", motion(&[""]))];
    assert!(library(&files).expect_err("refused").to_string().contains("line 7"));
}
