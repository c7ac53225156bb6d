//! `evpose bench repr`: how fast representations take events in and are drawn, on one core.

mod events;
mod image_share;
mod photograph;
mod plain;

use std::hint::black_box;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_core::{EventStream, Micros, Plane, SensorSize};
use evpose_io::FORMATS;
use evpose_repr::{
    BlurWork, Canny, CannyWork, ChannelOrder, Eros, ErosConfig, ErosFramer, GaussianKernel,
    REPRESENTATIONS, Representation, StreamWindow, representation_by_name,
};
use serde::Serialize;

use image_share::ImageShare;

use crate::all::Figure;
use crate::peer_bench::{
    Case, CaseResult, Run, is_named, matching, run_peers, time, warn_under_load,
};
use crate::peer_bench::{PEERS, PeerCommand};
use evpose_cli::json::write_json;
use evpose_cli::machine::Machine;
use evpose_cli::outputs::OutputFile;
use evpose_cli::progress::say;
use evpose_cli::provenance::Provenance;
use evpose_cli::ranges::{count, within};

#[derive(Debug, clap::Args)]
#[command(after_help = format!("Examples:\n  evpose bench repr\n  \
    evpose bench repr --only eros --only 640x480 --json repr.json\n  \
    evpose bench repr --only 'image share'\n  \
    evpose bench repr --peer 'tonic=python3 peer.py'\n\n{PEERS}"))]
pub struct BenchReprArgs {
    /// Events in 100 ms
    #[arg(long, default_value_t = 1_000_000, value_parser = within(1..=1_000_000_000_usize))]
    pub(crate) events: usize,
    /// Times each case runs; the median counts
    #[arg(long, default_value_t = 31, value_parser = count::<usize>())]
    pub(crate) passes: usize,
    /// Only cases with this in their name; given twice, with both
    #[arg(long, value_name = "WORD")]
    pub(crate) only: Vec<String>,
    /// Image for blur and Canny, of the size it has [default: discs, shades and grain, 1000x1000]
    #[arg(long, value_name = "FILE")]
    pub(crate) image: Option<PathBuf>,
    /// Another program on the same events, in the same run (may be repeated)
    #[arg(long = "peer", value_name = "NAME=COMMAND")]
    pub(crate) peers: Vec<PeerCommand>,
    /// Where to write the results as JSON
    #[arg(long)]
    pub(crate) json: Option<OutputFile>,
}

const SENSORS: [SensorSize; 2] = [SensorSize { width: 640, height: 480 }, SensorSize::DAVIS240C];
/// Length of a window, and of the events.
const WINDOW: Micros = Micros(100_000);

/// Content of the JSON file.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    provenance: Provenance,
    events: usize,
    cases: Vec<CaseResult>,
    image_shares: Vec<ImageShare>,
}

pub(crate) fn run(args: &BenchReprArgs) -> Result<()> {
    let mut report = measure(args)?;
    report.image_shares = image_share::measure(args.events, args.passes, &args.only)?;
    write_json(args.json.as_deref(), &report)
}

pub(crate) fn figures(args: &BenchReprArgs) -> Result<Vec<Figure>> {
    Ok(measure(args)?.cases.iter().map(|case| case.figure("repr")).collect())
}

/// Times the cases; shares of images are left out.
fn measure(args: &BenchReprArgs) -> Result<Report> {
    let provenance = Provenance::new(Machine { threads: 1, ..Machine::this() });
    say(format!("machine   {}", provenance.machine));
    say(format!(
        "events    {} in {} ms: a hundred blobs that wander, and every tenth event noise",
        args.events,
        WINDOW.0 / 1000
    ));
    let cases = cases(args.events, args.image.as_deref())?;
    let has_shares = image_share::are_named(&args.only);
    // If shares alone were asked for, the cases, which take minutes, are left out.
    let has_cases = cases.iter().any(|case| is_named(&case.name, &args.only));
    let mut lines = match has_cases || !has_shares {
        true => time(matching(cases, &args.only)?, args.passes)?,
        false => Vec::new(),
    };
    if !args.peers.is_empty() {
        let folder = tempfile::tempdir().context("making a folder for the events")?;
        for sensor in SENSORS {
            let path = folder.path().join(format!("wandering-{sensor}.npz"));
            let npz = FORMATS.find("npz").context("npz is a format")?;
            // The same events as ours, since peers read them from this file.
            npz.write(path, &events::wandering(sensor, args.events))?;
        }
        run_peers(&args.peers, folder.path(), &mut lines)?;
    }
    warn_under_load(&lines);
    let (events, image_shares) = (args.events, Vec::new());
    Ok(Report { provenance, events, cases: lines, image_shares })
}

