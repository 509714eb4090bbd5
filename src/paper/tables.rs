//! Tables 1 to 3, the ablation of modules, and error against time. What was measured goes in, and [`Item`]s come out;
//! `super::items` calls it.

use super::item::{Cell, Drawing, Grid, Item};
use super::plan::{self, Comparison, Request};
use super::published::{Publication, TABLE_1, TABLE_2, TABLE_3};
use super::{Measurements, RequestedScene};
use crate::compare::{self, Row, SceneReport};

/// The words that say whether a line is the publication's or ours.
pub const SOURCES: [&str; 2] = ["printed", "here"];

pub const OTHER_SCENES: &str =
    "The scenes are this program's own. Their triangles, materials and lights are not those of the publication.";

/// The reason why the publication has no line for one of our scenes.
const NO_COUNTERPART: &str = "no such scene";

/// The scenes in the order of the publication, then those of ours that it does not have. Each has its name, what is
/// printed, and our scene.
fn both<'a, P>(
    printed: &'a [P],
    name: impl Fn(&P) -> &'static str,
    ours: &'a [RequestedScene],
) -> Vec<(String, Option<&'a P>, Option<&'a RequestedScene>)> {
    let is = |p: &P, m: &RequestedScene| name(p).eq_ignore_ascii_case(&m.name);
    let theirs = printed.iter().map(|p| (name(p).to_owned(), Some(p), ours.iter().find(|m| is(p, m))));
    let rest = ours.iter().filter(|m| !printed.iter().any(|p| is(p, m))).map(|m| (m.name.clone(), None, Some(m)));
    theirs.chain(rest).collect()
}

/// So many cells with the same reason.
fn none(count: usize, why: &str) -> Vec<Cell> {
    vec![Cell::None(why.to_owned()); count]
}

/// A line of a table: the scene, whose line it is, and the other cells.
fn line(scene: &str, source: &str, cells: impl IntoIterator<Item = Cell>) -> Vec<Cell> {
    [Cell::word(scene), Cell::word(source)].into_iter().chain(cells).collect()
}

pub fn comparison(request: &Request, id: &str) -> Option<Comparison> {
    request.comparisons().into_iter().find(|c| c.id == id)
}

pub fn call(request: &Request, id: &str) -> Option<String> {
    comparison(request, id).map(|c| request.call(&c))
}

/// Table 1.
pub fn scenes(measurements: &Measurements) -> Item {
    let columns =
        ["scene", "source", "triangles", "moving", "reflective materials", "roughness, range", "roughness, mean"];
    let mut grid = Grid::new("Parameters of the scenes. Reflective means a roughness below 0.8.", &columns);
    let whole = |n: usize| Cell::Number(n as f64, 0, "");
    for (name, printed, ours) in both(&TABLE_1, |p| p.scene, &measurements.scenes) {
        let printed = match printed {
            Some(p) => vec![
                whole(p.triangles as usize),
                whole(p.moving as usize),
                whole(p.reflective as usize),
                Cell::word(format!("{:.3} to {:.3}", p.roughness[0], p.roughness[1])),
                Cell::Number(p.mean_roughness, 3, ""),
            ],
            None => none(5, NO_COUNTERPART),
        };
        let here = match ours.map(|m| &m.survey) {
            Some(Ok(s)) => {
                let [range, mean] = match s.roughness {
                    Some([low, high, mean]) => {
                        [Cell::word(format!("{low:.3} to {high:.3}")), Cell::Number(f64::from(mean), 3, "")]
                    }
                    None => ["nothing reflects", "nothing reflects"].map(|why| Cell::None(why.to_owned())),
                };
                vec![whole(s.triangles), whole(s.moving), whole(s.reflective_materials), range, mean]
            }
            Some(Err(error)) => none(5, &format!("failed: {error}")),
            None => none(5, "not among the scenes"),
        };
        grid.rows.push(line(&name, SOURCES[0], printed));
        grid.rows.push(line(&name, SOURCES[1], here));
    }
    Item {
        id: "table1",
        title: "Table 1: the scenes".to_owned(),
        publication: Publication::Reflection,
        printed_in: "Table 1, section 5",
        printed: "the triangles, dynamic objects and reflective materials of five scenes, and the roughness of these \
                  materials."
            .to_owned(),
        here: "the same for the scenes that were rendered, counted when they were loaded. The mean roughness is over \
               the reflective materials, and each material counts once."
            .to_owned(),
        tables: vec![grid],
        differs: vec![
            OTHER_SCENES.to_owned(),
            "The publication does not say over what its mean roughness is taken. It counts dynamic objects. Here every \
             part that moves is counted."
                .to_owned(),
        ],
        ..Item::default()
    }
}

