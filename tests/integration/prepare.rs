//! Data sets in their published layouts, prepared and checked on the command line.

use std::path::{Path, PathBuf};

use evpose_core::Micros;
use evpose_datasets::{Annotation, read_annotations};
use evpose_sim::person::{PersonInfo, PoseRow, PoseTable};
use glam::{Vec2, Vec3};

use crate::harness::{Sandbox, bytes};

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/datasets/tests/golden").join(name)
}

fn annotations(sandbox: &Sandbox, name: &str) -> Vec<Annotation> {
    read_annotations(&sandbox.path(name)).unwrap()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to.parent().unwrap()).unwrap();
    std::fs::copy(from, to).unwrap();
}

/// MPII in the layout of its archives; see `golden/mpii/README.md` for the photographs.
pub(crate) fn mpii() -> Sandbox {
    let sandbox = Sandbox::new();
    mpii_in(&sandbox);
    sandbox
}

/// As [`mpii`], in a sandbox that is there.
pub(crate) fn mpii_in(sandbox: &Sandbox) {
    let folder = sandbox.path("MPII");
    let mat = "mpii_human_pose_v1_u12_2/mpii_human_pose_v1_u12_1.mat";
    copy(&golden("mpii/release.mat"), &folder.join(mat));
    std::fs::create_dir(folder.join("images")).unwrap();
    // Sizes and places are those of the labels in the golden release.
    for (name, index, width, height) in [
        ("a.png", 0, 64, 48),
        ("b.b.png", 1, 80, 60),
        ("c.png", 2, 40, 40),
        ("d.png", 3, 40, 40),
        ("f.png", 5, 50, 40),
        ("h.png", 7, 70, 50),
        ("i.png", 8, 50, 40),
        ("j.png", 9, 50, 40),
    ] {
        // A texture by index: no two images are alike.
        let pixel = |x, y| image::Luma([((7 * x + 11 * y + x * y / 5 + 31 * index) % 256) as u8]);
        let image = image::GrayImage::from_fn(width, height, pixel);
        image.save(folder.join("images").join(name)).unwrap();
    }
}

/// Three movements of DHP19, each with the golden files; the last is one that is of no use.
fn dhp19() -> Sandbox {
    let sandbox = Sandbox::new();
    dhp19_in(&sandbox);
    sandbox
}

/// As [`dhp19`], in a sandbox that is there.
pub(crate) fn dhp19_in(sandbox: &Sandbox) {
    let folder = sandbox.path("DHP19");
    for [subject, session, movement] in [[1, 2, 5], [13, 2, 5], [4, 3, 4]] {
        let movie = format!("DVS_movies/S{subject}/session{session}/mov{movement}.aedat");
        copy(&golden("dhp19/mov5.aedat"), &folder.join(movie));
        let vicon = format!("Vicon_data/S{subject}_{session}_{movement}.mat");
        copy(&golden("dhp19/S1_2_5.mat"), &folder.join(vicon));
    }
    for k in 1..=4 {
        let name = format!("P{k}.npy");
        copy(&golden("dhp19").join(&name), &folder.join("P_matrices").join(&name));
    }
}

/// A few photographs of the Leeds Sports Pose set and of COCO, of which one has a person of 17 keypoints, in a zigzag.
pub(crate) fn lsp_and_coco_in(sandbox: &Sandbox) {
    let image = image::GrayImage::from_pixel(100, 80, image::Luma([90]));
    for folder in ["lspet/images", "COCO/val2017", "COCO/annotations"] {
        std::fs::create_dir_all(sandbox.path(folder)).unwrap();
    }
    copy(&golden("lsp/extended.mat"), &sandbox.path("lspet/joints.mat"));
    for name in ["im00001.jpg", "im00002.jpg", "im00003.jpg", "im00004.jpg", "im00006.jpg"] {
        image.save(sandbox.path("lspet/images").join(name)).unwrap();
    }
    image.save(sandbox.path("COCO/val2017/000000000139.jpg")).unwrap();
    let keypoints: Vec<String> =
        (0..17).map(|k| format!("{},{},2", 20 + 20 * (k % 2), 5 + 4 * k)).collect();
    let file = format!(
        "{{\"images\":[{{\"id\":139,\"file_name\":\"000000000139.jpg\"}}],\
         \"annotations\":[{{\"image_id\":139,\"keypoints\":[{}]}}]}}",
        keypoints.join(",")
    );
    let annotations = sandbox.path("COCO/annotations/person_keypoints_val2017.json");
    std::fs::write(annotations, file).unwrap();
}

