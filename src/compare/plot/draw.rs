//! The SVG elements of all drawings of `compare`. They are light or dark, as the reader's screen is.

use std::fmt::Write as _;

use cyclopean_analysis::escape::html;
use cyclopean_analysis::svg;
pub use cyclopean_analysis::svg::{line, text};

/// The least distance between two names, pixels.
const NAME_STEP: f64 = 17.0;

/// The number of colours for methods. Further methods use the same colours again with other marks.
pub const METHODS: usize = 6;

/// The style rules that do not depend on whether the drawing is light or dark.
const FORM: &str = "text{font:13px system-ui,'Segoe UI',Helvetica,Arial,sans-serif}\
.title{font-size:16px;font-weight:600}.small{font-size:11px}.middle{text-anchor:middle}.end{text-anchor:end}\
.grid,.axis,.bar{stroke-width:1.2}.floor{stroke-width:1.2;stroke-dasharray:5 4}\
.dashed{stroke-width:1.6}.long{stroke-dasharray:8 4}.short{stroke-dasharray:2.5 3}\
.line{fill:none;stroke-width:2}.lead{stroke-width:.8;opacity:.6}";

/// The colours of the ground, the ink, the soft ink and the grid, then one for each method. Those are Okabe & Ito's,
/// which colour-blind readers can tell apart. They are darker or lighter than the originals, so that thin lines stand
/// out.
const LIGHT: [&str; 10] =
    ["#ffffff", "#1a1a1a", "#5c5c5c", "#e3e3e3", "#0072b2", "#d55e00", "#007a58", "#b0548a", "#9a6a00", "#2a85b8"];
const DARK: [&str; 10] =
    ["#15171b", "#ececec", "#a5a8ad", "#2e3238", "#5db3ea", "#ff8b3d", "#35c79a", "#e6a3cb", "#f0b73a", "#8fd3f7"];

/// The style rules of a set of colours. They use no CSS variables, because many viewers do not support them.
fn colors([ground, ink, soft, grid, methods @ ..]: [&str; 10]) -> String {
    let mut rules = format!(
        ".ground{{fill:{ground}}}text{{fill:{ink}}}.soft{{fill:{soft}}}.grid{{stroke:{grid}}}\
         .axis,.floor{{stroke:{soft}}}"
    );
    for (i, color) in methods.iter().enumerate() {
        let _ = write!(rules, ".f{i}{{fill:{color}}}.k{i}{{stroke:{color}}}");
    }
    rules
}

/// The beginning of a drawing of this size, with its title. Screen readers read the title.
pub fn open(title: &str, width: f64, height: f64, left: f64) -> String {
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" role=\"img\" aria-label=\"{}\"><style>{FORM}{}\
         @media(prefers-color-scheme:dark){{{}}}</style><rect class=\"ground\" width=\"100%\" height=\"100%\"/>",
        html(title),
        colors(LIGHT),
        colors(DARK)
    );
    text(&mut out, "title", left, 26.0, title);
    out
}

/// Two kinds of dashes that a reader can tell apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    Long,
    Short,
}

/// How the line that a name belongs to looks in the drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LegendMark {
    /// A line with marks of this index.
    Mark(usize),
    /// A dashed line in the colour of this index.
    Level(usize, Dash),
    /// A thin line without a colour of its own.
    Plain,
}

/// A name beside the drawing, and the place in the drawing that it belongs to.
#[derive(Debug, Clone)]
pub struct LegendEntry {
    pub from: (f64, f64),
    pub sign: LegendMark,
    pub words: String,
}

/// Writes names to the right of `right`, in the order of their places. Each is as near to its place as it can be
/// without touching another name.
pub fn names(out: &mut String, mut all: Vec<LegendEntry>, right: f64, top: f64, bottom: f64) {
    all.sort_by(|a, b| a.from.1.total_cmp(&b.from.1));
    let wanted: Vec<f64> = all.iter().map(|n| n.from.1).collect();
    for (name, at) in all.into_iter().zip(apart(&wanted, top, bottom)) {
        let (from_x, from_y) = name.from;
        let name_x = right + 26.0;
        let lead = match name.sign {
            LegendMark::Mark(i) | LegendMark::Level(i, _) => format!("lead k{}", i % METHODS),
            LegendMark::Plain => "lead axis".to_owned(),
        };
        line(out, &lead, (from_x + if from_x < right { 8.0 } else { 2.0 }, from_y), (name_x - 13.0, at));
        match name.sign {
            LegendMark::Mark(i) => mark(out, i, name_x - 4.0, at),
            LegendMark::Level(i, dash) => line(out, &level(i, dash), (name_x - 12.0, at), (name_x + 3.0, at)),
            LegendMark::Plain => line(out, "axis", (name_x - 12.0, at), (name_x + 3.0, at)),
        }
        text(out, "", name_x + 7.0, at + 4.5, &name.words);
    }
}

