//! The path of a step through a chain, which follows from the properties of its stages.

use crate::Recovery;
use crate::traits::{ActsOn, Compares, Traits};

/// How a step goes through a chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ExecutionPlan {
    pub(crate) division: Division,
    pub(crate) path: PixelPath,
    /// Pixels whose light is that of the step before are left out.
    pub(crate) skips_unchanged: bool,
    /// Pixels wait for the readout, and their requests go through a queue in order of time.
    pub(crate) is_queued: bool,
    /// Pixels can be refractory, or wait, beyond the end of a step.
    pub(crate) has_refractory_states: bool,
    /// Voltages and memories are rounded to single precision as published.
    pub(crate) is_single: bool,
    /// The recovery of a pixel from an event, of all terms.
    pub(crate) recovery: Recovery,
    /// A term changes what holds until the next event.
    pub(crate) renews: bool,
    pub(crate) steps_while_refractory: bool,
}

/// The largest parts of the sensor that go through a step one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Division {
    /// All pixels: one sees the voltage of another, or its events have times that depend on others.
    Whole,
    /// Blocks, each through the whole step before the next one begins.
    Blocks,
    /// The same, in bands at the same time: no stage needs the whole plane.
    Bands,
}

/// The way from the voltage of a pixel to its events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PixelPath {
    /// Crossings of levels, under steady leaks and recovery alone: several pixels at once.
    Crossings,
    /// Crossings of levels, with thresholds that change or memories that step while refractory.
    Levels,
    /// Crossings of levels that are drawn anew at every exposure.
    RedrawnLevels,
    /// Crossings of levels that a formula moves.
    VaryingLevels,
    /// A burst at the end of the frame, and nothing else.
    Bursts,
    /// Events of a frame, at its end.
    Frames,
    /// Events of a frame, spread over the step.
    SpreadFrames,
    /// Events that the detector is asked for one by one.
    Asked,
}