/// A clip of Human3.6M: poses, and four frames of a video.
pub(crate) fn h36m_in(sandbox: &Sandbox) {
    let cdf = "H36M/S9/Poses_D2_Positions/Walking 1.55011271.cdf";
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let golden = root.join("crates/containers/tests/golden/cdf/one_record.cdf");
    copy(&golden, &sandbox.path(cdf));
    let frames = sandbox.path("H36M/S9/Videos/Walking 1.55011271");
    std::fs::create_dir_all(&frames).unwrap();
    for frame in 0..4 {
        let is_bar = |x: u32| (300 + 20 * frame..340 + 20 * frame).contains(&x);
        let pixel = |x, _| image::Luma([if is_bar(x) { 200_u8 } else { 60 }]);
        let image = image::GrayImage::from_fn(1000, 1000, pixel);
        image.save(frames.join(format!("{:06}.png", frame + 1))).unwrap();
    }
}

#[test]
fn mpii_becomes_persons_and_the_rest_is_reported() {
    let sandbox = mpii();
    let said = sandbox.ok(&["prepare", "mpii", "MPII", "--out", "data"]);
    for line in ["7 persons of 6 photographs", "1 no such image", "left out: 5"] {
        assert!(said.contains(line), "{said}");
    }
    let first = annotations(&sandbox, "data/poses.json");
    assert_eq!(first.len(), 7);
    assert!(first.iter().all(|a| sandbox.path("data/images").join(&a.image).is_file()));
    let run = sandbox.text("data/run.toml");
    assert!(run.contains("prepare mpii MPII --out data") && run.contains("commit"), "{run}");

    // On with what was interrupted, and not with other settings.
    let poses = bytes(&sandbox.path("data/poses.json"));
    std::fs::remove_file(sandbox.path("data/poses.json")).unwrap();
    std::fs::remove_file(sandbox.path("data/images/b.b_1.png")).unwrap();
    sandbox.ok(&["prepare", "mpii", "MPII", "--out", "data", "--threads", "1"]);
    assert!(bytes(&sandbox.path("data/poses.json")) == poses);
    assert!(sandbox.path("data/images/b.b_1.png").is_file());
    let message = sandbox.fails(&["prepare", "mpii", "MPII", "--out", "data", "--seed", "1"]);
    assert!(message.contains("settings.json") && message.contains("take another"), "{message}");

    // A photograph's persons are one sequence each: nothing is missing before or behind them.
    let (_, said) = sandbox.ends(&["check-labels", "data"]);
    assert!(said.starts_with("7 frames of 7 tracks"), "{said}");
    assert!(!said.contains("\nmissing:"), "{said}");
}

#[test]
fn mpii_may_stay_grey_and_be_as_published() {
    let sandbox = mpii();
    let options = ["--grey", "--parity", "--jpeg", "95"];
    sandbox.ok(&[&["prepare", "mpii", "MPII", "--out", "data"], &options[..]].concat());
    let ours = annotations(&sandbox, "data/poses.json");
    let want = read_annotations(&golden("mpii/poses.json")).unwrap();
    let name = |a: &Annotation| a.image.split('.').rev().nth(1).unwrap().to_owned();
    let mut names = [&ours, &want].map(|set| set.iter().map(name).collect::<Vec<_>>());
    names.iter_mut().for_each(|names| names.sort());
    assert_eq!(names[0], names[1]);
    assert!(ours.iter().all(|a| a.image.ends_with(".jpg")));
}

#[test]
fn what_of_mpii_is_missing_is_named() {
    let sandbox = mpii();
    let message = sandbox.fails(&["prepare", "mpii", "elsewhere", "--out", "data"]);
    assert!(message.contains("mpii_human_pose_v1_u12_1.mat"), "{message}");
    let images = ["--images", "nowhere"];
    let message =
        sandbox.fails(&[&["prepare", "mpii", "MPII", "--out", "no"], &images[..]].concat());
    assert!(message.contains("nowhere") && message.contains("missing"), "{message}");
    assert!(!sandbox.path("no/poses.json").exists());
}

