//! Error over time as SVG, both axes logarithmic; light or dark as the reader's screen.

use std::fmt::Write as _;

use cyclopean_analysis::interval::student_t;

use super::report::{Row, SceneReport};

const WIDTH: f64 = 820.0;
const HEIGHT: f64 = 520.0;
const LEFT: f64 = 88.0;
/// Room for the methods' names at the ends of their lines.
const RIGHT: f64 = 172.0;
const TOP: f64 = 78.0;
const BOTTOM: f64 = 64.0;
/// Least distance of two names, pixels.
const NAME_STEP: f64 = 17.0;

/// Colours for so many methods; more begin again with other marks.
const METHODS: usize = 6;

/// What does not depend on the ground.
const FORM: &str = "text{font:13px system-ui,'Segoe UI',Helvetica,Arial,sans-serif}\
.title{font-size:16px;font-weight:600}.small{font-size:11px}.middle{text-anchor:middle}.end{text-anchor:end}\
.grid,.axis,.bar{stroke-width:1.2}.floor{stroke-width:1.2;stroke-dasharray:5 4}\
.line{fill:none;stroke-width:2}.lead{stroke-width:.8;opacity:.6}";

/// Ground, ink, soft ink, grid, then one colour a method: Okabe & Ito's, told apart by colour-blind readers, darkened or
/// lightened until thin lines stand out.
const LIGHT: [&str; 10] =
    ["#ffffff", "#1a1a1a", "#5c5c5c", "#e3e3e3", "#0072b2", "#d55e00", "#007a58", "#b0548a", "#9a6a00", "#2a85b8"];
const DARK: [&str; 10] =
    ["#15171b", "#ececec", "#a5a8ad", "#2e3238", "#5db3ea", "#ff8b3d", "#35c79a", "#e6a3cb", "#f0b73a", "#8fd3f7"];

/// Plain rules instead of variables, which many viewers do not know.
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

/// A drawing for each fallback of the scene; none where there is nothing to draw.
pub fn plots(scene: &SceneReport) -> Vec<(String, String)> {
    let mut fallbacks: Vec<String> = Vec::new();
    for row in &scene.results {
        if !fallbacks.contains(&row.fallback) {
            fallbacks.push(row.fallback.clone());
        }
    }
    fallbacks.into_iter().filter_map(|f| plot(scene, &f).map(|svg| (f, svg))).collect()
}

/// A measured point.
struct Point {
    spp: u32,
    ms: f64,
    mse: f64,
    /// Of the mean over seeds.
    interval: Option<[f64; 2]>,
}

struct Series<'a> {
    method: &'a str,
    points: Vec<Point>,
}

/// A logarithmic axis onto pixels.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// Around the values with a little air, at least a factor of two long.
    fn around(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Option<Axis> {
        let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        if !(low > 0.0 && high.is_finite() && low <= high) {
            return None;
        }
        let air = (high / low).powf(0.08).max((2.0 / (high / low)).max(1.0).sqrt()).max(1.1);
        Some(Axis { low: low / air, high: high * air, from, to })
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value / self.low).ln() / (self.high / self.low).ln();
        self.from + share * (self.to - self.from)
    }

    fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Powers of ten with 2 and 5 between where few decades are shown; at most a dozen.
    fn ticks(&self) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        let steps: &[f64] = match decades {
            d if d < 0.7 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
            d if d < 3.0 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let first = self.low.log10().floor() as i32;
        let last = self.high.log10().ceil() as i32;
        let all = (first..=last).flat_map(|e| steps.iter().map(move |s| s * 10f64.powi(e)));
        all.filter(|t| self.holds(*t)).collect()
    }
}

fn plot(scene: &SceneReport, fallback: &str) -> Option<String> {
    let series = series(scene, fallback);
    let points = || series.iter().flat_map(|s| &s.points);
    let x = Axis::around(points().map(|p| p.ms), LEFT, WIDTH - RIGHT)?;
    let errors = points().flat_map(|p| [p.mse].into_iter().chain(p.interval.into_iter().flatten()));
    let y = Axis::around(errors.filter(|e| *e > 0.0), HEIGHT - BOTTOM, TOP)?;

    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
         height=\"{HEIGHT}\" role=\"img\" aria-label=\"{}: error of the reflection over its time\"><style>{FORM}{}\
         @media(prefers-color-scheme:dark){{{}}}</style><rect class=\"ground\" width=\"100%\" height=\"100%\"/>",
        escape(&scene.scene),
        colors(LIGHT),
        colors(DARK)
    );
    text(&mut out, "title", LEFT, 26.0, &format!("{}: error of the reflection over its time", scene.scene));
    let seeds = scene.results.first().map_or(0, |r| r.seeds);
    let about = format!(
        "unknown rays see: {fallback} · {seeds} seeds, bars: 95 % interval of the mean · numbers at the points: rays a pixel"
    );
    text(&mut out, "soft", LEFT, 46.0, &about);
    axes(&mut out, &x, &y);
    let floor = scene.reference.variance.iter().sum::<f64>() / 2.0;
    if y.holds(floor) {
        line(&mut out, "floor", (LEFT, y.at(floor)), (WIDTH - RIGHT, y.at(floor)));
        text(&mut out, "soft small", LEFT + 6.0, y.at(floor) - 5.0, "the reference's own variance");
    }
    for (i, s) in series.iter().enumerate() {
        draw(&mut out, i, s, &x, &y);
    }
    counts(&mut out, &series, &x, &y);
    names(&mut out, &series, &x, &y);
    out.push_str("</svg>\n");
    Some(out)
}

