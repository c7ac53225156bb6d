//! Directories of sequences: shards, resumption, manifests and verification.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use evpose_sim::set::{MANIFEST, MismatchKind, verify};
use evpose_sim::{
    RecordedRun, SequenceSet, Shard, SimError, Simulation, SimulationConfig, record_all,
    record_shard,
};

use crate::support::tree;

const SEQUENCES: usize = 5;

fn simulation() -> Simulation {
    let mut config = SimulationConfig {
        image_scale: 0.15,
        sequences: SEQUENCES,
        seconds: 0.03,
        ..SimulationConfig::default()
    };
    config.skin.texels = 16;
    Simulation::new(&config, 7).unwrap()
}

fn shard(text: &str) -> Shard {
    text.parse().unwrap()
}

fn fill(directory: &Path, part: &str) -> RecordedRun {
    record_shard(&simulation(), directory, shard(part), &|_| {}).unwrap()
}

/// An undisturbed run of all sequences.
fn whole() -> (tempfile::TempDir, BTreeMap<String, Vec<u8>>) {
    let directory = tempfile::tempdir().unwrap();
    assert!(record_all(&simulation(), directory.path(), &|_| {}).unwrap().finished);
    let files = tree(directory.path());
    (directory, files)
}

#[test]
fn shards_in_any_order_leave_the_bytes_of_the_whole_run() {
    let (_whole, expected) = whole();
    // Four files, their digests, and one manifest.
    assert_eq!(expected.len(), SEQUENCES * 5 + 1);
    let directory = tempfile::tempdir().unwrap();
    for (part, finished) in [("2/3", false), ("3/3", false), ("1/3", true)] {
        assert_eq!(fill(directory.path(), part).finished, finished, "{part}");
        assert_eq!(directory.path().join(MANIFEST).exists(), finished, "{part}");
    }
    assert!(tree(directory.path()) == expected);
}

#[test]
fn shards_that_race_leave_one_manifest_with_the_same_bytes() {
    let (_whole, expected) = whole();
    for _ in 0..5 {
        let directory = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for part in ["1/5", "2/5", "3/5", "4/5", "5/5"] {
                let directory = directory.path();
                scope.spawn(move || fill(directory, part));
            }
        });
        assert!(tree(directory.path()) == expected);
    }
}

#[test]
fn shards_copied_together_get_their_manifest_from_whoever_comes_next() {
    let (_whole, expected) = whole();
    let together = tempfile::tempdir().unwrap();
    for part in ["1/2", "2/2"] {
        let alone = tempfile::tempdir().unwrap();
        assert!(!fill(alone.path(), part).finished);
        for (name, bytes) in tree(alone.path()) {
            fs::write(together.path().join(name), bytes).unwrap();
        }
    }
    let run = fill(together.path(), "1/2");
    assert_eq!((run.sequences.len(), run.reused, run.finished), (0, 3, true));
    assert!(tree(together.path()) == expected);
}

#[test]
fn what_is_not_whole_is_recorded_again_and_the_rest_is_kept() {
    let (directory, expected) = whole();
    let at = |name: &str| directory.path().join(name);
    // As a process leaves it that was killed while recording sequence 1, after the labels of
    // sequence 2, or before the digests of sequence 3 were written.
    for name in ["0001.evc", "0001.meta", "0001.toml", "0001.sha256", "0002.evc", "0002.sha256"] {
        fs::remove_file(at(name)).unwrap();
    }
    fs::write(at("0001.evc.1-0.tmp"), "half").unwrap();
    fs::write(at("0001.meta.77-3.tmp"), "half").unwrap();
    fs::remove_file(at("0003.sha256")).unwrap();
    fs::remove_file(at(MANIFEST)).unwrap();
    let untouched = fs::metadata(at("0000.evc")).unwrap().modified().unwrap();

    let set = SequenceSet::new(directory.path(), SEQUENCES);
    assert_eq!(set.unfinished(Shard::WHOLE), [1, 2, 3]);
    assert_eq!(set.unfinished(shard("2/2")), [1, 3]);
    // The other shard leaves alone what this one may be writing.
    let other = fill(directory.path(), "1/2");
    assert_eq!((other.reused, other.sequences.len(), other.leftovers), (2, 1, 0));
    let run = fill(directory.path(), "2/2");
    assert_eq!((run.reused, run.sequences.len(), run.leftovers, run.finished), (0, 2, 2, true));
    assert!(tree(directory.path()) == expected);
    assert_eq!(fs::metadata(at("0000.evc")).unwrap().modified().unwrap(), untouched);
}

#[test]
fn digests_that_are_cut_short_do_not_make_a_sequence_whole() {
    let (directory, expected) = whole();
    let path = directory.path().join("0004.sha256");
    let text = fs::read_to_string(&path).unwrap();
    let set = SequenceSet::new(directory.path(), SEQUENCES);
    for cut in 0..text.len() - 1 {
        fs::write(&path, &text[..cut]).unwrap();
        assert_eq!(set.unfinished(Shard::WHOLE), [4], "cut at {cut}");
    }
    fill(directory.path(), "5/5");
    assert!(tree(directory.path()) == expected);
}

