//! The tables and figures of seed 001, which are about ambient occlusion between the eyes. What was measured goes in,
//! and [`Item`]s come out; `super::items` calls it.

use super::Measurements;
use super::item::{Cell, Drawing, Grid, Item};
use super::plan::Request;
use super::published::{
    AO_FIGURE_1, AO_FIGURE_8, AO_SETTING, AO_TABLE_1, AO_TABLE_2, AO_TABLE_3, AoScene, Publication,
};
use super::tables::SOURCES;
use crate::compare::ao::{self, AoPath, AoRow};
use crate::render::Ao;

const METHODS: [&str; 4] = ["mono", "fsa", "variant1", "variant2"];

const OTHER_SCENES: &str = "The scenes are this program's own, not Market, Sponza, Sibenik and Bistro: no line has a \
                            counterpart, and only ratios between methods can be compared.";

/// The columns of Table 3 of seed 001 (the first pass, the map, the adaptive pass), and which of our passes belong to
/// each.
const PASSES: [(&str, &[&str]); 6] = [
    ("initial: estimate", &["ao_pairs", "ao_obscurance", "ao_reproject"]),
    ("initial: filter", &["ao_filter", "ao_blend"]),
    ("adaptive map", &["ao_adaptive"]),
    ("adaptive: estimate", &["ao_obscurance_listed"]),
    ("adaptive: filter", &["ao_filter_listed", "ao_blend_listed"]),
    ("total", &[]),
];

const DOES_WITHOUT: &str = "does without";

/// All items of seed 001.
pub fn items(request: &Request, measurements: &Measurements) -> Vec<Item> {
    vec![
        inconsistency(request, measurements),
        along(request, measurements),
        times(request, measurements),
        threshold(request, measurements),
    ]
}

/// Adds lines for each of our scenes: those that `cells` makes, or one that says why there are none.
fn lines(measurements: &Measurements, grid: &mut Grid, lead: &[&str], cells: impl Fn(&ao::AoScene) -> Vec<Vec<Cell>>) {
    for m in &measurements.scenes {
        let found = measurements.ao.as_ref().and_then(|ao| ao.scenes.iter().find(|s| s.scene == m.name));
        let head = |rest: Vec<Cell>| -> Vec<Cell> {
            let lead = [m.name.as_str()].into_iter().chain(lead.iter().copied());
            lead.map(Cell::word).chain(rest).collect()
        };
        match found {
            Some(scene) => grid.rows.extend(cells(scene).into_iter().map(head)),
            None => {
                let failed = measurements.ao.as_ref().and_then(|ao| ao.failed.iter().find(|f| f.scene == m.asked));
                let why = match (&measurements.ao, failed) {
                    (None, _) => "left out by --parts".to_owned(),
                    (_, Some(failure)) => format!("failed: {}", failure.error),
                    _ => "not measured".to_owned(),
                };
                let width = grid.columns.len() - 1 - lead.len();
                grid.rows.push(head(vec![Cell::None(why); width]));
            }
        }
    }
}

fn of<'a>(scene: &'a ao::AoScene, method: &str) -> Option<&'a AoRow> {
    scene.methods.iter().find(|r| r.method.name() == method)
}