/// A measure of one eye.
fn of_eye(row: &Row, eye: &str, measure: &str) -> Option<f64> {
    let eye = if eye == "left" { &row.left } else { &row.right };
    eye.means.get(measure).copied().flatten()
}

/// Table 2.
pub fn quality(request: &Request, measurements: &Measurements) -> Item {
    const ID: &str = plan::TABLE_2;
    let columns = ["scene", "eye", "source", "SSSR", "Ours", "1 − SSIM, Ours over SSSR"];
    let mut ssim = Grid::new("SSIM of the reflection against the reference; higher is better.", &columns);
    let networks = ["reflection_lpips", "reflection_dists"].map(|key| {
        let has = |s: &SceneReport| s.results.iter().any(|r| of_eye(r, "left", key).is_some());
        measurements.reports.get(ID).is_some_and(|r| r.scenes.iter().any(has))
    });
    let columns = ["scene", "eye", "source", "LPIPS, SSSR", "LPIPS, Ours", "DISTS, SSSR", "DISTS, Ours"];
    let mut learned = Grid::new("LPIPS and DISTS of the reflection; lower is better.", &columns);
    let has_network = networks.iter().any(|has| *has);
    for (name, printed, ours) in both(&TABLE_2, |p| p.scene, &measurements.scenes) {
        let eyes: Vec<&str> = printed.map_or(vec!["left", "right"], |p| vec![p.eye]);
        for eye in eyes {
            let head = |source: &str| vec![Cell::word(&name), Cell::word(eye), Cell::word(source)];
            let pair = |[sssr, stereo]: [Option<f64>; 2], digits: usize, why: &str| {
                [Cell::number(sssr, digits, "", why), Cell::number(stereo, digits, "", why)]
            };
            let lacking = |[sssr, stereo]: [Option<f64>; 2]| Some((1.0 - stereo?) / (1.0 - sssr?));
            let push = |grid: &mut Grid, source: &str, cells: Vec<Cell>| {
                grid.rows.push(head(source).into_iter().chain(cells).collect());
            };
            let of_both = |values: [Option<f64>; 2], why: &str| {
                let ratio = Cell::number(lacking(values), 3, "", why);
                pair(values, 3, why).into_iter().chain([ratio]).collect::<Vec<_>>()
            };
            match printed {
                Some(p) => {
                    push(&mut ssim, SOURCES[0], of_both(p.ssim.map(Some), ""));
                    let both = [p.lpips, p.dists].map(|v| pair(v.map(Some), 3, ""));
                    push(&mut learned, SOURCES[0], both.into_iter().flatten().collect());
                }
                None => {
                    push(&mut ssim, SOURCES[0], none(3, NO_COUNTERPART));
                    push(&mut learned, SOURCES[0], none(4, NO_COUNTERPART));
                }
            }
            let why = ours.map_or("not among the scenes".to_owned(), |m| measurements.why(ID, &m.name));
            let rows = ["sssr", "stereo"].map(|method| ours.and_then(|m| measurements.row(ID, &m.name, method, 1)));
            let values = |key: &str| rows.map(|row| row.and_then(|r| of_eye(r, eye, key)));
            push(&mut ssim, SOURCES[1], of_both(values("reflection_ssim"), &why));
            if has_network {
                let of =
                    |(key, has): (&str, bool)| pair(values(key), 3, if has { &why } else { "no network was named" });
                let cells = [("reflection_lpips", networks[0]), ("reflection_dists", networks[1])].map(of);
                push(&mut learned, SOURCES[1], cells.into_iter().flatten().collect());
            }
        }
    }
    let mut differs = vec![
        OTHER_SCENES.to_owned(),
        "SSIM is of the tone-mapped reflection alone, as the mean of R, G and B over the windows whose centre traces a \
         ray. The publication does not say which windows, channels or tone map it takes."
            .to_owned(),
    ];
    if !has_network {
        learned.rows.iter_mut().for_each(|row| drop(row.remove(2)));
        learned.columns.remove(2);
        learned.caption += " Only the printed numbers are shown; the reason is below.";
        differs.push(
        "LPIPS and DISTS need trained networks, and none was named (--lpips, --dists). So this program's own lines are \
         absent."
                .to_owned(),
        );
    }
    Item {
        id: ID,
        title: "Table 2: quality of the reflection".to_owned(),
        publication: Publication::Reflection,
        printed_in: "Table 2, section 5.1",
        printed: "SSIM, LPIPS and DISTS of SSSR and of Ours against the ground truth, eye by eye.".to_owned(),
        here:
            "means over the rounds. SSSR is sssr and Ours is stereo, both with one ray a pixel. How close SSIM is to \
               1 depends on the scene. So 1 − SSIM is compared as a ratio, which is below 1 where Ours is better."
                .to_owned(),
        tables: vec![ssim, learned],
        differs,
        call: call(request, ID),
        ..Item::default()
    }
}

