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
        (Answer::Partial, "Explained in part, by leak_on; 4% is unexplained"),
        (Answer::NoneOfCatalogue, "Something is missing"),
        (Answer::Undecided, "does not determine why"),
    ];
    for (answer, text) in answers {
        let mut verdict = example::verdict();
        verdict.verdict = answer;
        let data = ReportData::from_verdict(verdict);
        let page = page(&data).unwrap();
        assert!(page.contains(text), "{answer:?}");
        // A formula explains, too.
        assert!(!page.contains("Nothing explains the gap"), "{answer:?}");
    }
}

#[test]
fn a_report_is_read_back_as_it_was_written() {
    let path = std::path::Path::new("report.json");
    let data = example::data();
    let json = data.to_json(path).unwrap();
    let back = ReportData::from_json(&json, path).unwrap();
    assert_eq!(page(&back).unwrap(), page(&data).unwrap());
}
