//! The page with a simulated figure or hand: `cargo run -p evpose-live --example page [hand]`.
//!
//! Events and poses are simulated; the pipeline, its latencies and its rates are real. With
//! `--seconds S` it ends after so long, with `--port P` it listens there.

#![allow(clippy::print_stdout, reason = "a program")]

mod actor;
mod figure;
mod hand;
mod simulated;

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use evpose_live::page::{Page, PageInfo};
use evpose_live::sink::Sinks;
use evpose_live::{Control, LiveOptions, run};
use evpose_pose::stream::PoseStream;

use actor::Actor;
use simulated::{SimulatedFrontend, SimulatedNetwork, SimulatedSource};

/// Time for which the last frame stays after the end of the source.
const LINGER: Duration = Duration::from_secs(10);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut is_hand, mut seconds, mut port) = (false, f64::INFINITY, 8000);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "hand" => is_hand = true,
            "--seconds" => seconds = arguments.next().ok_or("--seconds takes a number")?.parse()?,
            "--port" => port = arguments.next().ok_or("--port takes a number")?.parse()?,
            other => return Err(format!("{other}: there is `hand`, --seconds, --port").into()),
        }
    }
    let actor: Arc<dyn Actor> =
        if is_hand { Arc::new(hand::Hand::new()) } else { Arc::new(figure::Figure) };

    let mut control = Control::default();
    let info = PageInfo {
        title: format!("A {} that moves", if is_hand { "hand" } else { "figure" }),
        source: "simulated".to_owned(),
        sensor: actor::SENSOR,
        skeleton: actor.skeleton(),
        hosts: Vec::new(),
        hand_mesh: actor.mesh(),
    };
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    let page = Page::serve(address, info, control.meter.clone())?;
    let view = page.view();
    control.observer = Some(Arc::new(move |events| view.push(events)));
    let mut sinks = Sinks::new();
    sinks.add(page.sink());
    println!("http://{}", page.local_addr());

    let source = SimulatedSource::new(actor.clone(), seconds);
    let task = PoseStream::new(SimulatedFrontend::new(actor.clone()), SimulatedNetwork::new(actor));
    run(Box::new(source), task, &mut sinks, &LiveOptions::default(), &control)?;
    sinks.finish()?;
    std::thread::sleep(LINGER);
    Ok(())
}