/// Updates by a stream that goes on, images of it, whole windows at once, and images made like
/// EROS.
fn cases(count: usize, photograph: Option<&Path>) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for sensor in SENSORS {
        let streams = [
            ("wandering", events::wandering(sensor, count)),
            ("uniform", events::uniform(sensor, count)),
        ];
        for (kind, events) in &streams {
            for name in REPRESENTATIONS.iter().map(|entry| entry.name) {
                let case = Case::of_events(
                    format!("{name} update {sensor} {kind}"),
                    events.len(),
                    update(name, events)?,
                );
                // Two have plain loops to be compared with.
                cases.push(match name {
                    "eros" => case.with_peer("plain loop over squares", plain::eros(events)),
                    "lnes" => case.with_peer("plain loop over events", plain::lnes(events)),
                    _ => case,
                });
            }
        }
        let events = &streams[0].1;
        for name in REPRESENTATIONS.iter().map(|entry| entry.name) {
            cases.push(Case::of_image(format!("{name} image {sensor}"), image(name, events)?));
        }
        for name in ["eci", "voxel-grid"] {
            let name = (name, format!("{name} of a window {sensor}"));
            cases.push(Case::of_events(name.1, events.len(), window(name.0, events)?));
        }
    }
    cases.push(Case::of_image("eros image 8 bits blurred to 192x192", framer(count)));
    let image = photograph::grey_image(photograph)?;
    let name = format!("blur and Canny {}x{}", image.width(), image.height());
    cases.push(Case::of_image(name, canny(image)));
    Ok(cases)
}

fn stream_window(sensor: SensorSize) -> Result<StreamWindow> {
    Ok(StreamWindow::new(sensor, WINDOW, ChannelOrder::OffFirst)?)
}

fn update(name: &str, events: &EventStream) -> Result<Run> {
    let mut running = representation_by_name(name)?.start(stream_window(events.sensor())?);
    let events = events.clone();
    Ok(Box::new(move || {
        running.push(&events);
        Ok(())
    }))
}

fn image(name: &str, events: &EventStream) -> Result<Run> {
    let mut running = representation_by_name(name)?.start(stream_window(events.sensor())?);
    running.push(events);
    let mut planes = vec![0.0; running.channels() * events.sensor().pixels()];
    Ok(Box::new(move || {
        running.render(&mut planes);
        black_box(&planes);
        Ok(())
    }))
}

/// A recording's worth of events at once, planes included.
fn window(name: &str, events: &EventStream) -> Result<Run> {
    let mut running = representation_by_name(name)?.start(stream_window(events.sensor())?);
    let mut planes = vec![0.0; running.channels() * events.sensor().pixels()];
    let events = events.clone();
    Ok(Box::new(move || {
        running.reset();
        running.push(&events);
        running.render(&mut planes);
        black_box(&planes);
        Ok(())
    }))
}

/// Input image of the body network.
fn framer(count: usize) -> Run {
    let mut eros = Eros::hpe_core(SENSORS[0], ErosConfig::ONLINE);
    eros.push(&events::wandering(SENSORS[0], count));
    let mut framer = ErosFramer::new(SENSORS[0], 192, 192);
    let mut image = vec![0; 192 * 192];
    Box::new(move || {
        framer.resized(&eros, &mut image);
        black_box(&image);
        Ok(())
    })
}

/// The first half of what MoveEnet makes of an image.
fn canny(image: Plane<u8>) -> Run {
    let (mut blurring, mut drawing) = (BlurWork::default(), CannyWork::default());
    let mut blurred = Plane::filled(image.width(), image.height(), 0);
    let mut edges = blurred.clone();
    Box::new(move || {
        GaussianKernel::Five.blur(&image, &mut blurring, &mut blurred);
        Canny::default().draw(&blurred, &mut drawing, &mut edges);
        black_box(&edges);
        Ok(())
    })
}
