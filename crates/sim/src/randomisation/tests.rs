use super::*;
use crate::SimulationConfig;
use crate::person::PeopleConfig;

fn parsed(text: &str) -> Randomisation {
    Randomisation::parse(text, Path::new("ranges.toml")).unwrap()
}

fn refused(text: &str) -> String {
    Randomisation::parse(text, Path::new("ranges.toml")).unwrap_err().to_string()
}

#[test]
fn every_range_of_the_program_fits_both_tasks_and_has_a_reason() {
    let wide = Randomisation::named("wide").unwrap();
    for index in 0..200 {
        wide.draw(&PeopleConfig::default(), 1, index).unwrap().validate().unwrap();
        wide.draw(&SimulationConfig::default(), 1, index).unwrap().validate().unwrap();
    }
    for task in [RandomisedTask::Body, RandomisedTask::Hand] {
        assert!(wide.reasons(task).any(|(field, _)| field == "light_level"));
    }
}

#[test]
fn draws_follow_seed_and_index_alone() {
    let wide = Randomisation::named("wide").unwrap();
    let draw = |seed, index| wide.draw(&PeopleConfig::default(), seed, index).unwrap();
    assert_eq!(draw(3, 5), draw(3, 5));
    assert_ne!(draw(3, 5), draw(3, 6));
    assert_ne!(draw(3, 5), draw(4, 5));
}

#[test]
fn an_entry_more_leaves_the_others_as_they_are() {
    let one = "[[vary]]\nfield = 'light_level'\nrange = [0.1, 1.0]\nreason = 'r'\n";
    let two = format!("[[vary]]\nfield = 'shape_range'\nrange = [0.5, 1.0]\nreason = 'r'\n{one}");
    for index in 0..10 {
        let base = PeopleConfig::default();
        let a = parsed(one).draw(&base, 1, index).unwrap();
        let b = parsed(&two).draw(&base, 1, index).unwrap();
        assert_eq!(a.light_level, b.light_level);
        assert_ne!(b.shape_range, base.shape_range);
    }
}

#[test]
fn a_logarithmic_range_has_its_geometric_mean_in_the_middle() {
    let text = "[[vary]]\nfield = 'light_level'\nrange = [0.01, 1.0]\nscale = 'log'\nreason = 'r'";
    let ranges = parsed(text);
    let below = (0..2000).filter(|&index| {
        ranges.draw(&PeopleConfig::default(), 1, index).unwrap().light_level < 0.1
    });
    // Four standard deviations of a fair coin.
    assert!((below.count() as f64 - 1000.0).abs() < 4.0 * 22.4);
}

#[test]
fn effects_are_added_and_multiples_follow_their_field() {
    let text = "[[vary]]\nfield = 'sensor.level_crossing.threshold_on'\nrange = [0.3, 0.3]\n\
                reason = 'r'\n[[vary]]\nfield = 'sensor.level_crossing.threshold_off'\n\
                range = [2.0, 2.0]\ntimes = 'sensor.level_crossing.threshold_on'\nreason = 'r'\n\
                [[vary]]\nfield = 'sensor.psf_blur.sigma_px'\nrange = [1.0, 1.0]\nreason = 'r'";
    let mut drawn = parsed(text).draw(&PeopleConfig::default(), 1, 0).unwrap();
    let chain = drawn.sensor_mut().resolve().unwrap();
    assert_eq!(chain.effect("level_crossing").unwrap().number("threshold_off"), Some(0.6));
    assert_eq!(chain.effect("psf_blur").unwrap().number("sigma_px"), Some(1.0));
}

#[test]
fn what_makes_no_sense_is_refused_with_its_field() {
    for text in [
        "[[vary]]\nfield = 'light_level'\nreason = 'r'",
        "[[vary]]\nfield = 'light_level'\nrange = [2.0, 1.0]\nreason = 'r'",
        "[[vary]]\nfield = 'light_level'\nrange = [0.0, 1.0]\nscale = 'log'\nreason = 'r'",
        "[[vary]]\nfield = 'light_level'\nrange = [0.1, 1.0]\nprobability = 2\nreason = 'r'",
        "[[vary]]\nfield = 'light_level'\nrange = [0.1, 1.0]\nreason = ''",
    ] {
        let message = refused(text);
        assert!(message.starts_with("ranges.toml: light_level: "), "{message}");
    }
    let unknown = "[[vary]]\nfield = 'light_lvl'\nrange = [0.1, 1.0]\nreason = 'r'";
    let message = parsed(unknown).draw(&PeopleConfig::default(), 1, 0).unwrap_err().to_string();
    assert!(message.contains("light_lvl"), "{message}");
    assert!(Randomisation::named("no/such.toml").is_err());
}
