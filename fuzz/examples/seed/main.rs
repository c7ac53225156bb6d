//! Writes what the targets start from: the files that other programs wrote, of the tests of
//! `evpose-io`, and one of every kind that those lack.
//!
//! `cargo run --release --example seed -- FOLDER` makes `FOLDER/TARGET/…`.

mod glb;
mod models;
// The models of random numbers that the tests of `evpose-body` read.
#[path = "../../../crates/body/src/files/tests/synthetic.rs"]
mod synthetic;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

// Where `synthetic` looks for it.
use evpose_body::skeleton;
use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::{FORMATS, MetaWriter, frames};

/// Targets that read the files of each folder of `tests/golden`, by the end of their names.
const GOLDEN: &[(&str, &str, &[&str])] = &[
    ("aedat2", ".aedat", &["aedat2"]),
    ("aedat4", ".aedat4", &["aedat4", "aedat4-packets"]),
    ("aedat4-network", ".bin", &["streams"]),
    ("expelliarmus", ".dat", &["dat"]),
    ("expelliarmus", ".raw", &["evt2"]),
    ("hdf5", "5", &["hdf5"]),
    ("nmnist", ".bin", &["nmnist"]),
    ("numpy", ".npy", &["npy"]),
    ("numpy", ".npz", &["npz"]),
    ("ros", ".mcap", &["mcap"]),
    ("ros", ".bag", &["rosbag"]),
    ("ros/evt3-sqlite", ".db3", &["rosbag2"]),
    ("text", "t", &["text"]),
    ("text", ".csv", &["csv"]),
    ("yarp", ".log", &["yarp-log"]),
];

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let folder = std::env::args_os().nth(1).ok_or("which folder? FOLDER/TARGET/… is made")?;
    let folder = PathBuf::from(folder);
    golden(&folder)?;
    written(&folder)?;
    beside(&folder)?;
    models::write(&folder)
}

fn put(folder: &Path, target: &str, name: &str, bytes: &[u8]) -> Result<PathBuf> {
    let folder = folder.join(target);
    fs::create_dir_all(&folder)?;
    let path = folder.join(name);
    fs::write(&path, bytes)?;
    Ok(path)
}

fn golden(folder: &Path) -> Result<()> {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/io/tests/golden");
    for (kind, end, targets) in GOLDEN {
        for entry in fs::read_dir(from.join(kind))? {
            let path = entry?.path();
            let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
            if !name.ends_with(end) {
                continue;
            }
            for target in targets.iter().chain(&["any"]) {
                put(folder, target, name, &fs::read(&path)?)?;
            }
        }
    }
    Ok(())
}

/// A recording in every format that is written.
fn written(folder: &Path) -> Result<()> {
    let sensor = SensorSize { width: 34, height: 34 };
    let event = |k: i64| Event {
        t: Micros(1000 * (k / 3)),
        x: (k % 34) as u16,
        y: (k * k % 34) as u16,
        polarity: Polarity::from_on(k % 5 < 2),
    };
    let events = EventStream::from_events(sensor, (0..60).map(event))?;
    for format in FORMATS.iter().filter(|format| format.create.is_some()) {
        let target = format.name.replace("evt2.1", "evt21");
        let path = put(folder, &target, "written", b"")?;
        format.write(&path, &events)?;
        let bytes = fs::read(path)?;
        put(folder, "any", format.name, &bytes)?;
        if format.name == "evc" {
            put(folder, "evc-frames", "written", &bytes)?;
        }
        if format.name == "aedat4" {
            put(folder, "aedat4-packets", "written", &bytes)?;
        }
        if matches!(format.name, "aedat4" | "framed") {
            put(folder, "streams", format.name, &bytes)?;
        }
    }
    let word = |k: u32| (k % 34) << 12 | (k % 34) << 1 | k % 2;
    let pairs = |k: u32| [k.to_le_bytes(), word(k).to_le_bytes()].concat();
    let binary: Vec<u8> = (0..60).flat_map(pairs).collect();
    put(folder, "yarp-binary", "made", &binary)?;
    put(folder, "any", "yarp-binary", &binary)?;
    arrays(folder)
}

