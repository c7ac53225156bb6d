use std::fs;

use evpose_core::Plane;
use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage};
use tempfile::TempDir;

use super::*;
use crate::sample::file;

/// An array as NumPy writes it.
fn array(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    [b"\x93NUMPY\x01\x00\x76\x00", format!("{header:<117}\n").as_bytes(), data].concat()
}

fn folder(images: &[(&str, DynamicImage)]) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    for (name, image) in images {
        image.save(directory.path().join(name)).unwrap();
    }
    directory
}

fn grey(code: u8) -> DynamicImage {
    GrayImage::from_pixel(2, 1, Luma([code])).into()
}

fn all(source: &mut FrameSource) -> Result<Vec<Vec<f32>>, IoError> {
    let mut frame = Plane::for_sensor(source.size(), 0.0);
    let mut frames = Vec::new();
    while source.next_into(&mut frame)? {
        frames.push(frame.data().to_vec());
    }
    Ok(frames)
}

fn linear(path: &Path) -> Result<Vec<Vec<f32>>, IoError> {
    all(&mut FrameSource::open(path, Encoding::Linear, None)?)
}

#[track_caller]
fn fault(result: Result<Vec<Vec<f32>>, IoError>) -> (String, FrameFault) {
    match result.unwrap_err() {
        IoError::Frames { path, fault } => {
            (path.file_name().unwrap().to_string_lossy().into_owned(), fault)
        }
        other => panic!("{other}"),
    }
}

#[test]
fn images_come_in_natural_order_relative_to_white() {
    let images = [("f10.png", grey(51)), ("f9.png", grey(255)), ("f1.PNG", grey(0))];
    let directory = folder(&images);
    fs::write(directory.path().join("notes.txt"), "not an image").unwrap();
    let frames = linear(directory.path()).unwrap();
    assert_eq!(frames, [[0.0; 2], [1.0; 2], [0.2; 2]]);
    let source = FrameSource::open(directory.path(), Encoding::Linear, Some(102.0));
    assert_eq!(all(&mut source.unwrap()).unwrap()[2], [0.5; 2]);
}

#[test]
fn jpeg_images_are_frames_where_there_are_no_others() {
    let flat = |code| DynamicImage::from(GrayImage::from_pixel(8, 8, Luma([code])));
    let directory = folder(&[("f10.jpg", flat(51)), ("f9.JPEG", flat(255))]);
    assert_eq!(linear(directory.path()).unwrap(), [[1.0; 64], [0.2; 64]]);
    fs::write(directory.path().join("._f10.jpg"), "of a file system").unwrap();
    assert_eq!(linear(directory.path()).unwrap().len(), 2);
    let note = || {
        let source = FrameSource::open(directory.path(), Encoding::Linear, None).unwrap();
        source.note().map(str::to_owned)
    };
    assert_eq!(note(), None);
    flat(7).save(directory.path().join(".a.png")).unwrap();
    assert!(note().is_some_and(|note| note.ends_with("1 in all, such as .a.png")), "{:?}", note());
    flat(0).save(directory.path().join("f1.png")).unwrap();
    let message = linear(directory.path()).unwrap_err().to_string();
    assert!(message.contains("1 .png and 2 .jpg"), "{message}");
    // Previews beside frames of their names are none.
    let directory = folder(&[("f1.png", flat(0)), ("f1.jpg", flat(51))]);
    assert_eq!(linear(directory.path()).unwrap(), [[0.0; 64]]);
}

#[test]
fn images_that_are_not_read_are_no_gaps_of_a_sequence() {
    let directory = folder(&[("f1.png", grey(0)), ("f3.png", grey(51))]);
    for name in ["f4.TIFF", "f2.bmp", ".f5.webp"] {
        fs::write(directory.path().join(name), "an image").unwrap();
    }
    let (_, found) = fault(linear(directory.path()));
    assert_eq!(found, FrameFault::OtherImages { count: 2, first: "f2.bmp".to_owned() });
    let directory = folder(&[]);
    fs::write(directory.path().join("f1.webp"), "an image").unwrap();
    let message = linear(directory.path()).unwrap_err().to_string();
    assert!(message.contains("f1.webp") && message.contains("save all frames as PNG"), "{message}");
}