#[test]
fn lsp_and_coco_become_persons_by_the_same_steps() {
    let sandbox = Sandbox::new();
    lsp_and_coco_in(&sandbox);
    let said = sandbox.ok(&["prepare", "lsp", "lspet", "--out", "lsp"]);
    for line in [
        "2 persons of 2 photographs",
        "2 left and right seem to be exchanged",
        "1 too few joints",
        "ankle_r 1",
        "--data lsp",
    ] {
        assert!(said.contains(line), "{said}");
    }
    assert!(!said.contains("not for training"), "{said}");

    sandbox.ok(&["prepare", "coco", "COCO", "--split", "val2017", "--out", "coco"]);
    let names: Vec<String> =
        annotations(&sandbox, "coco/poses.json").into_iter().map(|a| a.image).collect();
    assert_eq!(names, ["000000000139_0.png"]);
    let message = sandbox.fails(&["prepare", "coco", "COCO", "--out", "no"]);
    assert!(message.contains("no annotations/person_keypoints_train2017.json"), "{message}");
}

#[test]
fn dhp19_becomes_frames_of_the_cameras_that_are_asked_for() {
    let sandbox = dhp19();
    let said = sandbox.ok(&["prepare", "dhp19", "DHP19", "--out", "data", "--every", "1"]);
    assert!(said.contains("3 of 561 movements are there"), "{said}");
    assert!(
        said.contains("of 2 movements") && said.contains("S4_3_4: hundreds of pulses"),
        "{said}"
    );
    // Twelve poses, 100 a second, without the first two, of cameras 2 and 3.
    let train = annotations(&sandbox, "data/train.json");
    let names: Vec<&str> = train.iter().map(|a| a.image.as_str()).collect();
    let want = [2, 3].map(|camera| (2..12).map(move |k| format!("S1_2_5_ch{camera}_{k:05}.png")));
    assert_eq!(names, want.into_iter().flatten().collect::<Vec<_>>());
    assert_eq!(train[0].t_s, Some(0.02));
    let test = annotations(&sandbox, "data/test.json");
    assert!(test.len() == 20 && test.iter().all(|a| a.image.starts_with("S13_2_5_ch")));
    let size = image::image_dimensions(sandbox.path("data/eros").join(&train[0].image)).unwrap();
    assert_eq!(size, (346, 260));
    let report = sandbox.text("data/conversion.json");
    assert!(report.contains("\"frames_to_train\": 20"), "{report}");
    assert!(report.contains("camera 1: 1 events are outside"), "{report}");

    let some = ["--subjects", "1", "--cameras", "all"];
    sandbox.ok(&[&["prepare", "dhp19", "DHP19", "--out", "some"], &some[..]].concat());
    let names = annotations(&sandbox, "some/train.json").into_iter().map(|a| a.image);
    let want = [0, 1, 2, 3].map(|camera| format!("S1_2_5_ch{camera}_00010.png"));
    assert_eq!(names.collect::<Vec<_>>(), want);
    assert_eq!(annotations(&sandbox, "some/test.json"), []);
}

#[test]
fn labels_of_dhp19_are_where_numpy_projects_them() {
    let sandbox = dhp19();
    let all = ["--every", "1", "--subjects", "1", "--cameras", "all"];
    for (out, parity) in [("exact", None), ("published", Some("--parity"))] {
        let args = [&["prepare", "dhp19", "DHP19", "--out", out], &all[..], parity.as_slice()];
        sandbox.ok(&args.concat());
    }
    let [exact, published] =
        ["exact", "published"].map(|out| annotations(&sandbox, &format!("{out}/train.json")));
    assert_eq!(exact.len(), published.len());
    let table = std::fs::read_to_string(golden("dhp19/projected.csv")).unwrap();
    let mut compared = 0;
    for line in table.lines().skip(1) {
        let [camera, pose, joint, u, v] = line.split(',').collect::<Vec<_>>().try_into().unwrap();
        if joint != "head" || u.is_empty() || pose == "0" {
            continue;
        }
        let want = Vec2::new(u.parse().unwrap(), v.parse().unwrap());
        let image = format!("S1_2_5_ch{camera}_{pose:0>5}.png");
        // As published, positions are cut to whole pixels.
        for (set, want) in [(&exact, want), (&published, want.trunc())] {
            let found = set.iter().find(|a| a.image == image).unwrap().label.keypoints[0].position;
            let found = found * Vec2::new(346.0, 260.0);
            assert!(found.distance(want) < 1e-3, "{image}: {found}, {want}");
            compared += 1;
        }
    }
    assert!(compared >= 8, "{compared}");
}

#[test]
fn movements_that_others_have_cut_serve_too() {
    let sandbox = dhp19();
    copy(&golden("dhp19/extracted.mat"), &sandbox.path("cut/S1_2_5.mat"));
    let cut = ["--extracted", "cut", "--parity"];
    let said = sandbox.ok(&[&["prepare", "dhp19", "DHP19", "--out", "data"], &cut[..]].concat());
    assert!(said.contains("1 of 561 movements") && said.contains("2 frames to train"), "{said}");
}