impl ExecutionPlan {
    /// The fastest path on which `stages`, in any order, have the events that they have on every
    /// other.
    pub(crate) fn choose(stages: &[Traits]) -> Self {
        let any = |has: fn(&Traits) -> bool| stages.iter().any(has);
        let is_static_on = |signal| {
            stages.iter().filter(|stage| stage.acts_on == signal).all(|stage| stage.is_static)
        };
        let recovery = stages.iter().fold(Recovery::default(), |all, s| all.and(s.recovery));
        // The detector alone says what it compares: other stages have the default, the least.
        let compares = stages.iter().map(|stage| stage.compares).max().unwrap_or_default();
        let (spreads, renews) = (any(|stage| stage.spreads), any(|stage| stage.renews));
        let steps_while_refractory = any(|stage| stage.steps_while_refractory);
        let sees_voltages = any(|stage| stage.acts_on == ActsOn::VoltagePlane);
        // Rounding as published needs the photoreceptor's voltages, which no stage has changed.
        let is_single = any(|stage| stage.rounds_as_published)
            && !sees_voltages
            && !any(|stage| stage.acts_on == ActsOn::Voltage);
        let is_immediate = is_static_on(ActsOn::Requests);
        let has_refractory_states = recovery.is_refractory() || !is_immediate;
        // Voltages of neighbours and the largest count are known only behind all pixels.
        let division = match () {
            () if sees_voltages || spreads => Division::Whole,
            () if any(|stage| stage.acts_on == ActsOn::LightPlane) => Division::Blocks,
            () => Division::Bands,
        };
        // All events of a step in one go: nothing may change a pixel between two of them.
        let has_bursts = is_static_on(ActsOn::Pixels) && !is_single && !has_refractory_states;
        let path = match compares {
            Compares::Frames if spreads => PixelPath::SpreadFrames,
            Compares::Frames if has_bursts => PixelPath::Bursts,
            Compares::Frames => PixelPath::Frames,
            Compares::Levels if any(|stage| stage.varies) => PixelPath::VaryingLevels,
            Compares::Levels if any(|stage| stage.redraws.is_some()) => PixelPath::RedrawnLevels,
            Compares::Levels if renews || steps_while_refractory => PixelPath::Levels,
            Compares::Levels => PixelPath::Crossings,
            Compares::Voltage | Compares::Light => PixelPath::Asked,
        };
        Self {
            division,
            path,
            // A plane carries the change of one pixel to others, which would be left out.
            skips_unchanged: division == Division::Bands && stages.iter().all(|s| s.is_static),
            // Only where levels are compared do pixels wait; else the readout delays events.
            is_queued: !is_immediate && compares == Compares::Levels,
            has_refractory_states,
            is_single,
            recovery,
            renews,
            steps_while_refractory,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Division::{Bands, Blocks, Whole};
    use super::PixelPath::{
        Asked, Bursts, Crossings, Frames, Levels, RedrawnLevels, SpreadFrames, VaryingLevels,
    };
    use super::*;

    #[test]
    fn the_path_follows_from_the_traits_of_the_stages_in_any_order() {
        let on = |acts_on| Traits { acts_on, ..Traits::default() };
        let (lens, filter, coupling) =
            (on(ActsOn::LightPlane), on(ActsOn::Voltage), on(ActsOn::VoltagePlane));
        let (flicker, leak, bus) = (on(ActsOn::Light), on(ActsOn::Pixels), on(ActsOn::Requests));
        let pattern = Traits { is_static: true, ..leak };
        let levels = Traits { compares: Compares::Levels, ..pattern };
        let frames = Traits { compares: Compares::Frames, ..pattern };
        let count = Traits { spreads: true, rounds_as_published: true, ..frames };
        let light = Traits { compares: Compares::Light, ..leak };
        let renewal = Traits { renews: true, ..leak };
        let formula = Traits { varies: true, ..leak };
        let redraw = Traits { redraws: Some(0.1), ..leak };
        let refractory = Recovery { refractory_s: 1e-3, ..Recovery::default() };
        let refractory = Traits { recovery: refractory, ..leak };
        let stepping = Traits { steps_while_refractory: true, ..refractory };
        // Behind division and path: skips unchanged pixels, is queued, is refractory, is single.
        let (yes, no) = (true, false);
        for (stages, division, path, rest) in [
            (&[levels][..], Bands, Crossings, [yes, no, no, no]),
            (&[levels, pattern], Bands, Crossings, [yes, no, no, no]),
            (&[flicker, levels], Bands, Crossings, [no, no, no, no]),
            (&[lens, levels], Blocks, Crossings, [no, no, no, no]),
            (&[filter, levels], Bands, Crossings, [no, no, no, no]),
            (&[lens, coupling, levels], Whole, Crossings, [no, no, no, no]),
            (&[levels, leak], Bands, Crossings, [no, no, no, no]),
            (&[levels, refractory], Bands, Crossings, [no, no, yes, no]),
            (&[levels, renewal], Bands, Levels, [no, no, no, no]),
            (&[levels, stepping], Bands, Levels, [no, no, yes, no]),
            (&[levels, redraw, renewal], Bands, RedrawnLevels, [no, no, no, no]),
            (&[levels, formula, redraw], Bands, VaryingLevels, [no, no, no, no]),
            (&[levels, bus], Bands, Crossings, [no, yes, yes, no]),
            (&[frames], Bands, Bursts, [yes, no, no, no]),
            (&[flicker, frames, pattern], Bands, Bursts, [no, no, no, no]),
            (&[frames, leak], Bands, Frames, [no, no, no, no]),
            (&[frames, redraw], Bands, Frames, [no, no, no, no]),
            (&[frames, bus], Bands, Frames, [no, no, yes, no]),
            (&[count], Whole, SpreadFrames, [no, no, no, yes]),
            (&[count, filter], Whole, SpreadFrames, [no, no, no, no]),
            (&[count, coupling], Whole, SpreadFrames, [no, no, no, no]),
            (&[light], Bands, Asked, [no, no, no, no]),
            (&[light, bus], Bands, Asked, [no, no, yes, no]),
            (&[leak], Bands, Asked, [no, no, no, no]),
        ] {
            let backwards: Vec<Traits> = stages.iter().rev().copied().collect();
            for stages in [stages, &backwards] {
                let plan = ExecutionPlan::choose(stages);
                assert_eq!((plan.division, plan.path), (division, path), "{stages:?}");
                let ExecutionPlan { skips_unchanged, is_queued, .. } = plan;
                let found =
                    [skips_unchanged, is_queued, plan.has_refractory_states, plan.is_single];
                assert_eq!(found, rest, "{stages:?}");
            }
        }
    }
}