#[test]
fn colours_become_luminance_behind_the_curve() {
    let image = RgbImage::from_pixel(1, 1, Rgb([255, 128, 0]));
    let directory = folder(&[("0.png", image.into())]);
    let mut source = FrameSource::open(directory.path(), Encoding::Srgb, None).unwrap();
    // 128 of sRGB is 0.215861 of linear light.
    let expected = 0.2126 + 0.7152 * 0.215_861;
    assert!((all(&mut source).unwrap()[0][0] - expected).abs() < 1e-6);
    let linear = linear(directory.path()).unwrap()[0][0];
    assert!((linear - (0.2126 + 0.7152 * 128.0 / 255.0)).abs() < 1e-6);
}

#[test]
fn sixteen_bits_are_not_cut_to_eight() {
    let image: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_pixel(1, 1, Luma([257u16]));
    let directory = folder(&[("0.png", image.into())]);
    let source = FrameSource::open(directory.path(), Encoding::Linear, None).unwrap();
    assert_eq!(
        (source.depth(), source.white(), source.frames()),
        (FrameDepth::Sixteen, 65_535.0, 1)
    );
    assert!((linear(directory.path()).unwrap()[0][0] - 257.0 / 65_535.0).abs() < 1e-9);
}

#[test]
fn every_type_of_array_gives_the_same_light() {
    let expected = vec![vec![0.25, 1.0], vec![0.0, 0.5]];
    let u16s = |codes: [u16; 4]| codes.map(u16::to_le_bytes).concat();
    for (descr, white, data) in [
        ("|u1", 200.0, vec![50, 200, 0, 100]),
        ("<u2", 40_000.0, u16s([10_000, 40_000, 0, 20_000])),
        (">u2", 40_000.0, [10_000u16, 40_000, 0, 20_000].map(u16::to_be_bytes).concat()),
        ("<f2", 1.0, u16s([0x3400, 0x3c00, 0, 0x3800])),
        ("<f4", 4.0, [1.0f32, 4.0, 0.0, 2.0].map(f32::to_le_bytes).concat()),
        (">f4", 4.0, [1.0f32, 4.0, 0.0, 2.0].map(f32::to_be_bytes).concat()),
        ("<f8", 4.0, [1.0f64, 4.0, 0.0, 2.0].map(f64::to_le_bytes).concat()),
        (">f8", 4.0, [1.0f64, 4.0, 0.0, 2.0].map(f64::to_be_bytes).concat()),
    ] {
        let (_directory, path) = file("frames.npy", array(descr, "False", "(2, 1, 2)", &data));
        let mut source = FrameSource::open(&path, Encoding::Linear, Some(white)).unwrap();
        assert_eq!((source.frames(), source.size().to_string()), (2, "2x1".to_owned()), "{descr}");
        assert_eq!(all(&mut source).unwrap(), expected, "{descr}");
    }
}

#[test]
fn floats_of_bytes_are_the_light_of_bytes_and_a_note_says_so() {
    let floats = |values: [f32; 4]| {
        let data = values.map(f32::to_le_bytes).concat();
        let (_directory, path) = file("frames.npy", array("<f4", "False", "(2, 1, 2)", &data));
        let mut source = FrameSource::open(&path, Encoding::Srgb, None).unwrap();
        let note = source.note().map(str::to_owned);
        (all(&mut source).unwrap(), source.white(), note)
    };
    let (_directory, path) =
        file("frames.npy", array("|u1", "False", "(2, 1, 2)", &[0, 20, 51, 230]));
    let mut codes = FrameSource::open(&path, Encoding::Srgb, None).unwrap();
    assert_eq!(codes.note(), None);
    let (light, white, note) = floats([0.0, 20.0, 51.0, 230.0]);
    assert_eq!((light, white), (all(&mut codes).unwrap(), 255.0));
    assert!(note.unwrap().contains("`white` is not stated: it is taken to be 255"));
    assert_eq!(floats([0.0, f32::NAN, f32::INFINITY, 510.0]).1, 510.0);
    assert_eq!(floats([0.0, 1.0, 0.5, 1.9]).1, 1.0);
}

#[test]
fn images_that_differ_from_the_first_are_named() {
    let larger = GrayImage::new(2, 2).into();
    let directory = folder(&[("0.png", grey(0)), ("1.png", larger)]);
    let (name, found) = fault(linear(directory.path()));
    assert_eq!(
        (name.as_str(), found.to_string().as_str()),
        ("1.png", "2x2 pixels, but the first frame has 2x1")
    );
    let deeper: ImageBuffer<Luma<u16>, _> = ImageBuffer::new(2, 1);
    let directory = folder(&[("0.png", grey(0)), ("1.png", deeper.into())]);
    let expected = FrameFault::Depth { got: FrameDepth::Sixteen, first: FrameDepth::Eight };
    assert_eq!(fault(linear(directory.path())), ("1.png".to_owned(), expected));
}

