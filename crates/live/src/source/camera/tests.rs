//! Without a camera.
use super::*;

#[test]
fn a_camera_that_is_not_there_is_said_to_be_missing_and_which_are_known() {
    let message = CameraSource::open(Some("no-such-serial-number")).err().unwrap().to_string();
    assert!(message.starts_with("camera: "), "{message}");
    // Where there is no USB at all, or no right to it, that is said.
    let is_clear = message
        .contains("no `no-such-serial-number` is connected; types are davis346, ")
        || message.contains("USB")
        || message.contains("udev");
    assert!(is_clear, "{message}");
}
