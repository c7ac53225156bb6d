//! Frames in a page with a slider, above the event rate over time.

use std::fmt::Write as _;

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::Rgb;

use super::ViewArgs;
use super::frames::RenderedFrames;
use super::key::Key;
use evpose_report::html::{HtmlPage, escape};
use evpose_report::png::png;

/// Width of frame, slider and rate, in pixels of the page, at most.
const WIDTH: f64 = 1000.0;
/// Height of the rate in pixels of the page.
const HEIGHT: f64 = 70.0;
/// How high the busiest frame is.
const CURVE: f64 = 56.0;
/// Everything above and below the frame, which leaves the frame what the window has beside it;
/// but no less than a width at which it can be seen.
const BESIDE_PX: u32 = 410;
const MIN_PX: u32 = 240;
/// Half the thumb of a slider, which its middle stays away from the ends of the slider.
const THUMB_PX: u32 = 8;
/// Labels of the time axis.
const MAX_TICKS: f64 = 10.0;

pub(super) fn page(frames: &RenderedFrames, args: &ViewArgs) -> Result<Vec<u8>> {
    let subtitle = format!(
        "{} of a {} sensor: {}. The first event is at {:.6} s of the file's clock.",
        args.of,
        frames.reader.sensor,
        frames.reader.summary(),
        frames.reader.origin.as_seconds()
    );
    let mut page = HtmlPage::new(&frames.reader.name, &subtitle);
    page.markup(&player(frames)?);
    for warning in &frames.reader.warnings() {
        page.markup(&format!("<p class=\"soft\">Warning: {}</p>", escape(warning)));
    }
    page.markup(&script(frames, args.fps)?);
    Ok(page.finish().into_bytes())
}

fn player(frames: &RenderedFrames) -> Result<String> {
    // Not the first, in which often nothing moves yet.
    let begin = frames.busiest();
    let (Some(shown), Some(last)) = (frames.frames.get(begin), frames.frames.last()) else {
        return Ok(String::new());
    };
    let (width, height) = shown.image.dimensions();
    Ok(format!(
        "<style>.view{{width:min(100%,{WIDTH}px,max({MIN_PX}px,(100vh - {BESIDE_PX}px)*{width}/{height}))}}\
         .view img{{display:block;height:auto;width:100%}}\
         .view input{{width:100%;margin:8px 0 0}}.view p{{margin:2px 0 6px;max-width:none}}\
         .view button{{font:inherit;padding:2px 14px}}.view .key:first-child{{margin-left:0}}\
         .rate{{margin:0 {THUMB_PX}px;position:relative;height:{HEIGHT}px;\
         background:#fff;outline:1px solid var(--line)}}\
         .rate svg{{width:100%;height:100%;display:block}}\
         .axis{{margin:2px {THUMB_PX}px 0;position:relative;height:1.5em;font-size:13px}}\
         .axis span{{position:absolute;transform:translateX(-50%)}}</style>\n\
         <div class=\"view\">{}<img id=\"frame\" alt=\"{}\" src=\"data:image/png;base64,{}\">\n\
         <input id=\"time\" type=\"range\" min=\"0\" max=\"{}\" value=\"{begin}\" aria-label=\"time\">\n\
         {}<p><button id=\"play\">play</button> <span id=\"caption\">{:.3} s, {} events</span> \
         <span class=\"soft\">of {:.3} s; arrow keys step, space plays</span></p></div>",
        legend(&frames.keys),
        escape(&frames.reader.name),
        STANDARD.encode(png(&shown.image)?),
        frames.frames.len() - 1,
        rate(frames),
        shown.t.as_seconds(),
        shown.events,
        last.t.as_seconds(),
    ))
}

/// A line that says which colour is what.
fn legend(keys: &[Key]) -> String {
    if keys.is_empty() {
        return String::new();
    }
    let entries = keys.iter().map(|key| {
        let Rgb([r, g, b]) = key.colour;
        let meaning = match key.name {
            "ON" | "OFF" => format!("{} events", key.name),
            name => format!("{name} joints"),
        };
        format!("<span class=\"key\" style=\"background:rgb({r},{g},{b})\"></span>{meaning}")
    });
    format!("<p>{}</p>\n", entries.collect::<String>())
}