#[test]
fn a_folder_without_images_and_a_cut_image_are_refused() {
    let directory = folder(&[]);
    assert_eq!(fault(linear(directory.path())).1, FrameFault::NoImages);
    let directory = folder(&[("0.png", grey(0)), ("1.png", grey(7))]);
    let cut = directory.path().join("1.png");
    let bytes = fs::read(&cut).unwrap();
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let (name, found) = fault(linear(directory.path()));
    assert!(name == "1.png" && matches!(found, FrameFault::Undecodable(_)), "{found}");
}

#[test]
fn an_array_that_is_not_as_long_as_it_says_is_refused() {
    let whole = array("<u2", "False", "(3, 2, 2)", &[0; 24]);
    for (length, found) in [
        (whole.len() - 1, FrameFault::Truncated { whole: 2, of: 3, byte: 144 }),
        (whole.len() - 24, FrameFault::Truncated { whole: 0, of: 3, byte: 128 }),
    ] {
        let (_directory, path) = file("frames.npy", &whole[..length]);
        assert_eq!(fault(linear(&path)).1, found);
    }
    let (_directory, path) = file("frames.npy", [whole.as_slice(), &[0]].concat());
    assert_eq!(fault(linear(&path)).1, FrameFault::Trailing(1));
    for cut in 0..128 {
        let (_directory, path) = file("frames.npy", &whole[..cut]);
        assert!(matches!(fault(linear(&path)).1, FrameFault::NotAnArray(_)), "{cut}");
    }
}

#[test]
fn arrays_of_other_shapes_types_and_orders_are_refused() {
    let found = |descr, order, shape| {
        let (_directory, path) = file("frames.npy", array(descr, order, shape, &[0; 16]));
        fault(linear(&path)).1
    };
    assert_eq!(found("|u1", "False", "(4, 4)"), FrameFault::Shape(vec![4, 4]));
    assert_eq!(found("|u1", "False", "(0, 4, 4)"), FrameFault::Shape(vec![0, 4, 4]));
    assert_eq!(found("<i4", "False", "(1, 2, 2)"), FrameFault::Type("'<i4'".to_owned()));
    assert_eq!(found("<c8", "False", "(1, 1, 2)"), FrameFault::Type("'<c8'".to_owned()));
    let advice = found("<i4", "False", "(1, 2, 2)").to_string();
    assert!(advice.contains("expected u1, u2, f2, f4 or f8: save frames.astype"), "{advice}");
    let advice = found("|u1", "True", "(1, 4, 4)").to_string();
    assert!(advice.contains("save numpy.ascontiguousarray(frames)"), "{advice}");
    assert_eq!(found("|u1", "True", "(1, 4, 4)"), FrameFault::Columns);
    assert_eq!(found("|u1", "False", "(1, 1, 70000)"), FrameFault::TooLarge(70_000, 1));
    let huge = "(18446744073709551615, 2, 2)";
    assert!(matches!(
        found("|u1", "False", huge),
        FrameFault::NotAnArray(_) | FrameFault::Truncated { .. }
    ));
}

#[test]
fn codes_are_read_as_they_were_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("codes.npy");
    let size = SensorSize { width: 3, height: 1 };
    write_codes(&path, size, &[vec![0, 51, 255], vec![102, 0, 0]]).unwrap();
    assert_eq!(linear(&path).unwrap(), [[0.0, 0.2, 1.0], [0.4, 0.0, 0.0]]);
    assert!(write_codes(&path, size, &[vec![0; 4]]).is_err());
}

#[test]
fn white_is_a_positive_number() {
    let (_directory, path) = file("frames.npy", array("|u1", "False", "(1, 1, 1)", &[0]));
    for white in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let opened = FrameSource::open(&path, Encoding::Linear, Some(white));
        assert!(matches!(opened, Err(IoError::Frames { fault: FrameFault::White, .. })));
    }
}

#[test]
fn an_encoding_is_one_of_two_words() {
    assert_eq!("srgb".parse(), Ok(Encoding::Srgb));
    assert!("sRGB".parse::<Encoding>().is_err());
}
