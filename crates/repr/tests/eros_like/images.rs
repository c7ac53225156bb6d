//! Images made by arithmetic on integers, the same on every machine.

use evpose_core::{CounterRng, Plane};

pub(crate) type Named = (&'static str, Plane<u8>);

/// All images: noise, ramps, patterns, shapes, something like nature, and very small ones.
pub(crate) fn all() -> Vec<Named> {
    vec![
        ("one-pixel", noise(1, 1, 1)),
        ("one-row", noise(17, 1, 2)),
        ("one-column", noise(1, 17, 3)),
        ("two-by-two", noise(2, 2, 4)),
        ("three-by-three", noise(3, 3, 5)),
        ("five-by-seven", noise(5, 7, 6)),
        ("two-rows", noise(130, 2, 7)),
        ("three-columns", noise(3, 90, 8)),
        ("just-a-word", clouds(64, 64, 9)),
        ("a-word-and-one", clouds(65, 63, 10)),
        ("a-word-less-one", clouds(63, 65, 11)),
        ("constant", filled(97, 61, |_, _| 137)),
        ("black", filled(64, 48, |_, _| 0)),
        ("ramp-right", filled(256, 100, |x, _| x)),
        ("ramp-down", filled(101, 256, |_, y| y)),
        ("ramp-across", filled(200, 150, |x, y| (x + y) / 2)),
        ("one-step", filled(90, 70, |x, _| if x < 41 { 60 } else { 64 })),
        ("checkerboard-fine", filled(131, 77, |x, y| (x + y) % 2 * 255)),
        ("checkerboard-coarse", filled(203, 149, |x, y| (x / 8 + y / 8) % 2 * 200 + 20)),
        ("waves", filled(320, 240, waves)),
        ("zone-plate", filled(255, 255, |x, y| (x * x + y * y) / 40)),
        ("exclusive-or", filled(256, 192, |x, y| x ^ y)),
        ("noise", noise(301, 199, 12)),
        ("noise-of-two-levels", map(&noise(160, 120, 13), |v| if v < 128 { 90 } else { 110 })),
        ("clouds", clouds(640, 480, 14)),
        ("clouds-faint", map(&clouds(346, 260, 15), |v| 100 + v / 10)),
        ("clouds-in-steps", map(&clouds(333, 257, 16), |v| v / 32 * 36)),
        ("clouds-with-salt", salted(clouds(240, 180, 17), 18)),
        ("shapes", shapes(filled(400, 300, |_, _| 70), 40, 19)),
        ("glyphs", glyphs(317, 201, 20)),
        ("spiral", spiral(241)),
        ("scene", scene(1000, 1000, 21)),
    ]
}

/// Three channels out of one image, so that all weights of grey count.
pub(crate) fn coloured(image: &Plane<u8>) -> Vec<u8> {
    let (data, n) = (image.data(), image.data().len());
    (0..n).flat_map(|i| [data[i], data[(i + 7) % n], 255 - data[(i + 1001) % n]]).collect()
}

/// Only the low eight bits of the pixels' values are kept.
fn filled(width: usize, height: usize, value: impl Fn(usize, usize) -> usize) -> Plane<u8> {
    let data = (0..width * height).map(|i| value(i % width, i / width) as u8).collect();
    Plane::from_vec(width, height, data).expect("as many values as pixels")
}

fn map(image: &Plane<u8>, change: impl Fn(usize) -> usize) -> Plane<u8> {
    filled(image.width(), image.height(), |x, y| change((*image.at(x, y)).into()))
}

fn noise(width: usize, height: usize, seed: u64) -> Plane<u8> {
    let mut rng = CounterRng::new(seed, "image", 0);
    let data = (0..width * height).map(|_| rng.below(256) as u8).collect();
    Plane::from_vec(width, height, data).expect("as many values as pixels")
}

/// Noise whose spectrum falls as that of photographs: octaves of it, each half as strong as the one
/// twice as coarse, linear in between.
fn clouds(width: usize, height: usize, seed: u64) -> Plane<u8> {
    let mut sums = vec![0usize; width * height];
    for octave in 0..7 {
        let cell = 64 >> octave;
        let (columns, rows) = (width / cell + 2, height / cell + 2);
        let knots = noise(columns, rows, seed + 1000 * (octave + 1));
        let knot = |x: usize, y: usize| usize::from(*knots.at(x, y));
        for (i, sum) in sums.iter_mut().enumerate() {
            let (x, y) = (i % width, i / width);
            let (u, v) = (x % cell, y % cell);
            let (x, y) = (x / cell, y / cell);
            let upper = knot(x, y) * (cell - u) + knot(x + 1, y) * u;
            let lower = knot(x, y + 1) * (cell - u) + knot(x + 1, y + 1) * u;
            *sum += (upper * (cell - v) + lower * v) / cell;
        }
    }
    // At most 255 · 127, near half of it as a rule: the middle third fills the range.
    let scaled = sums.iter().map(|sum| (sum / 42).saturating_sub(255).min(255) as u8).collect();
    Plane::from_vec(width, height, scaled).expect("as many values as pixels")
}

/// Half waves as parabolas, of different lengths along both axes.
fn waves(x: usize, y: usize) -> usize {
    let half = |place: usize, length: usize| {
        let within = place % length;
        let height = 400 * within * (length - within) / (length * length);
        if (place / length).is_multiple_of(2) { 100 + height } else { 100 - height }
    };
    (half(x, 23) + half(y, 37) + half(x + 2 * y, 61)) * 255 / 600
}

fn salted(mut image: Plane<u8>, seed: u64) -> Plane<u8> {
    let mut rng = CounterRng::new(seed, "salt", 0);
    for pixel in image.data_mut() {
        match rng.below(20) {
            0 => *pixel = 0,
            1 => *pixel = 255,
            _ => {}
        }
    }
    image
}

/// Rectangles and ellipses of any grey.
fn shapes(mut image: Plane<u8>, count: usize, seed: u64) -> Plane<u8> {
    let mut rng = CounterRng::new(seed, "shapes", 0);
    let (width, height) = (image.width() as i64, image.height() as i64);
    for shape in 0..count {
        let (cx, cy) = (rng.below(width as usize) as i64, rng.below(height as usize) as i64);
        let (rx, ry) = (3 + rng.below(60) as i64, 3 + rng.below(60) as i64);
        let (value, slope) = (rng.below(200) as i64, rng.below(3) as i64);
        for y in (cy - ry).max(0)..(cy + ry).min(height) {
            for x in (cx - rx).max(0)..(cx + rx).min(width) {
                let (dx, dy) = (x - cx, y - cy);
                let in_ellipse = dx * dx * ry * ry + dy * dy * rx * rx < rx * rx * ry * ry;
                if shape % 2 == 0 || in_ellipse {
                    *image.at_mut(x as usize, y as usize) = (value + slope * dx.abs() / 4) as u8;
                }
            }
        }
    }
    image
}

/// Rows of signs of 5x7 dots, dark on light, each dot two pixels wide.
fn glyphs(width: usize, height: usize, seed: u64) -> Plane<u8> {
    filled(width, height, |x, y| {
        let (column, row) = (x / 14, y / 20);
        let (dot_x, dot_y) = (x % 14 / 2, y % 20 / 2);
        let bits = CounterRng::new(seed, "glyph", (row * 1000 + column) as u64).bits();
        let inked = dot_x < 5 && dot_y < 7 && bits >> (dot_y * 5 + dot_x) & 1 == 1;
        if inked { 25 } else { 235 }
    })
}

/// One path of pixels that winds to the centre and fades: only its outer end begins edges.
fn spiral(side: usize) -> Plane<u8> {
    let mut image = filled(side, side, |_, _| 50);
    let (mut x, mut y) = (4i64, 4i64);
    let (mut dx, mut dy) = (1i64, 0i64);
    let mut left = side as i64 - 9;
    let (mut turns, mut walked) = (0, 0);
    while left > 0 {
        for _ in 0..left {
            *image.at_mut(x as usize, y as usize) = (250 - walked / 3).max(65) as u8;
            (x, y, walked) = (x + dx, y + dy, walked + 1);
        }
        (dx, dy, turns) = (-dy, dx, turns + 1);
        // Two sides of a turn are as long as each other, but for the first one.
        if turns > 2 && turns % 2 == 1 || turns == 2 {
            left -= 8;
        }
    }
    image
}

/// A synthetic photograph: smooth regions with texture, things in front of each other, sensor
/// noise.
fn scene(width: usize, height: usize, seed: u64) -> Plane<u8> {
    let ground = clouds(width, height, seed);
    let things = shapes(map(&ground, |v| v / 2 + 40), 160, seed);
    let grain = noise(width, height, seed + 1);
    filled(width, height, |x, y| {
        let value = usize::from(*things.at(x, y)) * 7 / 8 + usize::from(*ground.at(x, y)) / 16;
        value + usize::from(*grain.at(x, y)) / 64
    })
}