#[test]
fn what_of_dhp19_is_missing_is_named() {
    let sandbox = dhp19();
    let prepare = |more: &[&str]| {
        sandbox.fails(&[&["prepare", "dhp19", "DHP19", "--out", "data"], more].concat())
    };
    assert!(prepare(&["--subjects", "77"]).contains("1 to 17"));
    assert!(prepare(&["--subjects", "2"]).contains("DVS_movies/S2/session1/mov1.aedat"));
    assert!(prepare(&["--projections", "nowhere"]).contains("nowhere/P3.npy"));
    std::fs::remove_dir_all(sandbox.path("DHP19/Vicon_data")).unwrap();
    let message = prepare(&[]);
    assert!(message.contains("none of 3 movements") && message.contains("Vicon_data"), "{message}");
    assert!(!sandbox.path("data/train.json").exists());
}

#[test]
fn clips_of_eh36m_become_frames_once() {
    let sandbox = Sandbox::new();
    let folder = golden("h36m/yarp").display().to_string();
    let said = sandbox.ok(&["prepare", "eh36m", &folder, "--out", "data"]);
    assert!(said.contains("0 frames to train on and 3 to test on"), "{said}");
    let names = annotations(&sandbox, "data/test.json").into_iter().map(|a| a.image);
    let want = [2, 3, 4].map(|k| format!("cam2_S9_Walking_1_{k:05}.png"));
    assert_eq!(names.collect::<Vec<_>>(), want);
    let message = sandbox.fails(&["prepare", "eh36m", &folder, "--out", "data"]);
    assert!(message.contains("train.json") && message.contains("--out"), "{message}");
    let message = sandbox.fails(&["prepare", "eh36m", ".", "--out", "other"]);
    assert!(message.contains("cam2_S9_Walking_1"), "{message}");

    sandbox.ok(&["prepare", "eh36m", &folder, "--out", "published", "--parity"]);
    let [ours, theirs] = ["data", "published"]
        .map(|out| annotations(&sandbox, &format!("{out}/test.json"))[0].label.torso_size.unwrap());
    // As published, torsos are measured otherwise.
    assert_ne!(ours, theirs);
}

#[test]
fn videos_of_human36m_become_frames_and_published_clips() {
    let sandbox = Sandbox::new();
    h36m_in(&sandbox);
    let args = ["prepare", "h36m", "H36M", "--out", "data", "--yarp"];
    let frames = sandbox.path("H36M/S9/Videos/Walking 1.55011271");
    std::fs::rename(&frames, sandbox.path("elsewhere")).unwrap();
    let message = sandbox.fails(&args);
    assert!(message.contains("S9/Videos/Walking 1.55011271: there is no such folder"), "{message}");
    std::fs::rename(sandbox.path("elsewhere"), &frames).unwrap();
    let said = sandbox.ok(&args);
    assert!(said.contains("4 frames, but 7 poses"), "{said}");
    let test = annotations(&sandbox, "data/test.json");
    let names: Vec<&str> = test.iter().map(|a| a.image.as_str()).collect();
    assert_eq!(names, ["cam2_S9_Walking_1_00002.png", "cam2_S9_Walking_1_00003.png"]);
    // What was written as published is prepared as such.
    sandbox.ok(&["prepare", "eh36m", "data/yarp", "--out", "again"]);
    let again = annotations(&sandbox, "again/test.json");
    assert_eq!(again.len(), test.len());
    for (again, test) in again.iter().zip(&test) {
        let joints = again.label.keypoints.iter().zip(&test.label.keypoints);
        // Joints were rounded to whole pixels of 640x480.
        assert!(joints.clone().all(|(a, b)| a.position.distance(b.position) < 1.5e-3));
    }
}

#[test]
fn a_network_is_trained_on_what_was_prepared() {
    let sandbox = dhp19();
    sandbox.ok(&["prepare", "dhp19", "DHP19", "--out", "data", "--every", "1"]);
    let small = [
        "data.source=annotations",
        "image.side_px=64",
        "network.width=0.0625",
        "training.batch_size=4",
        "training.steps=2",
        "training.steps_per_validation=2",
        "training.validation_samples=4",
    ];
    // A directory and a single file are both accepted.
    for (data, run) in [("data", "one"), ("data/test.json", "two")] {
        let args = ["train", "pretrain", "--data", data, "--out", run];
        let small = small.iter().flat_map(|change| ["--set", change]);
        let said = sandbox.ok(&args.into_iter().chain(small).collect::<Vec<_>>());
        assert!(said.contains("20 images"), "{said}");
        assert!(sandbox.path(run).join("best.bpk").is_file());
    }
}