/// Moves places, which rise, so that they are at least [`NAME_STEP`] apart between top and bottom. The sum of the
/// squared moves is the least possible: names that would touch form a group around their mean (pool adjacent
/// violators). If there are too many, the last ones are below the bottom.
fn apart(wanted: &[f64], top: f64, bottom: f64) -> Vec<f64> {
    // The sum and the count of each group. Of each place, its rank times the step is subtracted.
    let mut groups: Vec<(f64, f64)> = Vec::new();
    for (rank, y) in wanted.iter().enumerate() {
        groups.push((y - NAME_STEP * rank as f64, 1.0));
        while let [.., a, b] = groups.as_slice() {
            if a.0 / a.1 <= b.0 / b.1 {
                break;
            }
            let both = (a.0 + b.0, a.1 + b.1);
            groups.truncate(groups.len() - 2);
            groups.push(both);
        }
    }
    let lowest = (bottom - NAME_STEP * wanted.len().saturating_sub(1) as f64).max(top);
    let firsts = groups.iter().flat_map(|(sum, count)| std::iter::repeat_n(sum / count, *count as usize));
    firsts.enumerate().map(|(rank, y)| y.clamp(top, lowest) + NAME_STEP * rank as f64).collect()
}

/// The style class of a level line in the colour of this index.
pub fn level(index: usize, dash: Dash) -> String {
    let dash = match dash {
        Dash::Long => "long",
        Dash::Short => "short",
    };
    format!("dashed {dash} k{}", index % METHODS)
}

/// A bar with ends, from `low` to `high`. It is left out where it is so short that it would only blur the mark.
pub fn bar(out: &mut String, index: usize, x: f64, (low, high): (f64, f64)) {
    if (low - high).abs() > 10.0 {
        let class = format!("bar k{}", index % METHODS);
        line(out, &class, (x, low), (x, high));
        line(out, &class, (x - 4.0, low), (x + 4.0, low));
        line(out, &class, (x - 4.0, high), (x + 4.0, high));
    }
}

/// A line through points, in the colour of this index.
pub fn polyline(out: &mut String, index: usize, points: &[(f64, f64)]) {
    svg::polyline(out, &format!("line k{}", index % METHODS), points);
}

/// A mark in the colour of this index; see [`svg::mark`].
pub fn mark(out: &mut String, index: usize, x: f64, y: f64) {
    svg::mark(out, &format!("f{}", index % METHODS), index, (x, y), 4.6);
}

/// A number as text: in plain digits from a ten-thousandth to ten thousand, otherwise with a power of ten.
pub fn number(value: f64) -> String {
    if (1e-4..1e4).contains(&value) {
        let text = format!("{value:.5}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    let exponent = (value.log10() + 1e-9).floor();
    let digits = format!("{:.1}", value / 10f64.powf(exponent));
    let digits = digits.trim_end_matches(".0");
    let superscript: String = format!("{exponent:.0}").chars().map(superscript).collect();
    if digits == "1" { format!("10{superscript}") } else { format!("{digits}·10{superscript}") }
}

fn superscript(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        d => d.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(d),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_apart_and_as_near_as_they_can() {
        // Two names that would touch are each moved by the same distance. One that has room stays where it is.
        assert_eq!(apart(&[100.0, 103.0, 180.0], 20.0, 200.0), [93.0, 110.0, 180.0]);
        assert_eq!(apart(&[21.0, 22.0], 20.0, 200.0), [20.0, 37.0]);
        assert_eq!(apart(&[199.0, 199.0], 20.0, 200.0), [183.0, 200.0]);
        // More names than fit go on below the drawing.
        assert_eq!(apart(&[30.0; 3], 20.0, 40.0), [20.0, 37.0, 54.0]);
        assert!(apart(&[], 20.0, 200.0).is_empty());
    }

    #[test]
    fn numbers_are_short() {
        let shown: Vec<String> = [0.002, 1.5, 200.0, 1e-5, 5e-12, 2e4].map(number).to_vec();
        assert_eq!(shown, ["0.002", "1.5", "200", "10⁻⁵", "5·10⁻¹²", "2·10⁴"]);
    }
}
