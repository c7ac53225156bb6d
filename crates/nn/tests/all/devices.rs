//! Devices agree on the outputs of the hand network.

use evpose_nn::DeviceKind;
use evpose_nn::weights::load_pytorch;

use crate::golden::{data, golden, images, small, values, worst};

#[test]
fn ndarray_and_flex_agree_on_the_hand_network() {
    let outputs = |kind: DeviceKind| {
        let device = kind.resolve().unwrap();
        let network = load_pytorch(&data("small_zip.ckpt"), &small(), &device).unwrap();
        values(network.forward(images(2, 45, 60, &device)))
    };
    let (flex, ndarray) = (outputs(DeviceKind::Flex), outputs(DeviceKind::Ndarray));
    let difference = worst(&flex, &ndarray);
    assert!(difference < 1e-5, "{difference}");
    assert!(worst(&ndarray, &golden().checkpoint["45x60"]) < 1e-4);
}