/// Table 3, and the time of every pass.
pub fn times(request: &Request, measurements: &Measurements) -> Item {
    const ID: &str = "table3";
    let columns = [
        "scene",
        "source",
        "PT",
        "Traversal, SSSR",
        "Ours",
        "Filter, SSSR",
        "Ours",
        "Total, SSSR",
        "Ours",
        "over SSSR",
    ];
    let mut grid =
        Grid::new("Milliseconds of both eyes together. The total is that of traversal and filter.", &columns);
    let pair = |[a, b]: [f64; 2]| [Cell::Number(a, 2, ""), Cell::Number(b, 2, "")];
    for (name, printed, ours) in both(&TABLE_3, |p| p.scene, &measurements.scenes) {
        let cells = match printed {
            Some(p) => [Cell::Number(p.path_tracing, 2, "")]
                .into_iter()
                .chain(pair(p.traversal))
                .chain(pair(p.filter))
                .chain(pair(p.total))
                .chain([Cell::Number(1.0 + p.overhead / 100.0, 2, "")])
                .collect(),
            None => none(8, NO_COUNTERPART),
        };
        grid.rows.push(line(&name, SOURCES[0], cells));
        let why = ours.map_or("not among the scenes".to_owned(), |m| measurements.why(ID, &m.name));
        let row = |method: &str, spp: u32| ours.and_then(|m| measurements.row(ID, &m.name, method, spp));
        let ms = |row: Option<&Row>, group: &str| Cell::number(row.and_then(|r| r.ms.get(group).copied()), 2, "", &why);
        let rows = [row("sssr", 1), row("stereo", 1)];
        let groups = ["trace", "resolve", "trace_resolve"];
        let overhead = ours.and_then(|m| measurements.scene(ID, &m.name)).and_then(|scene| {
            let of =
                |o: &&compare::Overhead| (o.method.as_str(), o.spp, o.group.as_str()) == ("stereo", 1, "trace_resolve");
            scene.overhead.iter().find(of).map(|o| o.median)
        });
        let cells = [ms(row("path-traced", 2), "total")]
            .into_iter()
            .chain(groups.iter().flat_map(|group| rows.map(|row| ms(row, group))))
            .chain([Cell::number(overhead, 2, "", &why)]);
        grid.rows.push(line(&name, SOURCES[1], cells));
    }
    Item {
        id: ID,
        title: "Table 3: time of the reflections".to_owned(),
        publication: Publication::Reflection,
        printed_in: "Table 3, section 5.2",
        printed: "milliseconds of traversal and spatial filter, as means of 100 frames, and of path tracing with two \
                  paths a pixel on the card's ray-tracing cores."
            .to_owned(),
        here: "medians over the rounds. Traversal is every stage of the trace, and the spatial filter is every stage \
               of the resolve. The overhead is the median of the ratios within the rounds."
            .to_owned(),
        tables: vec![grid, passes(measurements)],
        differs: vec![
            "The device and perhaps the size are different, so only the last column can be compared.".to_owned(),
            OTHER_SCENES.to_owned(),
            "Path tracing here walks a BVH in a shader, or with a software device on the processor. It uses \
             ray-tracing cores only with a card that answers ray queries."
                .to_owned(),
        ],
        call: call(request, ID),
        ..Item::default()
    }
}

