//! Grey, blur and Canny against what OpenCV made of the same images: `tests/golden/eros_like`.

mod images;

use std::path::Path;

use evpose_core::Plane;
use evpose_repr::{
    Aperture, BlurWork, Canny, CannyWork, ColourOrder, ErosLike, ErosLikeWork, GaussianKernel,
    GradientNorm, grey_from_colour,
};
use sha2::{Digest, Sha256};

const DIGESTS: &str = include_str!("../golden/eros_like/digests.txt");

/// Low, high, aperture and norm of edges beside those of EROS-like images, in the order of their
/// digest.
const OTHER_EDGES: [(u16, u16, Aperture, GradientNorm); 8] = [
    (0, 1000, Aperture::Five, GradientNorm::L1),
    (50, 150, Aperture::Three, GradientNorm::L1),
    (150, 50, Aperture::Three, GradientNorm::L1),
    (60, 200, Aperture::Three, GradientNorm::L2),
    (600, 1800, Aperture::Five, GradientNorm::L2),
    (0, 1000, Aperture::Five, GradientNorm::L2),
    (1000, 4000, Aperture::Seven, GradientNorm::L1),
    (1000, 4007, Aperture::Seven, GradientNorm::L2),
];

fn hex(parts: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    parts.iter().for_each(|part| hash.update(part));
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Digests of image, grey, blur 5x5, blur 7x7, edges of the blurred image, edges of the image.
/// One memory for all images, as a training pipeline has it.
fn steps(image: &Plane<u8>, blurs: &mut BlurWork, edges: &mut CannyWork) -> [String; 6] {
    let colours = images::coloured(image);
    let mut grey = vec![0; image.data().len()];
    grey_from_colour(&colours, ColourOrder::Rgb, &mut grey);
    let empty = Plane::filled(0, 0, 0);
    let (mut five, mut seven, mut outline) = (empty.clone(), empty.clone(), empty.clone());
    GaussianKernel::Five.blur(image, blurs, &mut five);
    GaussianKernel::Seven.blur(image, blurs, &mut seven);
    Canny::default().draw(&five, edges, &mut outline);
    let others = OTHER_EDGES.map(|(low, high, aperture, norm)| {
        let mut out = empty.clone();
        Canny { low, high, aperture, norm }.draw(image, edges, &mut out);
        out
    });
    [
        hex(&[image.data()]),
        hex(&[&grey]),
        hex(&[five.data()]),
        hex(&[seven.data()]),
        hex(&[outline.data()]),
        hex(&others.each_ref().map(Plane::data)),
    ]
}

#[test]
fn grey_blur_and_edges_are_those_of_opencv() {
    let (mut blurs, mut edges) = (BlurWork::default(), CannyWork::default());
    let mut expected = DIGESTS.lines();
    for (name, image) in images::all() {
        let line: Vec<_> = expected.next().unwrap().split_whitespace().collect();
        assert_eq!(line[0], name);
        let got = steps(&image, &mut blurs, &mut edges);
        let steps = ["image", "grey", "blur 5x5", "blur 7x7", "edges", "other edges"];
        for ((step, got), expected) in steps.iter().zip(&got).zip(&line[1..]) {
            assert_eq!(got, expected, "{step} of {name}");
        }
    }
    assert_eq!(expected.next(), None);
}

#[test]
fn blue_first_gives_the_same_grey() {
    let image = &images::all()[24].1;
    let mut colours = images::coloured(image);
    let (mut rgb, mut bgr) = (vec![0; image.data().len()], vec![0; image.data().len()]);
    grey_from_colour(&colours, ColourOrder::Rgb, &mut rgb);
    colours.as_chunks_mut::<3>().0.iter_mut().for_each(|pixel| pixel.reverse());
    grey_from_colour(&colours, ColourOrder::Bgr, &mut bgr);
    assert_eq!(rgb, bgr);
}

#[test]
fn a_conversion_is_its_steps_and_depends_on_the_seed_alone() {
    let (mut work, mut out) = (ErosLikeWork::default(), Plane::filled(0, 0, 0));
    // Six times as much: 5 of 256 below and 5 above in the script, 30 and 30 in the class.
    let class = ErosLike::class_defaults();
    assert_eq!((class.black_below, class.white_above), (30, 225));
    for config in [ErosLike::default(), class] {
        for (_, image) in &images::all()[20..] {
            config.convert_into(image, 5, &mut work, &mut out);
            let (mut blurs, mut blurred) = (BlurWork::default(), Plane::filled(0, 0, 0));
            let mut edges = Plane::filled(0, 0, 0);
            config.blur.blur(image, &mut blurs, &mut blurred);
            config.canny.draw(&blurred, &mut CannyWork::default(), &mut edges);
            evpose_repr::pepper(&mut edges, config.pepper_below, 5);
            let (low, high) = (config.black_below, config.white_above);
            evpose_repr::salt_and_pepper(&mut edges, low, high, 5);
            config.final_blur.blur(&edges, &mut blurs, &mut blurred);
            assert_eq!(out, blurred);
            let image = image.clone();
            let elsewhere = std::thread::spawn(move || config.convert(&image, 5));
            assert_eq!(elsewhere.join().unwrap(), out);
        }
    }
}

#[test]
fn the_noise_of_a_seed_stays_as_it_is() {
    // Of this program alone: published data sets can be made again.
    let (_, image) = &images::all()[24];
    assert_eq!(hex(&[ErosLike::default().convert(image, 1).data()]), NOISY);
}

const NOISY: &str = "12b1d7cfcdf82e52c002f2d5b9beaad3a3098d9138c3eb5d5fec4cb14bef921b";

/// Writes the images that the digests were made of, for other programs.
#[test]
#[ignore = "writes files into the directory that EVPOSE_IMAGES names"]
fn images_are_written_for_other_programs() {
    let directory = std::env::var("EVPOSE_IMAGES").expect("a directory in EVPOSE_IMAGES");
    for (name, image) in images::all() {
        let (width, height) = (image.width(), image.height());
        for (kind, ending, data) in
            [(5, "pgm", image.data()), (6, "ppm", &images::coloured(&image))]
        {
            let mut file = format!("P{kind} {width} {height} 255\n").into_bytes();
            file.extend_from_slice(data);
            std::fs::write(Path::new(&directory).join(format!("{name}.{ending}")), file).unwrap();
        }
    }
}
