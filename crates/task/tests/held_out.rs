//! No training of an embedded config draws what is kept for evaluation: activities, people, motions,
//! surroundings.

#![allow(clippy::unwrap_used, reason = "tests")]

use evpose_body::activity::{HELD_OUT_ACTIVITIES, activity_by_name};
use evpose_sim::Simulation;
use evpose_sim::person::{People, PeopleConfig};
use evpose_task::Experiment;
use evpose_task::body::BodyConfig;
use evpose_task::hand::HandConfig;

/// Sequences of each set that are compared with all of every other set.
const SEQUENCES: u64 = 6;

fn embedded<C: Experiment>(folder: &str) -> Vec<(&'static str, C)> {
    let files = evpose_configs::FILES.iter().filter(|(path, _)| path.starts_with(folder));
    files.map(|(path, text)| (*path, C::unchecked(text, &[]).unwrap())).collect()
}

fn bodies() -> Vec<(&'static str, BodyConfig)> {
    embedded("body/")
}

fn is_held_out(name: &str) -> bool {
    HELD_OUT_ACTIVITIES.iter().any(|activity| activity.name == name)
}

/// Values that identify a recording: two with one of them in common share a person, a motion or a
/// scene.
#[derive(Debug, PartialEq)]
struct Drawn {
    set: String,
    shape: Vec<f32>,
    pose: Vec<f32>,
    luminance: Vec<f32>,
}

impl Drawn {
    fn is_shared_with(&self, other: &Self) -> bool {
        self.shape == other.shape || self.pose == other.pose || self.luminance == other.luminance
    }
}

fn people(set: &str, config: &PeopleConfig, seed: u64) -> Vec<Drawn> {
    // Pools are compared where they are made; few images and outfits are enough to draw people.
    let config = PeopleConfig {
        outfits: config.outfits.min(2),
        surroundings: evpose_sim::person::SurroundingsConfig {
            source: evpose_sim::config::BackgroundSource::Procedural(2),
            ..config.surroundings.clone()
        },
        ..config.clone()
    };
    let people = People::new(&config, seed).unwrap();
    let drawn = |index| {
        let mut sequence = people.sequence(index).unwrap();
        let shape = sequence.betas().to_vec();
        let step = sequence.advance().unwrap();
        Drawn {
            set: format!("{set}, sequence {index}"),
            shape,
            pose: step.joints_m.iter().flat_map(|joint| joint.to_array()).collect(),
            luminance: step.luminance.data().to_vec(),
        }
    };
    (0..SEQUENCES).map(drawn).collect()
}

fn hands(set: &str, config: &HandConfig) -> Vec<Drawn> {
    let simulation = Simulation::new(&config.simulation, config.seed).unwrap();
    let drawn = |index| {
        let mut sequence = simulation.sequence(index).unwrap();
        let step = sequence.advance().unwrap();
        Drawn {
            set: format!("{set}, sequence {index}"),
            shape: step.episode.betas.clone(),
            pose: step.points_m.iter().flat_map(|point| point.to_array()).collect(),
            luminance: step.luminance.data().to_vec(),
        }
    };
    (0..SEQUENCES).map(drawn).collect()
}

fn assert_disjoint(training: &[Drawn], held_out: &[Drawn]) {
    assert!(training.len() >= SEQUENCES as usize && held_out.len() >= SEQUENCES as usize);
    for a in training {
        for b in held_out {
            assert!(!a.is_shared_with(b), "{} shares something with {}", a.set, b.set);
        }
    }
}

#[test]
fn training_activities_are_none_of_those_held_out() {
    for (path, config) in bodies() {
        let simulation = &config.simulation.activities;
        assert!(!simulation.is_empty());
        for name in simulation {
            assert!(activity_by_name(name).is_some() && !is_held_out(name), "{path}: {name}");
        }
        // Stills have no evaluation of their own.
        let evaluated = &config.evaluation.activities;
        let kept = evaluated.iter().filter(|name| is_held_out(name)).count();
        assert!(evaluated.is_empty() || kept == HELD_OUT_ACTIVITIES.len(), "{path}: {evaluated:?}");
    }
}

#[test]
fn no_embedded_config_trains_on_people_motions_or_scenes_that_one_evaluates_on() {
    let sets = |held_out: bool| -> Vec<Drawn> {
        let configs = bodies().into_iter().flat_map(|(path, config)| {
            let config = if held_out { config.held_out() } else { config };
            people(path, &config.simulation, config.seed)
        });
        configs.collect()
    };
    assert_disjoint(&sets(false), &sets(true));

    let configs = embedded::<HandConfig>("hand/");
    let sets = |held_out: bool| -> Vec<Drawn> {
        let sets = configs.iter().flat_map(|(path, config)| {
            let config = if held_out { config.held_out() } else { config.clone() };
            hands(path, &config)
        });
        sets.collect()
    };
    assert_disjoint(&sets(false), &sets(true));
}

#[test]
fn a_recording_that_is_in_both_sets_is_noticed() {
    let (_, config) = bodies().swap_remove(0);
    let training = people("training", &config.simulation, config.seed);
    let again = people("the same seed", &config.simulation, config.seed);
    assert!(training.iter().zip(&again).all(|(a, b)| a.is_shared_with(b)));
}

#[test]
fn held_out_people_have_bodies_and_motions_of_the_program() {
    let overrides = [
        r#"simulation.body={makehuman="datasets/makehuman"}"#,
        r#"simulation.motion={cmu="datasets/cmu"}"#,
    ];
    let text = evpose_configs::FILES.iter().find(|(path, _)| *path == "body/wide.toml").unwrap().1;
    let config = BodyConfig::parse(text, &overrides.map(str::to_owned)).unwrap();
    let (own, held_out) = (&config.simulation, config.held_out().simulation);
    assert!(own.body != held_out.body && own.motion != held_out.motion);
    let plain = BodyConfig::parse(text, &[]).unwrap().held_out().simulation;
    assert_eq!((held_out.body, held_out.motion), (plain.body, plain.motion));
}