/// Passes of a frame that are not work for reflections. They are the last columns.
const SHARED: [&str; 3] = ["gbuffer", "lighting", "composite"];

fn passes(measurements: &Measurements) -> Grid {
    let rows: Vec<(&str, &Row)> = measurements
        .scenes
        .iter()
        .flat_map(|m| {
            ["sssr", "stereo"]
                .into_iter()
                .filter_map(move |name| Some((m.name.as_str(), measurements.row("table3", &m.name, name, 1)?)))
        })
        .collect();
    let mut names: Vec<&str> = rows.iter().flat_map(|(_, row)| row.passes.keys().map(String::as_str)).collect();
    names.sort_by_key(|name| (SHARED.contains(name), *name));
    names.dedup();
    let columns: Vec<&str> = ["scene", "method"].into_iter().chain(names.iter().copied()).collect();
    let mut grid = Grid::new(
        "Milliseconds of every pass here for both eyes, as medians over the rounds. The last three passes are no work \
         for reflections.",
        &columns,
    );
    for (scene, row) in rows {
        let ms = names.iter().map(|name| Cell::number(row.passes.get(*name).copied(), 2, "", "does without"));
        grid.rows.push([Cell::word(scene), Cell::word(&row.method)].into_iter().chain(ms).collect());
    }
    grid
}

/// Error against time: what more samples gain.
pub fn error_against_time(request: &Request, measurements: &Measurements) -> Item {
    const ID: &str = "table3";
    let columns = ["scene", "method", "total, ms", "MSE", "RSE", "1 − SSIM", "MSE over sssr's in the same time"];
    let mut grid =
        Grid::new("Errors of the reflection against the reference, as means of the eyes and rounds.", &columns);
    let mut drawings = Vec::new();
    for m in &measurements.scenes {
        let Some(scene) = measurements.scene(ID, &m.name) else {
            grid.rows.push([Cell::word(&m.name)].into_iter().chain(none(6, &measurements.why(ID, &m.name))).collect());
            continue;
        };
        for row in &scene.results {
            let name = format!("{}@{}", row.method, row.spp);
            let ratio = scene.equal_time.iter().find(|e| (&e.method, e.spp) == (&row.method, row.spp));
            let equal = match ratio {
                Some(e) if e.extrapolated => Cell::word(format!("{:.3} (extrapolated)", e.ratio)),
                Some(e) => Cell::Number(e.ratio, 3, ""),
                None if row.method == scene.baseline => Cell::word("this is sssr"),
                None => Cell::None("undefined".to_owned()),
            };
            let undefined = "undefined";
            let mse = row.both("mse").map_or(Cell::None(undefined.to_owned()), |v| Cell::word(format!("{v:.3e}")));
            grid.rows.push(vec![
                Cell::word(&m.name),
                Cell::word(name),
                Cell::number(row.ms.get("total").copied(), 2, "", undefined),
                mse,
                Cell::number(row.both("rse"), 3, "", undefined),
                Cell::number(row.both("reflection_ssim").map(|s| 1.0 - s), 3, "", undefined),
                equal,
            ]);
        }
        let caption = format!("Error against time in {}: mean squared error over the time of the reflections.", m.name);
        // The error of two unfiltered paths a pixel is so large that the methods would have no room on the axis.
        let mut drawn = scene.clone();
        drawn.results.retain(|row| row.method != "path-traced");
        drawings.extend(compare::plots(&drawn).into_iter().map(|(_, svg)| Drawing { caption: caption.clone(), svg }));
    }
    Item {
        id: "error-against-time",
        title: "Error against time".to_owned(),
        publication: Publication::Reflection,
        printed_in: "section 5.1",
        printed:
            "no such figure. The text says that more samples of SSSR do not resolve the inconsistency (Figure 10)."
                .to_owned(),
        here:
            "sssr and stereo with 1, 2 and 4 rays a pixel, and path tracing with two paths a pixel. The last column is \
             the method's error over that of sssr in the same time; below 1 the method is better. The plots leave out \
             path tracing, whose error is far larger."
                .to_owned(),
        tables: vec![grid],
        drawings,
        call: call(request, ID),
        ..Item::default()
    }
}

