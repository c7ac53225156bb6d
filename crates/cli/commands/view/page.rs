//! Frames in a page with a slider.

use std::fmt::Write as _;

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::ViewArgs;
use super::files::png;
use super::frames::RenderedFrames;
use evpose_report::html::{HtmlPage, escape};

/// Size of the curve below the frame, in pixels of the page.
const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 70.0;
/// How high the busiest frame is.
const CURVE: f64 = 56.0;
/// Everything above and below the frame, which leaves the frame what the window has beside it;
/// but no less than a width at which it can be seen.
const BESIDE_PX: u32 = 330;
const MIN_PX: u32 = 240;

/// The whole page.
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
    let begin = frames.busiest();
    let (Some(shown), Some(last)) = (frames.frames.get(begin), frames.frames.last()) else {
        return Ok(String::new());
    };
    let (width, height) = shown.image.dimensions();
    Ok(format!(
        "<style>.view{{width:min(100%,{WIDTH}px)}}.view img{{display:block;height:auto;\
         width:min(100%,max({MIN_PX}px,(100vh - {BESIDE_PX}px)*{width}/{height}))}}\
         .view input{{width:100%;margin:8px 0 0}}.view svg{{width:100%;height:{HEIGHT}px;\
         background:#fff;border:1px solid var(--line)}}.view button{{font:inherit;padding:2px 14px}}\
         .view p{{margin:2px 0 6px;max-width:none}}</style>\n\
         <div class=\"view\"><img id=\"frame\" alt=\"{}\" src=\"data:image/png;base64,{}\">\n\
         <input id=\"time\" type=\"range\" min=\"0\" max=\"{}\" value=\"{begin}\" aria-label=\"time\">\n\
         <p><button id=\"play\">play</button> <span id=\"said\">{:.3} s, {} events</span> \
         <span class=\"soft\">of {:.3} s; arrow keys step, space plays</span></p>\n{}</div>",
        escape(&frames.reader.name),
        STANDARD.encode(png(&shown.image)?),
        frames.frames.len() - 1,
        shown.t.as_seconds(),
        shown.events,
        last.t.as_seconds(),
        rate(frames),
    ))
}

/// Events a second between frames, as a filled curve.
fn rate(frames: &RenderedFrames) -> String {
    let most = frames.max_events().max(1) as f64;
    let step = WIDTH / frames.frames.len() as f64;
    let mut path = format!("M0 {HEIGHT}");
    for (k, frame) in frames.frames.iter().enumerate() {
        // A burst in the first frame may be far higher than all others.
        let share = (frame.events as f64 / most).min(HEIGHT / CURVE);
        let y = HEIGHT - CURVE * share;
        // Writing to a string does not fail.
        let _ = write!(path, "V{y:.1}H{:.1}", (k + 1) as f64 * step);
    }
    let per_second = most / frames.reader.every.as_seconds();
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" preserveAspectRatio=\"none\">\
         <path d=\"{path}V{HEIGHT}Z\" fill=\"#b9c4d6\"/>\
         <rect id=\"now\" x=\"0\" y=\"0\" width=\"{:.1}\" height=\"{HEIGHT}\" fill=\"#d55e00\" \
         fill-opacity=\"0.45\"/></svg><p class=\"soft\">events a second, {} at most after the first frame</p>",
        step.max(2.0),
        amount(per_second)
    )
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
         at('now').setAttribute('x',k*{WIDTH}/P.length)}}\n\
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
