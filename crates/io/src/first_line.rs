//! Texts that are no recordings, named by their first line: the tables and lists of evpose among them, which
//! would otherwise be taken for tables of events with other names.

use evpose_core::bytes_without_bom;
use evpose_pose::PARAMETER_NAMES;

/// Digits of a SHA-256 digest.
const DIGEST: usize = 64;

/// Ends of the names of a joint's columns; tables of events have none.
const OF_JOINTS: [&str; 2] = ["_u_px", "_x_m"];
/// How all tables of poses begin that evpose writes, those of other values than joints among them.
const OF_POSES: &str = "t_us,origin,latency_ms,score";

/// The kind of a text that begins so, and advice; none for texts of events and unknown ones.
pub(crate) fn describe(head: &[u8]) -> Option<(&'static str, &'static str)> {
    let mut lines = bytes_without_bom(head).split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let line = lines.find(|line| !line.is_empty() && !line.starts_with(b"#"))?;
    let line = str::from_utf8(line).ok()?;
    if line == "file,t_us" {
        return Some(("the list of a folder of `evpose represent`", "give the recording itself"));
    }
    if line == "x,y,on_hz,off_hz" {
        let what = "a table of hot pixels of `evpose calibrate noise`";
        return Some((what, "`evpose clean --with hot` leaves out those of a recording"));
    }
    if is_of_poses(line) {
        return Some((
            "a table of poses of evpose",
            "give it as --joints to `evpose view`, beside its recording",
        ));
    }
    if is_digest(line) {
        return Some((
            "a list of digests",
            "`evpose info --verify DIR` checks the files of its folder",
        ));
    }
    if is_yaml(line) {
        return Some(("a YAML document", "a calibration is given as --camera"));
    }
    let configs =
        "configs are given to `evpose simulate` and `evpose train`, calibrations as --camera";
    if is_toml(line) {
        return Some(("a TOML document", configs));
    }
    match line.as_bytes().first()? {
        b'{' => Some((
            "a JSON document",
            "labels are given to `evpose prepare`, poses to `evpose view --joints`, calibrations as --camera",
        )),
        b'[' => Some(("a JSON or TOML document", configs)),
        _ => None,
    }
}

fn is_of_poses(line: &str) -> bool {
    let mut names = line.split(',').map(|name| name.trim().trim_matches('"'));
    let is_of_joint = |name: &str| OF_JOINTS.iter().any(|suffix| name.ends_with(suffix));
    let is_of_parameter = |name: &str| PARAMETER_NAMES.contains(&name);
    line.starts_with(OF_POSES)
        || (names.clone().any(|name| name == "t_us")
            && names.any(|name| is_of_joint(name) || is_of_parameter(name)))
}

/// `DIGEST  NAME`, or `DIGEST *NAME` for a binary file.
fn is_digest(line: &str) -> bool {
    line.split_at_checked(DIGEST).is_some_and(|(digest, name)| {
        digest.bytes().all(|byte| byte.is_ascii_hexdigit()) && name.starts_with(' ')
    })
}

fn is_yaml(line: &str) -> bool {
    let is_key = |key: &str| is_word(key) && key.starts_with(|c: char| c.is_ascii_alphabetic());
    line.starts_with("%YAML")
        || line == "---"
        || line
            .split_once(':')
            .is_some_and(|(key, value)| is_key(key) && (value.is_empty() || value.starts_with(' ')))
}

fn is_toml(line: &str) -> bool {
    let is_key = |key: &str| key.split('.').all(|part| is_word(part.trim().trim_matches('"')));
    let is_header =
        line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).is_some_and(is_key);
    is_header || line.split_once('=').is_some_and(|(key, _)| is_key(key.trim()))
}

fn is_word(text: &str) -> bool {
    let is_of_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    !text.is_empty() && text.chars().all(is_of_word)
}

#[cfg(test)]
mod tests {
    use evpose_pose::JointFrame;

    use crate::poses::{PoseColumns, PoseKind};
    use crate::{Input, OpenOptions, read_as};

    const BLOB: &str = include_str!("../../../examples/task/blob.toml");
    /// As OpenCV 4 writes it.
    const OPENCV: &str = "%YAML:1.0\n---\nimage_width: 346\nimage_height: 260\n";
    const ROS: &str = "image_width: 346\nimage_height: 260\ncamera_name: davis\n";

    fn message(text: &str) -> String {
        let input = Input::memory("file.csv", text.as_bytes().to_vec());
        read_as(input, &OpenOptions::default()).unwrap_err().to_string()
    }

    #[test]
    fn tables_and_lists_of_evpose_and_configs_are_named() {
        let frame = Some(JointFrame::Camera);
        let body = PoseColumns::of_frame(PoseKind::Body, frame).header();
        let hand = PoseColumns::of(PoseKind::Hand).header();
        let digest = "0a".repeat(32);
        for (text, what) in [
            (format!("{body}1000,sim,,\n"), "a table of poses"),
            (format!("{hand}1000,sim,,\n"), "a table of poses"),
            ("t_us,head_u_px,head_v_px,tail_u_px\n1,2,3,4\n".to_owned(), "a table of poses"),
            ("file,t_us\n000000.npy,1000\n".to_owned(), "`evpose represent`"),
            ("x,y,on_hz,off_hz\n3,4,120.0000,3.0000\n".to_owned(), "hot pixels"),
            (format!("{digest}  0000.raw\n{digest}  0001.raw\n"), "a list of digests"),
            (format!("{digest} *0000.raw\n"), "a list of digests"),
            (BLOB.to_owned(), "a TOML document"),
            ("# made by hand\n\n[simulation.camera]\nfocal_px = 3\n".to_owned(), "a TOML document"),
            (OPENCV.to_owned(), "a YAML document: a calibration is given as --camera"),
            ("---\ncam0:\n  K: [1]\n".to_owned(), "a YAML document"),
            (ROS.to_owned(), "a YAML document"),
            ("cam0:\n  camera_model: pinhole\n".to_owned(), "a YAML document"),
        ] {
            for text in [text.clone(), format!("\u{feff}{text}")] {
                let message = message(&text);
                assert!(
                    message.contains("no recording, it is ") && message.contains(what),
                    "{message}"
                );
            }
        }
    }

    #[test]
    fn tables_of_events_are_none_of_them() {
        for text in [
            "t_us,x,y,p\n5,96,133,0\n9,97,12,1\n",
            "-5 96 133 0\n9 97 12 1\n",
            "# made by hand\n5 96 133 0\n9 97 12 1\n",
            "t_us,x,y,p,frame\n5,96,133,0,7\n9,97,12,1,7\n",
            "t_us,x,y,on,file\n5,96,133,0,a\n9,97,12,1,a\n",
        ] {
            let input = Input::memory("file.csv", text.as_bytes().to_vec());
            let read = read_as(input, &OpenOptions::default()).map(|read| read.stream.len());
            assert_eq!(read.ok(), Some(2), "{text}");
        }
    }
}