/// Figures 1, 8 and 9.
fn inconsistency(request: &Request, measurements: &Measurements) -> Item {
    let mut columns = vec!["scene", "source"];
    columns.extend(METHODS);
    let mut share = Grid::new("Pixels that differ visibly between the eyes, of those with a pair.", &columns);
    let mut time = Grid::new("Time over that of mono.", &columns);
    let printed = |scene: &AoScene, cells: [Option<f64>; 4], digits: usize, unit: &'static str| {
        let why = "printed only in its picture";
        let head = [Cell::word(format!("{} ({})", scene.scene, scene.figure)), Cell::word(SOURCES[0])];
        head.into_iter().chain(cells.map(|v| Cell::number(v, digits, unit, why))).collect::<Vec<_>>()
    };
    for scene in [&AO_FIGURE_1].into_iter().chain(&AO_FIGURE_8) {
        share.rows.push(printed(scene, scene.inconsistent, 2, " %"));
        time.rows.push(printed(scene, scene.ms.map(|ms| Some(ms? / scene.ms[0]?)), 2, ""));
    }
    lines(measurements, &mut share, &[SOURCES[1]], |scene| {
        let cell = |method: &str| {
            let found = of(scene, method).and_then(|r| r.inconsistency);
            Cell::number(found.map(|s| 100.0 * s), 2, " %", "no pairs")
        };
        vec![METHODS.iter().map(|m| cell(m)).collect()]
    });
    lines(measurements, &mut time, &[SOURCES[1]], |scene| {
        let cell = |method: &str| Cell::number(of(scene, method).map(|r| r.ratio[1]), 2, "", "undefined");
        vec![METHODS.iter().map(|m| cell(m)).collect()]
    });
    let columns =
        ["scene", "mono, against fsa", "variant1", "variant2", "mono, against rays", "fsa", "variant1", "variant2"];
    let mut error = Grid::new("Mean absolute error of the visibility here, against fsa and against rays.", &columns);
    lines(measurements, &mut error, &[], |scene| {
        let fsa = ["mono", "variant1", "variant2"].map(|m| of(scene, m).and_then(|r| r.mae_fsa));
        let rays = METHODS.map(|m| of(scene, m).and_then(|r| r.mae_ray_traced));
        vec![fsa.into_iter().chain(rays).map(|v| Cell::number(v, 5, "", "undefined")).collect()]
    });
    Item {
        id: "ao-figure8",
        title: "Ambient occlusion, Figures 1, 8 and 9: inconsistent pixels, time, error".to_owned(),
        publication: Publication::AmbientOcclusion,
        printed_in: "Figures 1, 8 and 9, section Experiments",
        printed: "maps of the pixels that differ between the eyes by 2 % or more, their share, and milliseconds, in \
                  six views. Errors against FSA are shown as pictures."
            .to_owned(),
        here:
            "the same shares by the publication's equation 2, and times over those of mono in the same round, at the \
               first view of every scene. The errors are numbers. The publication has no comparison with rays through \
               the geometry."
                .to_owned(),
        tables: vec![share, time, error],
        differs: vec![
            OTHER_SCENES.to_owned(),
            format!("The publication: {AO_SETTING}."),
            "FSA takes less time here, because only one pixel of each pair is estimated and no neighbourhood is \
             filtered twice. So an adaptive method can save less."
                .to_owned(),
        ],
        call: call(request),
        ..Item::default()
    }
}

fn call(request: &Request) -> Option<String> {
    request.parts.contains(&super::Part::Ao).then(|| request.ao_call())
}

/// Tables 1 and 2 and Figure 10.
fn along(request: &Request, measurements: &Measurements) -> Item {
    let mut columns = vec!["scene", "source"];
    columns.extend(METHODS);
    let mut share = Grid::new("Table 1: inconsistent pixels, as means along a path.", &columns);
    for (scene, values) in AO_TABLE_1 {
        let head = [Cell::word(scene), Cell::word(SOURCES[0])];
        share.rows.push(head.into_iter().chain(values.map(|v| Cell::Number(v, 2, " %"))).collect());
    }
    let mut error = Grid::new(
        "Table 2: mean absolute error against fsa along the path.",
        &["scene", "source", "mono", "variant1", "variant2"],
    );
    for (scene, values) in AO_TABLE_2 {
        let head = [Cell::word(scene), Cell::word(SOURCES[0])];
        error.rows.push(head.into_iter().chain(values.map(|v| Cell::Number(v, 4, ""))).collect());
    }
    let mean = |path: Option<&AoPath>, method: &str, of: fn(&ao::AoPathRow) -> Option<f64>| {
        path?.methods.iter().find(|a| a.method.name() == method).and_then(of)
    };
    lines(measurements, &mut share, &[SOURCES[1]], |scene| {
        let cell = |m: &str| {
            let found = mean(scene.path.as_ref(), m, |a| a.mean_inconsistency);
            Cell::number(found.map(|s| 100.0 * s), 2, " %", "no pairs in a pose")
        };
        vec![METHODS.iter().map(|m| cell(m)).collect()]
    });
    lines(measurements, &mut error, &[SOURCES[1]], |scene| {
        let cell = |m: &str| Cell::number(mean(scene.path.as_ref(), m, |a| a.mean_mae_fsa), 4, "", "undefined");
        vec![["mono", "variant1", "variant2"].into_iter().map(cell).collect()]
    });
    Item {
        id: "ao-tables1-2",
        title: "Ambient occlusion, Tables 1 and 2 and Figure 10: along a path".to_owned(),
        publication: Publication::AmbientOcclusion,
        printed_in: "Tables 1 and 2 and Figure 10, section Experiments",
        printed: "inconsistency and error at 100 poses along a path through Sponza and along one through Bistro."
            .to_owned(),
        here: format!("{} poses of a closed path about the first view of every scene.", request.scale.ao_poses),
        tables: vec![share, error],
        drawings: drawings(measurements, "path", "Inconsistency and error along the path"),
        differs: vec![OTHER_SCENES.to_owned(), "The publication's path is not published.".to_owned()],
        call: call(request),
        ..Item::default()
    }
}