#[test]
fn verification_names_every_file_that_is_missing_changed_or_foreign() {
    let (directory, expected) = whole();
    let read = std::sync::atomic::AtomicU64::new(0);
    let count = |bytes| {
        read.fetch_add(bytes, std::sync::atomic::Ordering::Relaxed);
    };
    let verified = verify(directory.path(), &count).unwrap();
    assert_eq!((verified.files, verified.finished, verified.leftovers), (20, true, 0));
    assert_eq!(verified.bytes, read.into_inner());

    let at = |name: &str| directory.path().join(name);
    let mut changed = expected["0002.meta"].clone();
    *changed.last_mut().unwrap() ^= 1;
    fs::write(at("0002.meta"), changed).unwrap();
    fs::remove_file(at("0003.toml")).unwrap();
    fs::write(at("0009.evc"), "not of this set").unwrap();
    fs::write(at("0001.evc.12-0.tmp"), "nobody reads it").unwrap();
    let error = verify(directory.path(), &|_| {}).unwrap_err();
    let message = error.to_string();
    let SimError::Damaged { faults, files: 20, .. } = error else { panic!("{message}") };
    let actual: Vec<(String, MismatchKind)> = faults
        .iter()
        .map(|fault| (fault.path.file_name().unwrap().to_string_lossy().into_owned(), fault.kind))
        .collect();
    let expected = [
        ("0002.meta", MismatchKind::Changed),
        ("0003.toml", MismatchKind::Missing),
        ("0009.evc", MismatchKind::Unlisted),
    ];
    assert_eq!(actual, expected.map(|(name, kind)| (name.to_owned(), kind)));
    for (name, _) in &actual {
        assert!(message.contains(name.as_str()), "{message}");
    }
}

#[test]
fn an_unfinished_set_is_verified_as_far_as_it_goes() {
    let directory = tempfile::tempdir().unwrap();
    fill(directory.path(), "1/2");
    let verified = verify(directory.path(), &|_| {}).unwrap();
    assert_eq!((verified.files, verified.finished), (12, false));
    fs::remove_file(directory.path().join("0002.sha256")).unwrap();
    let message = verify(directory.path(), &|_| {}).unwrap_err().to_string();
    assert!(message.contains("0002.evc has no digest"), "{message}");
}

#[test]
fn a_damaged_manifest_is_an_error_with_its_line() {
    let (directory, _) = whole();
    let path = directory.path().join(MANIFEST);
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("  0000.meta", "  ../0000.meta")).unwrap();
    let message = verify(directory.path(), &|_| {}).unwrap_err().to_string();
    assert!(message.contains("manifest.sha256: line 2: "), "{message}");
}

#[test]
fn no_cut_of_a_manifest_and_no_flip_of_a_digest_is_verified() {
    let (directory, expected) = whole();
    let at = |name: &str| directory.path().join(name);
    for name in [MANIFEST, "0004.sha256"] {
        let intact = &expected[name];
        let last_line = intact[..intact.len() - 1].iter().rposition(|byte| *byte == b'\n').unwrap();
        // Some of the last line, all of it, its line feed.
        for length in [last_line + 9, last_line + 1, last_line, intact.len() - 1] {
            fs::write(at(name), &intact[..length]).unwrap();
            assert!(verify(directory.path(), &|_| {}).is_err(), "{name} of {length} bytes");
        }
        for byte in (0..intact.len()).step_by(7) {
            let mut flipped = intact.clone();
            flipped[byte] ^= 1;
            fs::write(at(name), flipped).unwrap();
            assert!(verify(directory.path(), &|_| {}).is_err(), "{name}, byte {byte}");
        }
        fs::write(at(name), intact).unwrap();
        verify(directory.path(), &|_| {}).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_manifest_is_read_by_sha256sum() {
    let (directory, _) = whole();
    let output = std::process::Command::new("sha256sum")
        .args(["--check", "--strict", MANIFEST])
        .current_dir(directory.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    let lines = String::from_utf8(output.stdout).unwrap();
    assert_eq!(lines.lines().filter(|line| line.ends_with(": OK")).count(), SEQUENCES * 4);
}

/// As recordings were before joints lay beside them.
#[test]
fn a_set_without_joints_is_complete_and_verified() {
    let (directory, _) = whole();
    for path in fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name.ends_with("joints.npy") {
            fs::remove_file(path).unwrap();
        } else if name.ends_with("sha256") {
            let text = fs::read_to_string(&path).unwrap();
            let lines = text.lines().filter(|line| !line.ends_with("joints.npy"));
            fs::write(path, lines.map(|line| format!("{line}\n")).collect::<String>()).unwrap();
        }
    }
    let verified = verify(directory.path(), &|_| {}).unwrap();
    assert_eq!((verified.files, verified.finished), (15, true));
    assert_eq!(fill(directory.path(), "1/1").reused, SEQUENCES);
}