/// Somebody who walks, and whose left and right are exchanged in some rows.
fn table(exchanged: std::ops::Range<usize>) -> PoseTable {
    // Columns and rows about the head, in the order of networks.
    const BODY: [[f32; 2]; 13] = [
        [0.0, 0.0],
        [15.0, 20.0],
        [-15.0, 20.0],
        [20.0, 45.0],
        [-20.0, 45.0],
        [22.0, 65.0],
        [-22.0, 65.0],
        [10.0, 70.0],
        [-10.0, 70.0],
        [11.0, 100.0],
        [-11.0, 100.0],
        [12.0, 130.0],
        [-12.0, 130.0],
    ];
    let row = |k: usize| {
        let at = |[x, y]: [f32; 2]| {
            let side = if exchanged.contains(&k) { -1.0 } else { 1.0 };
            Some(Vec2::new(100.0 + 0.5 * k as f32 + side * x, 50.0 + y))
        };
        PoseRow {
            t: Micros(10_000 * k as i64),
            joints_px: BODY.map(at),
            joints_m: [Vec3::ZERO; 13],
        }
    };
    PoseTable { rows: (0..60).map(row).collect() }
}

#[test]
fn labels_are_checked_and_the_exit_code_reports_faults() {
    let sandbox = Sandbox::new();
    let sensor = evpose_core::SensorSize { width: 346, height: 260 };
    let info = PersonInfo {
        sensor,
        activity: "walking".into(),
        betas: vec![],
        threshold_offset: 0.0,
        scene: None,
        camera: None,
    };
    for (name, exchanged) in [("0000", 0..0), ("0001", 20..30)] {
        table(exchanged).write(&sandbox.path(&format!("{name}.poses.csv"))).unwrap();
        let toml = toml::to_string(&info).unwrap();
        sandbox.write(&format!("{name}.toml"), toml);
    }
    let said = sandbox.ok(&["check-labels", "0000.poses.csv"]);
    assert!(said.starts_with("60 frames of 1 tracks, 0 findings"), "{said}");

    let code = |args: &[&str]| sandbox.evpose(args).output().unwrap().status.code();
    assert_eq!(code(&["check-labels", ".", "--json", "found.json"]), Some(2));
    let found: serde_json::Value = serde_json::from_str(&sandbox.text("found.json")).unwrap();
    let findings = found["findings"].as_array().unwrap();
    assert!(!findings.is_empty(), "{found}");
    assert!(findings.iter().all(|finding| finding["track"].as_str().unwrap().contains("0001")));
    assert_eq!(findings[0]["fault"]["kind"], "swapped_sides");
    assert_eq!(findings[0]["index"], 20);
    // Nobody's way gets shorter by so many torsos.
    assert_eq!(code(&["check-labels", ".", "--swap-gain", "1000"]), Some(0));
    // On a smaller image, feet are outside.
    assert_eq!(code(&["check-labels", "0000.poses.csv", "--image-size", "346x150"]), Some(2));
    let message = sandbox.fails(&["check-labels", ".", "--swap-gain", "nan"]);
    assert!(message.contains("expected a number from 0"), "{message}");
}

#[test]
fn skeletons_and_annotations_are_checked() {
    let sandbox = Sandbox::new();
    let clip = golden("h36m/yarp/cam2_S9_Walking_1");
    let (_, said) = sandbox.ends(&["check-labels", clip.to_str().unwrap()]);
    assert!(said.starts_with("5 frames of 1 tracks"), "{said}");

    // Of settings and reports beside annotations, none is taken for labels.
    let folder = golden("h36m/yarp").display().to_string();
    sandbox.ok(&["prepare", "eh36m", &folder, "--out", "data"]);
    let (_, said) = sandbox.ends(&["check-labels", "data"]);
    assert!(said.starts_with("3 frames of 1 tracks"), "{said}");

    std::fs::remove_dir_all(sandbox.path("data/eros")).unwrap();
    let message = sandbox.fails(&["check-labels", "data/test.json"]);
    assert!(message.contains("--image-size") && message.contains("test.json"), "{message}");
    let message = sandbox.fails(&["check-labels", "data/eros"]);
    assert!(message.contains("data/eros"), "{message}");
    std::fs::create_dir(sandbox.path("empty")).unwrap();
    let message = sandbox.fails(&["check-labels", "empty"]);
    assert!(message.contains("no labels: expected annotations"), "{message}");
}