/// The methods in the report's order, each by its samples.
fn series<'a>(scene: &'a SceneReport, fallback: &str) -> Vec<Series<'a>> {
    let mut all: Vec<Series<'a>> = Vec::new();
    for row in scene.results.iter().filter(|r| r.fallback == fallback) {
        let Some(point) = point(row) else { continue };
        match all.iter_mut().find(|s| s.method == row.method) {
            Some(s) => s.points.push(point),
            None => all.push(Series { method: &row.method, points: vec![point] }),
        }
    }
    all.iter_mut().for_each(|s| s.points.sort_by_key(|p| p.spp));
    all
}

fn point(row: &Row) -> Option<Point> {
    let (ms, mse) = (*row.ms.get("total")?, row.both("mse")?);
    let values = row.rounds.measures.get("mse")?;
    let i = student_t(values, 0.95);
    let interval = i.lo.zip(i.hi).map(|(lo, hi)| [lo, hi]).filter(|[lo, _]| *lo > 0.0);
    (ms > 0.0 && mse > 0.0).then_some(Point { spp: row.spp, ms, mse, interval })
}

fn axes(out: &mut String, x: &Axis, y: &Axis) {
    for tick in x.ticks() {
        line(out, "grid", (x.at(tick), TOP), (x.at(tick), HEIGHT - BOTTOM));
        text(out, "soft middle", x.at(tick), HEIGHT - BOTTOM + 20.0, &number(tick));
    }
    for tick in y.ticks() {
        line(out, "grid", (LEFT, y.at(tick)), (WIDTH - RIGHT, y.at(tick)));
        text(out, "soft end", LEFT - 9.0, y.at(tick) + 4.5, &number(tick));
    }
    line(out, "axis", (LEFT, HEIGHT - BOTTOM), (WIDTH - RIGHT, HEIGHT - BOTTOM));
    line(out, "axis", (LEFT, TOP), (LEFT, HEIGHT - BOTTOM));
    let middle = (LEFT + WIDTH - RIGHT) / 2.0;
    text(out, "middle", middle, HEIGHT - 18.0, "all reflection passes, both eyes, ms (median over rounds)");
    let middle = (TOP + HEIGHT - BOTTOM) / 2.0;
    let _ = write!(
        out,
        "<text class=\"middle\" transform=\"translate(22 {middle:.1}) rotate(-90)\">mean squared error, radiance²</text>"
    );
}

fn draw(out: &mut String, index: usize, series: &Series<'_>, x: &Axis, y: &Axis) {
    let stroke = format!("k{}", index % METHODS);
    let at = |p: &Point| (x.at(p.ms), y.at(p.mse));
    let path: Vec<String> = series.points.iter().map(|p| format!("{:.1},{:.1}", at(p).0, at(p).1)).collect();
    let _ = write!(out, "<polyline class=\"line {stroke}\" points=\"{}\"/>", path.join(" "));
    for p in &series.points {
        let (px, py) = at(p);
        if let Some([lo, hi]) = p.interval {
            let (low, high) = (y.at(lo), y.at(hi));
            // Shorter than the mark, a bar would only blur it.
            if low - high > 10.0 {
                let class = format!("bar {stroke}");
                line(out, &class, (px, low), (px, high));
                line(out, &class, (px - 4.0, low), (px + 4.0, low));
                line(out, &class, (px - 4.0, high), (px + 4.0, high));
            }
        }
        mark(out, index, px, py);
    }
}