/// Table 3.
fn times(request: &Request, measurements: &Measurements) -> Item {
    let columns: Vec<&str> = ["scene", "source", "method"].into_iter().chain(PASSES.map(|(title, _)| title)).collect();
    let mut grid = Grid::new("Milliseconds by pass.", &columns);
    for t in &AO_TABLE_3 {
        let head = [t.scene, SOURCES[0], t.method].map(Cell::word);
        let passes = t.passes.map(|ms| Cell::number(ms, 2, "", DOES_WITHOUT));
        grid.rows.push(head.into_iter().chain(passes).chain([Cell::Number(t.total, 2, "")]).collect());
    }
    lines(measurements, &mut grid, &[SOURCES[1]], |scene| {
        let row = |of: &AoRow| {
            let cell = |(title, names): (&str, &[&str])| {
                let ran: Vec<f64> = names.iter().filter_map(|n| of.passes.get(*n).copied()).collect();
                let sum = (!ran.is_empty()).then(|| ran.iter().sum());
                Cell::number(if title == "total" { Some(of.ms) } else { sum }, 2, "", DOES_WITHOUT)
            };
            [Cell::word(of.method.name())].into_iter().chain(PASSES.map(cell)).collect()
        };
        scene.methods.iter().filter(|r| Ao::OF_VIEWS.contains(&r.method)).map(row).collect()
    });
    Item {
        id: "ao-table3",
        title: "Ambient occlusion, Table 3: time by pass".to_owned(),
        publication: Publication::AmbientOcclusion,
        printed_in: "Table 3, section Performance profiling",
        printed: "milliseconds of the first and of the adaptive pass in Market and Sponza.".to_owned(),
        here: "the same for every scene, as medians over the rounds. The estimate includes the search for pairs and \
               the reprojection, and the filter includes the blend."
            .to_owned(),
        tables: vec![grid],
        differs: vec![OTHER_SCENES.to_owned(), "The device differs, so only ratios can be compared.".to_owned()],
        call: call(request),
        ..Item::default()
    }
}

/// Figures 11 and 12.
fn threshold(request: &Request, measurements: &Measurements) -> Item {
    let columns = ["scene", "method", "threshold", "time over mono", "inconsistent pixels", "worked on again"];
    let mut grid = Grid::new("The adaptive methods against their threshold.", &columns);
    lines(measurements, &mut grid, &[], |scene| {
        let row = |of: &AoRow| {
            vec![
                Cell::word(of.method.name()),
                Cell::Number(100.0 * f64::from(of.threshold), 1, " %"),
                Cell::number(Some(of.ratio[1]), 2, "", "undefined"),
                Cell::number(of.inconsistency.map(|s| 100.0 * s), 2, " %", "no pairs"),
                Cell::number(of.again.map(|s| 100.0 * s), 1, " %", "undefined"),
            ]
        };
        scene.thresholds.iter().map(row).collect()
    });
    Item {
        id: "ao-figure11",
        title: "Ambient occlusion, Figures 11 and 12: the threshold".to_owned(),
        publication: Publication::AmbientOcclusion,
        printed_in: "Figures 11 and 12, section Stereo consistency v.s. performance",
        printed: "the time of both variants against the threshold in Sponza, as curves, and maps of the pixels that \
                  each threshold marks. The text says that both variants take about as long at 1 %, and that variant 1 \
                  takes less time above it."
            .to_owned(),
        here: "the time, the inconsistency and the share of the pixels that were processed further, at six thresholds \
               in every scene."
            .to_owned(),
        tables: vec![grid],
        drawings: drawings(measurements, "threshold", "Time and inconsistency against the threshold"),
        differs: vec![OTHER_SCENES.to_owned()],
        call: call(request),
        ..Item::default()
    }
}

fn drawings(measurements: &Measurements, which: &str, caption: &str) -> Vec<Drawing> {
    let scenes = measurements.ao.iter().flat_map(|ao| &ao.scenes);
    let of = |scene: &ao::AoScene| {
        let found = ao::drawings(scene).into_iter().find(|(what, _)| *what == which)?;
        Some(Drawing { caption: format!("{caption} in {}.", scene.scene), svg: found.1 })
    };
    scenes.filter_map(of).collect()
}
