//! Figures 1 and 9 to 14: sheets with enlarged parts, and numbers of the views that they show. What was measured goes
//! in, and [`Item`]s come out; `super::items` calls it.

use super::Measurements;
use super::item::{Cell, Grid, Item, Picture};
use super::plan::Request;
use super::published::Publication;
use super::tables::{OTHER_SCENES, call, comparison};
use crate::compare::Row;

/// A figure that shows methods side by side.
struct MethodSheet {
    id: &'static str,
    title: &'static str,
    printed_in: &'static str,
    printed: &'static str,
    here: &'static str,
    /// What differs besides the scenes.
    differs: &'static str,
}

const STEPS: [MethodSheet; 4] = [
    MethodSheet {
        id: "figure11",
        title: "Figure 11: the stereo-aware traversal",
        printed_in: "Figure 11, section 5.3",
        printed: "a part of Pica in which each eye's view lacks different geometry. The traversal of both views fills \
                  in what SSSR misses.",
        here: "sssr against the method without reprojection, both without any fade, so that only the traversal \
               differs.",
        differs: "The publication turns the traversal off in its full method. Here the reprojection would hide that, \
                  since it fills the same gaps.",
    },
    MethodSheet {
        id: "figure12",
        title: "Figure 12: the stereo-aware fade",
        printed_in: "Figure 12, section 5.3",
        printed: "a part of Wine at the border of the views. SSSR is bright in the left eye and dark in the right one, \
                  and a common fade makes both eyes alike.",
        here: "the method with each eye's own fade against the method.",
        differs: "The publication compares its method with SSSR. Here only the fade differs.",
    },
    MethodSheet {
        id: "figure13",
        title: "Figure 13: the stereo-aware reprojection",
        printed_in: "Figure 13, section 5.3",
        printed: "a part of Pica in which the noise differs between the eyes. Reprojection removes the difference.",
        here: "the method without reprojection against the method.",
        differs: "One frame of each is shown here. The publication shows consecutive frames in a video.",
    },
    MethodSheet {
        id: "figure14",
        title: "Figure 14: incorrect reuse",
        printed_in: "Figure 14, section 5.3",
        printed: "a part of Room in which pixels that do not belong together were reused as pairs, and the same part \
                  with a check of the pairs.",
        here: "the method without the check that a pair leads back, against the method. Its other checks stay on.",
        differs: "The publication does not say which of its checks it turns off.",
    },
];

fn pictures(measurements: &Measurements, id: &str) -> Vec<Picture> {
    let of = measurements.sheets.iter().filter(|s| s.comparison == id);
    let picture = |s: &super::Sheet| Picture {
        caption: format!(
            "{}: both eyes, enlarged parts, and where the eyes disagree, for each method and then for the reference \
             ({}).",
            s.scene, s.file
        ),
        file: s.file.clone(),
        png: s.png.clone(),
    };
    of.map(picture).collect()
}

/// The table of numbers beside the sheets of a comparison, with a row for each method.
fn measured(request: &Request, measurements: &Measurements, id: &str) -> Grid {
    let columns = [
        "scene",
        "method",
        "RSE, left",
        "RSE, right",
        "1 − SSIM, left",
        "1 − SSIM, right",
        "eyes > 5 %",
        "eyes > 20 %",
    ];
    let caption = "Numbers of the whole views, as means over the rounds. RSE and 1 − SSIM are of the reflection. The \
                   last two columns are shares of the pairs of pixels that show one reflection to both eyes: those \
                   whose luminances differ in a frame by more than 5 % and by more than 20 %.";
    let mut grid = Grid::new(caption, &columns);
    let scenes = comparison(request, id).map(|c| c.scenes).unwrap_or_default();
    let requested_scenes = measurements.scenes.iter().filter(|m| scenes.is_empty() || scenes.contains(&m.asked));
    for m in requested_scenes {
        let why = measurements.why(id, &m.name);
        let Some(scene) = measurements.scene(id, &m.name) else {
            let cells = vec![Cell::None(why); columns.len() - 1];
            grid.rows.push([Cell::word(&m.name)].into_iter().chain(cells).collect());
            continue;
        };
        let row = |row: &Row| {
            let eye = |left: bool, measure: &str| {
                let eye = if left { &row.left } else { &row.right };
                eye.means.get(measure).copied().flatten()
            };
            let lacks = |left: bool| eye(left, "reflection_ssim").map(|s| 1.0 - s);
            let over = |percent: u32| {
                let share = row.noise_over.as_ref().and_then(|shares| shares.get(&percent));
                Cell::number(share.map(|s| 100.0 * s), 1, " %", "no pairs")
            };
            vec![
                Cell::word(&m.name),
                Cell::word(format!("{}@{}", row.method, row.spp)),
                Cell::number(eye(true, "rse"), 3, "", &why),
                Cell::number(eye(false, "rse"), 3, "", &why),
                Cell::number(lacks(true), 3, "", &why),
                Cell::number(lacks(false), 3, "", &why),
                over(5),
                over(20),
            ]
        };
        grid.rows.extend(scene.results.iter().map(row));
    }
    grid
}

fn item(request: &Request, measurements: &Measurements, id: &'static str, step: &MethodSheet) -> Item {
    Item {
        id: step.id,
        title: step.title.to_owned(),
        publication: Publication::Reflection,
        printed_in: step.printed_in,
        printed: step.printed.to_owned(),
        here: step.here.to_owned(),
        tables: vec![measured(request, measurements, id)],
        pictures: pictures(measurements, id),
        differs: vec![OTHER_SCENES.to_owned(), step.differs.to_owned()],
        call: call(request, id),
        ..Item::default()
    }
}

/// Figures 1 and 9, which are of the same comparison as Table 2.
pub fn overview(request: &Request, measurements: &Measurements) -> Item {
    let step = MethodSheet {
        id: "figure9",
        title: "Figures 1 and 9: every scene",
        printed_in: "Figures 1 and 9, section 5.1",
        printed: "the five scenes by Ours, with enlarged parts of both eyes by SSSR, Ours and the ground truth.",
        here: "every scene by sssr and stereo with one ray a pixel, and the reference. The parts are those in which \
               the two differ most.",
        differs: "The program finds the parts, and the publication's authors chose theirs. Its pictures are not copied \
                  here.",
    };
    item(request, measurements, "table2", &step)
}

/// Figure 10.
pub fn equal_samples(request: &Request, measurements: &Measurements) -> Item {
    let step = MethodSheet {
        id: "figure10",
        title: "Figure 10: equal samples",
        printed_in: "Figure 10, section 5.1",
        printed: "parts by SSSR, by SSSR with two samples a pixel and by Ours, with their relative squared errors. \
                  More samples do not resolve the inconsistency.",
        here: "sssr with one and with two rays a pixel and stereo with one. The sheets print the error of each part.",
        differs: "The printed errors belong to parts of the publication's scenes, and are printed only inside its \
                  picture.",
    };
    item(request, measurements, "figure10", &step)
}

/// Figures 11 to 14.
pub fn steps(request: &Request, measurements: &Measurements) -> Vec<Item> {
    STEPS.iter().map(|step| item(request, measurements, step.id, step)).collect()
}
