//! A recording: every pixel of the sensor, its background, the readout and the clock.

use rayon::prelude::*;

use crate::background::background_spikes;
use crate::circuit::Circuit;
use crate::clock::stamp;
use crate::event::{DURATION_S, HEIGHT, Recording, Spike, WIDTH, sort_spikes};
use crate::light::Light;
use crate::pixel::{Seeds, pixel_spikes};
use crate::readout::read_out;
use crate::scene::Scene;

/// Records a scene. The result depends on the arguments alone, not on the number of threads.
pub fn record(circuit: &Circuit, scene: &Scene, seeds: Seeds) -> Recording {
    let light = Light::new(scene, &circuit.optics);
    let mut spikes: Vec<Spike> = (0..(WIDTH * HEIGHT) as u32)
        .into_par_iter()
        .flat_map_iter(|pixel| {
            let (x, y) = (pixel as usize % WIDTH, pixel as usize / WIDTH);
            let mut spikes =
                pixel_spikes(circuit, seeds, pixel, DURATION_S, |t_s| light.log_light(x, y, t_s));
            spikes.extend(background_spikes(&circuit.background, seeds, pixel, DURATION_S));
            spikes
        })
        .collect();
    // The readout serves in the order of time, whichever thread was first.
    sort_spikes(&mut spikes);
    let read = read_out(&circuit.readout, seeds, spikes);
    let events = stamp(&circuit.clock, circuit.noise_address, seeds, &read, DURATION_S);
    Recording { events, width: WIDTH, height: HEIGHT, duration_s: DURATION_S }
}