/// The ablation: what each module gains.
pub fn modules(request: &Request, measurements: &Measurements) -> Item {
    const ID: &str = "modules";
    const MEASURES: [(&str, &str); 5] = [
        ("1 − SSIM", "one_minus_reflection_ssim"),
        ("MSE", "mse"),
        ("lasting, share", "systematic_inconsistency"),
        ("lasting, contrast²", "systematic_unbiased"),
        ("noise between eyes", "noise_variance"),
    ];
    let modules = [
        ("Traversal", "stereo-no-traversal"),
        ("Fade", "stereo-no-fade"),
        ("Reprojection", "stereo-no-reprojection"),
        ("check of the pairs", "stereo-no-back-check"),
    ];
    let columns: Vec<&str> =
        ["scene", "without", "trace + resolve"].into_iter().chain(MEASURES.map(|(title, _)| title)).collect();
    let mut grid = Grid::new(
        "Times and errors without a module, over those of the full method. Where an error is above 1 the module helps. \
         Lasting is the difference between the eyes that stays whatever the random numbers are, and noise is the part \
         that changes with them.",
        &columns,
    );
    for m in &measurements.scenes {
        let why = measurements.why(ID, &m.name);
        let scene = measurements.scene(ID, &m.name);
        for (module, method) in modules {
            let time = scene.and_then(|s| {
                s.overhead.iter().find(|o| (o.method.as_str(), o.group.as_str()) == (method, "trace_resolve"))
            });
            let ratio = |measure: &str| {
                let found = scene.and_then(|s| {
                    s.equal_sample.iter().find(|r| (r.method.as_str(), r.measure.as_str()) == (method, measure))
                });
                let left_out = scene.and_then(|s| {
                    s.left_out.iter().find(|l| (l.method.as_str(), l.measure.as_str()) == (method, measure))
                });
                let why = left_out.map_or(why.as_str(), |l| l.why.as_str());
                Cell::number(found.map(|r| r.ratio), 3, "", why)
            };
            let head = [Cell::word(&m.name), Cell::word(module), Cell::number(time.map(|t| t.median), 3, "", &why)];
            grid.rows.push(head.into_iter().chain(MEASURES.map(|(_, measure)| ratio(measure))).collect());
        }
    }
    Item {
        id: ID,
        title: "Module ablation".to_owned(),
        publication: Publication::Reflection,
        printed_in: "sections 5.3 and 6, Figures 11 to 14 and 18 (b)",
        printed: "parts of pictures with and without each module, and people's choices between them, but no errors."
            .to_owned(),
        here: "measurements of each module in every scene. Figures 11 to 14 above show pictures, and Figure 18 (b) \
               below has people's choices."
            .to_owned(),
        tables: vec![grid],
        differs: vec![
            "Leaving out only the traversal may change little, because the reprojection fills many of the same gaps \
             from the other eye."
                .to_owned(),
        ],
        call: call(request, ID),
        ..Item::default()
    }
}
