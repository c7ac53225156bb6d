#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| evpose_fuzz::read("rosbag2", bytes));
