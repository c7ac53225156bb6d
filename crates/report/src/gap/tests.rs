use evpose_gap::report::ReportData;
use evpose_gap::verdict::Answer;

use super::{example, page};

#[test]
fn a_page_holds_everything_and_needs_no_other_file() {
    let page = page(&example::data()).unwrap();
    for text in [
        "Missing effect: leak_on",
        "charge leaks off the memory",
        "rate_hz = 2.04 Hz [1.95, 2.11]",
        "Excess here",
        "displacement, the longest 1.25 px",
        "leak_on added",
        "by the logarithm",
        "What explains the gap",
        "cannot be distinguished from",
        "4% of the discrepancy is left",
        "with no effect",
        "leak_on and parasitic_photo_leak",
        "never busy &lt;enough&gt;",
        "How could this be wrong?",
        "class=\"add\">+ [[effect]]",
        "events.npz &amp; more",
        "+810%",
    ] {
        assert!(page.contains(text), "{text} is missing");
    }
    let links = page.matches("http").count();
    let names = page.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(links, names, "something is fetched from elsewhere");
    assert!(!page.replace("isNaN", "").contains("NaN"));
}

#[test]
fn a_bare_verdict_is_a_page_too() {
    let answers = [
        (Answer::NoGap, "No gap"),
        (Answer::Parameter, "set wrong"),
        (Answer::Effects, "Missing effect"),
        (Answer::Partial, "Explained in part, by leak_on; 4% of the gap is unexplained"),
        (Answer::NoneOfCatalogue, "Something is missing"),
        (Answer::Undecided, "does not determine why"),
    ];
    for (answer, text) in answers {
        let mut verdict = example::verdict();
        verdict.verdict = answer;
        let data = ReportData::from_verdict(verdict);
        assert!(page(&data).unwrap().contains(text), "{answer:?}");
    }
}

/// `CHANGELOG.md` lists the names of earlier releases.
#[test]
fn a_report_of_an_earlier_release_is_read() {
    let path = std::path::Path::new("report.json");
    let data = example::data();
    let mut json = data.to_json(path).unwrap();
    for (new, old) in [
        ("\"discrepancy\"", "\"misfit\""),
        ("\"discrepancy_without\"", "\"misfit_without\""),
        ("\"side_by_side\"", "\"film\""),
        ("\"images\"", "\"pictures\""),
        ("\"swapped\"", "\"exchanged\""),
        ("\"dropped\"", "\"taken_out\""),
        ("\"log_intensity_step\"", "\"swing\""),
    ] {
        assert!(json.contains(new), "{new}");
        json = json.replace(new, old);
    }
    // Plots have values that are NaN, so that the data itself is not equal.
    let back = ReportData::from_json(&json, path).unwrap();
    assert_eq!(page(&back).unwrap(), page(&data).unwrap());
}

/// Schema 1 said whether something is left, and not what fraction.
#[test]
fn a_verdict_of_schema_1_is_read() {
    let path = std::path::Path::new("report.json");
    let mut json: serde_json::Value =
        serde_json::from_str(&example::data().to_json(path).unwrap()).unwrap();
    let verdict = json["verdict"].as_object_mut().unwrap();
    verdict["schema"] = 1.into();
    verdict["effects"][0].as_object_mut().unwrap().remove("explained");
    let mut left = verdict.remove("unexplained").unwrap();
    for field in ["fraction", "p", "shares"] {
        left.as_object_mut().unwrap().remove(field);
    }
    verdict.insert("remaining".to_owned(), left);
    let data = ReportData::from_json(&json.to_string(), path).unwrap();
    let page = page(&data).unwrap();
    assert!(
        page.contains("Missing effect: leak_on") && page.contains("What is missing or set wrong")
    );
    assert!(!page.contains("fraction of the gap as given") && !page.contains("unknown"), "{page}");
}

#[test]
fn a_report_is_read_back_as_it_was_written() {
    let path = std::path::Path::new("report.json");
    let data = example::data();
    let json = data.to_json(path).unwrap();
    let back = ReportData::from_json(&json, path).unwrap();
    assert_eq!(page(&back).unwrap(), page(&data).unwrap());
}