/// Events per second at each frame, above a time axis: both as wide as the way of the slider's thumb,
/// so that the thumb stands above the time of its frame.
fn rate(frames: &RenderedFrames) -> String {
    let most = frames.max_events().max(1) as f64;
    // Bars are centred below the thumb, so that half of the first and of the last is outside.
    let step = WIDTH / (frames.frames.len() - 1).max(1) as f64;
    let mut path = format!("M0 {HEIGHT}");
    for (k, frame) in frames.frames.iter().enumerate() {
        // A burst in the first frame may be far higher than all others.
        let share = (frame.events as f64 / most).min(HEIGHT / CURVE);
        let y = HEIGHT - CURVE * share;
        let end = ((k as f64 + 0.5) * step).min(WIDTH);
        // Writing to a string does not fail.
        let _ = write!(path, "V{y:.1}H{end:.1}");
    }
    let per_second = most / frames.reader.every.as_seconds();
    let times = frames.frames.first().zip(frames.frames.last());
    let (start_s, end_s) = times.map_or((0.0, 0.0), |(a, b)| (a.t.as_seconds(), b.t.as_seconds()));
    let labels = ticks(start_s, end_s).into_iter().map(|(t_s, text)| {
        let place = 100.0 * (t_s - start_s) / (end_s - start_s).max(1e-9);
        format!("<span style=\"left:{place:.3}%\">{text}</span>")
    });
    format!(
        "<p class=\"soft\">event rate, at most {} events/s{}</p>\
         <div class=\"rate\"><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" preserveAspectRatio=\"none\">\
         <path d=\"{path}V{HEIGHT}Z\" fill=\"#b9c4d6\"/>\
         <rect id=\"now\" x=\"0\" y=\"0\" width=\"3\" height=\"{HEIGHT}\" fill=\"#d55e00\"/></svg></div>\
         <div class=\"axis\">{}</div><p class=\"soft\">time since the first event, s</p>",
        amount(per_second),
        if frames.frames.len() > 1 { " after the first frame" } else { "" },
        labels.collect::<String>()
    )
}

/// Times that are labelled, with their labels.
fn ticks(start_s: f64, end_s: f64) -> Vec<(f64, String)> {
    let span = end_s - start_s;
    if span <= 0.0 {
        return vec![(start_s, format!("{start_s:.3}"))];
    }
    let power = (span / MAX_TICKS).log10().floor() as i32;
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * 10_f64.powi(power));
    let step = steps.into_iter().find(|step| span / step <= MAX_TICKS).unwrap_or(steps[3]);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    // The margin saves the last label from rounding.
    let (first, last) = ((start_s / step).ceil() as i64, (end_s / step + 1e-9).floor() as i64);
    let tick = |k: i64| (k as f64 * step, format!("{:.decimals$}", k as f64 * step));
    (first..=last).map(tick).collect()
}

/// A number of events as people say it.
fn amount(events: f64) -> String {
    match events {
        n if n >= 1e6 => format!("{:.1} million", n / 1e6),
        n if n >= 1e3 => format!("{:.1} thousand", n / 1e3),
        n => format!("{n:.0}"),
    }
}

/// Shows the frame that the slider says; the frames themselves are in it.
fn script(frames: &RenderedFrames, fps: f64) -> Result<String> {
    let mut rows = String::new();
    for frame in &frames.frames {
        let text = STANDARD.encode(png(&frame.image)?);
        let _ = write!(rows, "[{:.6},{},\"{text}\"],", frame.t.as_seconds(), frame.events);
    }
    Ok(format!(
        "<script>const P=[{rows}];let k=0,timer=null;const at=i=>document.getElementById(i);\n\
         function show(n){{k=Math.max(0,Math.min(P.length-1,n));const[t,e,p]=P[k];\
         at('frame').src='data:image/png;base64,'+p;at('time').value=k;\
         at('caption').textContent=t.toFixed(3)+' s, '+e+' events';\
         at('now').setAttribute('x',k*{WIDTH}/Math.max(1,P.length-1)-1.5)}}\n\
         function play(){{if(timer){{clearInterval(timer);timer=null}}else{{\
         timer=setInterval(()=>show((k+1)%P.length),{:.1})}}\
         at('play').textContent=timer?'pause':'play'}}\n\
         at('time').oninput=()=>show(+at('time').value);at('play').onclick=play;\n\
         document.onkeydown=e=>{{if(e.target.tagName=='INPUT')return;\
         if(e.key=='ArrowRight')show(k+1);if(e.key=='ArrowLeft')show(k-1);\
         if(e.key==' '){{e.preventDefault();play()}}}};show({})</script>",
        1000.0 / fps,
        frames.busiest()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_axis_has_round_labels() {
        let labels = |start_s, end_s| -> Vec<String> {
            ticks(start_s, end_s).into_iter().map(|(_, label)| label).collect()
        };
        assert_eq!(
            labels(0.1, 1.0),
            ["0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1.0"]
        );
        assert_eq!(labels(0.33, 4.0), ["0.5", "1.0", "1.5", "2.0", "2.5", "3.0", "3.5", "4.0"]);
        assert_eq!(
            labels(0.0, 3600.0),
            ["0", "500", "1000", "1500", "2000", "2500", "3000", "3500"]
        );
        assert_eq!(labels(0.5, 0.5), ["0.500"]);
    }
}
