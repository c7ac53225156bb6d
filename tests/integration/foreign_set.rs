//! The test set of recordings that no simulation of this project made is what it was when it was sealed.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::harness::bytes;

fn set() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/foreign")
}

/// Every file below `directory`, as a path from the set with slashes.
fn files(directory: &Path, of: &Path, into: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, of, into);
        } else {
            let names = path.strip_prefix(of).unwrap().iter();
            let names: Vec<_> = names.map(|name| name.to_str().expect("a name of text")).collect();
            into.insert(names.join("/"));
        }
    }
}

#[test]
fn the_foreign_set_is_what_was_sealed() {
    let sums = String::from_utf8(bytes(&set().join("SHA256SUMS"))).expect("text");
    // The list itself is in no list.
    let mut summed = BTreeSet::from(["SHA256SUMS".to_owned()]);
    for line in sums.lines() {
        let (sum, name) = line.split_once("  ").expect("as sha256sum writes them");
        let digest = Sha256::digest(bytes(&set().join(name)));
        assert_eq!(format!("{digest:x}"), sum, "{name}");
        assert!(summed.insert(name.to_owned()), "{name} is summed twice");
    }
    let mut there = BTreeSet::new();
    files(&set(), &set(), &mut there);
    // No file of the set is missing from the list.
    assert_eq!(there, summed);
    let ends = |ending: &str| there.iter().filter(|name| name.ends_with(ending)).count();
    assert_eq!((ends(".poses.csv"), ends(".joints.csv")), (BODIES, HANDS));
    assert_eq!((ends(".npz"), ends(".toml")), (BODIES + HANDS, BODIES + HANDS));
}

const BODIES: usize = 16;
const HANDS: usize = 14;

/// Gestures of a hand follow each other without gaps, from the start of the recording to its end, and
/// each finger has one of three states.
#[test]
fn gestures_cover_each_recording_of_a_hand() {
    let mut named = BTreeSet::new();
    for number in 0..HANDS {
        let file = |ending: &str| {
            let path = set().join(format!("hands/{number:02}.{ending}"));
            String::from_utf8(bytes(&path)).expect("text")
        };
        let info: toml::Table = file("toml").parse().expect("TOML");
        let table = file("gestures.csv");
        let mut lines = table.lines();
        let header = "start_us,end_us,gesture,thumb,index,middle,ring,pinky";
        assert_eq!(lines.next(), Some(header));
        let mut end = 0;
        for line in lines {
            let fields: Vec<&str> = line.split(',').collect();
            // No gap and no overlap: each begins where the last ended.
            assert_eq!(fields[0].parse::<i64>().unwrap(), end, "{number:02}: {line}");
            let next = fields[1].parse().unwrap();
            assert!(next > end, "{number:02}: {line}");
            end = next;
            let states = &fields[3..];
            assert_eq!(states.len(), 5, "{number:02}: {line}");
            let known = |state: &&str| ["extended", "bent", "between"].contains(state);
            assert!(states.iter().all(known), "{number:02}: {line}");
            named.insert(fields[2].to_owned());
        }
        assert_eq!(Some(end), info["duration_us"].as_integer(), "{number:02}");
    }
    // Between two gestures there is a transition.
    assert!(named.remove("transition"));
    assert!(named.len() >= 12, "{named:?}");
}
