//! An HTML page that plays a session back: what was shown when, answers, missed frames. It is meant for those who run a
//! study, never for participants, because it names the methods. `cyclopean study show` writes it.

mod timeline;

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::json;

use super::html::{base64, facts_table, head};
use crate::escape::html as escape;
use crate::journal::Kind;

pub use timeline::{Lane, Mark, SessionTimeline, Span};

const SCRIPT: &str = include_str!("page.js");
const STYLE: &str = include_str!("page.css");

/// Makes the self-contained page. `pictures` holds a PNG of both eyes side by side, by the stimulus's index; a missing
/// picture is replaced by words.
pub fn session_page(timeline: &SessionTimeline, pictures: &BTreeMap<u32, Vec<u8>>) -> String {
    let h = &timeline.header;
    let title = format!("{}, participant {}, session {}", h.study.title, h.participant, h.session);
    let mut out = head(&title, STYLE);
    if timeline.kind != Kind::Real {
        let _ = write!(out, "<p class=\"stamp-line\">{} session</p>", escape(&timeline.kind.name().to_uppercase()));
    }
    out += "<p>Press Play, drag the line below the picture, or click a row of the list. This page names the methods: it is not \
            for participants.</p>";
    out += "<div class=\"player\"><figure class=\"stage\"><img alt=\"\"><div class=\"words\"></div></figure>\
            <p class=\"now\"></p><input type=\"range\" min=\"0\" step=\"any\" value=\"0\" aria-label=\"time of the session\">\
            <svg class=\"line\" role=\"img\" aria-label=\"what stood when\"></svg>\
            <p class=\"legend\">From the top: <b class=\"phase\">phases</b> and <b class=\"pause\">pauses</b>, \
            <b class=\"stimulus\">stimuli</b>, <b class=\"panel\">panels</b>, answers, and \
            <b class=\"bad\">what went wrong</b>.</p>\
            <p><button class=\"play\">Play</button> <label>speed <select><option>1</option><option>2</option>\
            <option selected>5</option><option>20</option><option>60</option></select></label></p></div>";
    let shown = |display: &crate::journal::record::Display| {
        format!("{}, {} ({}), {} Hz", display.kind, display.system, display.runtime, display.nominal_hz)
    };
    let answers = timeline.marks.iter().filter(|m| m.what == "answer").count();
    let count = |what: &str| timeline.marks.iter().filter(|m| m.what == what).count().to_string();
    let facts = [
        ("study", format!("{} (seed {}, row {})", h.study.id, h.study.seed, h.row)),
        ("display", shown(&h.display)),
        ("program", format!("{} {}", h.program.name, h.program.version)),
        ("length", format!("{:.1} minutes", timeline.end_s / 60.0)),
        ("answers", answers.to_string()),
        ("presentations with missed frames", count("missed")),
        ("invalid presentations", count("invalid")),
        ("missing", count("missing")),
    ];
    out += &facts_table(&facts);
    out += "<h2>What happened</h2><div class=\"scroll\"><table class=\"list\"><thead><tr><th>time</th><th>what</th><th></th></tr>\
            </thead><tbody></tbody></table></div>";
    let pictures: BTreeMap<String, String> = pictures
        .iter()
        .map(|(stimulus, png)| (stimulus.to_string(), format!("data:image/png;base64,{}", base64(png))))
        .collect();
    let data = json!({ "end": timeline.end_s, "spans": timeline.spans, "marks": timeline.marks, "pictures": pictures });
    // A JSON text may hold `</script>`. This escape prevents that, and JSON readers undo it.
    let data = data.to_string().replace('<', "\\u003c");
    let _ = write!(out, "<script type=\"application/json\" id=\"session\">{data}</script><script>{SCRIPT}</script>");
    out += "</main></body></html>\n";
    out
}