/// Events as other programs keep them in NumPy's arrays.
fn arrays(folder: &Path) -> Result<()> {
    let array = |descr: &str, shape: &str, data: &[u8]| {
        let order = "'fortran_order': False";
        let header = format!("{{'descr': {descr}, {order}, 'shape': {shape}, }}");
        [b"\x93NUMPY\x01\0\x76\0", format!("{header:<117}\n").as_bytes(), data].concat()
    };
    let bytes = |values: &[f64]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let table = array("'<f8'", "(2, 4)", &bytes(&[0.5, 3.0, 4.0, 1.0, 0.75, 5.0, 6.0, 0.0]));
    let fields = "[('t', '<u4'), ('x', '<u2'), ('y', '>u2'), ('p', '|b1')]";
    let records = array(fields, "(2,)", &[5, 0, 0, 0, 1, 0, 0, 2, 1, 7, 0, 0, 0, 3, 0, 0, 4, 0]);
    for (name, bytes) in [("table.npy", &table), ("records.npy", &records)] {
        put(folder, "npy", name, bytes)?;
        put(folder, "any", name, bytes)?;
    }
    let t = array("'<f4'", "(2,)", &[0, 0, 0, 63, 0, 0, 64, 63]);
    let x = array("'<i2'", "(2,)", &[1, 0, 2, 0]);
    let y = array("'|u1'", "(2, 1)", &[3, 4]);
    let p = array("'|b1'", "(2,)", &[0, 1]);
    let size = array("'<i8'", "()", &34_i64.to_le_bytes());
    put(folder, "npz-arrays", "columns", &[t, x, y, p, size.clone(), size].concat())?;
    put(folder, "npz-arrays", "table", &table)?;
    put(folder, "npz-arrays", "records", &records)?;
    let frames = array("'>f2'", "(2, 3, 4)", &[0x3c; 48]);
    put(folder, "frames-npy", "halves", &frames)?;
    Ok(())
}

/// Labels, skeletons, frames, settings.
fn beside(folder: &Path) -> Result<()> {
    let path = put(folder, "meta", "written", b"")?;
    let mut labels = MetaWriter::create_for_hands(&path)?;
    for k in 0..3 {
        labels.record(&[f64::from(k); 12])?;
    }
    labels.finish()?;
    let joints = "1.5 20 ".repeat(13);
    let skeletons = format!("0 0.12 SKLT ({joints}) -1.0 104.3\n1 0.24 SKLT ({joints}) 3 4\n");
    put(folder, "yarp-skeletons", "two", skeletons.as_bytes())?;
    let path = put(folder, "frames-npy", "codes", b"")?;
    let size = SensorSize { width: 4, height: 3 };
    frames::write_codes(&path, size, &[vec![7; 12], vec![9; 12]])?;
    let images = [
        ("grey", image::DynamicImage::new_luma8(4, 3)),
        ("colours", image::DynamicImage::new_rgb16(2, 2)),
        ("alpha", image::DynamicImage::new_rgba8(3, 1)),
    ];
    for (name, image) in images {
        let path = put(folder, "frames-png", name, b"")?;
        image.save_with_format(path, image::ImageFormat::Png)?;
    }
    let sensor = "sensor = { width = 9, height = 7 }\n";
    let mask = format!(
        "{sensor}pixels = [[8, 6]]\nrectangles = [{{ x = 1, y = 2, width = 3, height = 4 }}]\n"
    );
    let camera = format!(
        "{sensor}focal_px = [252.9, 253.1]\nprincipal_px = [5.0, 3.5]\ndistortion = [-0.3, 0.1, 0, 0]\n"
    );
    put(folder, "settings", "mask", mask.as_bytes())?;
    put(folder, "settings", "camera", camera.as_bytes())?;
    Ok(())
}