/// Rays a pixel beside every point, in its method's colour, where no other point or number stands.
fn counts(out: &mut String, series: &[Series<'_>], x: &Axis, y: &Axis) {
    let at = |p: &Point| (x.at(p.ms), y.at(p.mse));
    let mut taken: Vec<(f64, f64)> = series.iter().flat_map(|s| &s.points).map(at).collect();
    for p in series.iter().flat_map(|s| &s.points) {
        let [low, high] = p.interval.map_or([p.mse; 2], |i| i).map(|e| y.at(e));
        let steps = ((low - high) / 8.0).ceil().max(1.0);
        taken.extend((0..=steps as u32).map(|k| (x.at(p.ms), high + (low - high) * f64::from(k) / steps)));
    }
    for (i, s) in series.iter().enumerate() {
        for p in &s.points {
            let (px, py) = at(p);
            let half = 3.2 * p.spp.to_string().len() as f64;
            let beside = [
                (0.0, -13.0),
                (0.0, 13.0),
                (half + 9.0, -9.0),
                (-half - 9.0, -9.0),
                (half + 9.0, 9.0),
                (-half - 9.0, 9.0),
            ];
            // Room to the nearest thing that is already there; what is a number's height away is far enough.
            let room = |(dx, dy): &(f64, f64)| {
                let distance = |t: &(f64, f64)| ((px + dx - t.0) / (half + 6.0)).hypot((py + dy - t.1) / 11.0).min(1.0);
                taken.iter().map(distance).fold(1.0, f64::min)
            };
            let best = beside
                .iter()
                .map(room)
                .enumerate()
                .fold((0, -1.0), |best, (k, r)| if r > best.1 { (k, r) } else { best });
            let (cx, cy) = (px + beside[best.0].0, py + beside[best.0].1);
            taken.push((cx, cy));
            text(out, &format!("small middle f{}", i % METHODS), cx, cy + 4.0, &p.spp.to_string());
        }
    }
}

/// Names at the ends of the lines, moved apart where they would touch.
fn names(out: &mut String, series: &[Series<'_>], x: &Axis, y: &Axis) {
    let mut ends: Vec<(usize, f64, f64)> = Vec::new();
    for (i, s) in series.iter().enumerate() {
        let Some(last) = s.points.iter().max_by(|a, b| a.ms.total_cmp(&b.ms)) else { continue };
        ends.push((i, x.at(last.ms), y.at(last.mse)));
    }
    ends.sort_by(|a, b| a.2.total_cmp(&b.2));
    let lowest = HEIGHT - BOTTOM - NAME_STEP * ends.len().saturating_sub(1) as f64;
    let mut free = TOP;
    for (rank, (i, from_x, from_y)) in ends.into_iter().enumerate() {
        let at = from_y.clamp(free, lowest + NAME_STEP * rank as f64);
        free = at + NAME_STEP;
        let name_x = WIDTH - RIGHT + 20.0;
        line(out, &format!("lead k{}", i % METHODS), (from_x + 8.0, from_y), (name_x - 12.0, at));
        mark(out, i, name_x - 4.0, at);
        text(out, "", name_x + 7.0, at + 4.5, series[i].method);
    }
}

/// Circle, square, diamond, triangle: told apart without colour.
fn mark(out: &mut String, index: usize, x: f64, y: f64) {
    let fill = format!("f{}", index % METHODS);
    let corners: &[(f64, f64)] = match index % 4 {
        0 => {
            let _ = write!(out, "<circle class=\"{fill}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.6\"/>");
            return;
        }
        1 => &[(-4.2, -4.2), (4.2, -4.2), (4.2, 4.2), (-4.2, 4.2)],
        2 => &[(0.0, -5.8), (5.8, 0.0), (0.0, 5.8), (-5.8, 0.0)],
        _ => &[(0.0, -5.4), (5.2, 4.0), (-5.2, 4.0)],
    };
    let points: Vec<String> = corners.iter().map(|(dx, dy)| format!("{:.1},{:.1}", x + dx, y + dy)).collect();
    let _ = write!(out, "<polygon class=\"{fill}\" points=\"{}\"/>", points.join(" "));
}

fn line(out: &mut String, class: &str, (x1, y1): (f64, f64), (x2, y2): (f64, f64)) {
    let _ = write!(out, "<line class=\"{class}\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>");
}

fn text(out: &mut String, class: &str, x: f64, y: f64, words: &str) {
    let _ = write!(out, "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escape(words));
}

/// What XML would take for markup.
fn escape(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Plain between a ten-thousandth and ten thousand, else as a power of ten.
fn number(value: f64) -> String {
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
    fn ticks_are_few_and_round() {
        let axis = |low, high| Axis { low, high, from: 0.0, to: 100.0 };
        assert_eq!(axis(0.8, 30.0).ticks(), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(axis(1e-6, 2e-1).ticks().len(), 6);
        assert!(axis(3.1, 9.0).ticks().len() >= 3);
        assert_eq!(axis(1.0, 100.0).at(10.0), 50.0);
        assert!(Axis::around([5.0].into_iter(), 0.0, 1.0).expect("one value").ticks().len() > 1);
        assert!(Axis::around([0.0].into_iter(), 0.0, 1.0).is_none());
        assert!(Axis::around(std::iter::empty(), 0.0, 1.0).is_none());
    }

    #[test]
    fn numbers_are_short() {
        let shown: Vec<String> = [0.002, 1.5, 200.0, 1e-5, 5e-12, 2e4].map(number).to_vec();
        assert_eq!(shown, ["0.002", "1.5", "200", "10⁻⁵", "5·10⁻¹²", "2·10⁴"]);
    }
}
