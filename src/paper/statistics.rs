//! Figures 18 and 19 and the signed-rank test. The analysis of the sessions goes in, and [`Item`]s come out;
//! `super::items` calls it.

use cyclopean_analysis::report::{ReportInput, StudyReport, scores};
use cyclopean_analysis::special::p_text;

use super::Sessions;
use super::item::{Cell, Grid, Item};
use super::plan::Request;
use super::published::{Publication, STUDY};
use super::tables::SOURCES;

/// The study of Figure 19 and of the signed-rank test, then the studies of Figure 18: the study, the figure, and what
/// was asked.
const CONSISTENCY: &str = "consistency";
const CHOICES: [(&str, &str, &str); 2] = [
    ("quality", "18 (a)", "visual quality of Ours beside SSSR, in three scenes and both eyes"),
    ("ablation", "18 (b)", "consistency of Ours beside Ours without one module, in Pica"),
];

/// All items of the studies.
pub fn items(request: &Request, sessions: &Sessions) -> Vec<Item> {
    let mut all = vec![opinions(request, sessions), test(request, sessions)];
    all.extend(CHOICES.map(|choice| choices(request, sessions, choice)));
    if let Ok(input) = sessions {
        let known = |id: &str| id == CONSISTENCY || CHOICES.iter().any(|c| c.0 == id);
        let others = input.studies.iter().filter(|s| !known(&s.study.id));
        all.extend(others.map(|study| other(input, study)));
    }
    all
}

fn study<'a>(sessions: &'a Sessions, id: &str) -> Result<(&'a ReportInput, &'a StudyReport), String> {
    let input = sessions.as_ref().map_err(Clone::clone)?;
    let found = input.studies.iter().find(|s| s.study.id == id);
    found.map(|s| (input, s)).ok_or_else(|| format!("no session of the study {id} was given"))
}

/// The end of a title, such as ` (SIMULATED data)`. It is empty where the sessions are people's answers.
fn stamp(sessions: &Sessions) -> String {
    let stamp = sessions.as_ref().ok().and_then(|input| input.stamp.as_deref());
    stamp.map_or(String::new(), |s| format!(" ({} data)", s.to_uppercase()))
}

/// A caption, with `SIMULATED data. ` or the like in front where the sessions are not people's answers.
fn stamped(sessions: &Sessions, caption: &str) -> String {
    let stamp = sessions.as_ref().ok().and_then(|input| input.stamp.as_deref());
    stamp.map_or(caption.to_owned(), |s| format!("{} data. {caption}", s.to_uppercase()))
}

/// The differences from the publication that all studies have.
fn differs(sessions: &Sessions) -> Vec<String> {
    let mut all = vec![
        "The publication's study was done on a PICO 4 Enterprise headset by ten people.".to_owned(),
        super::tables::OTHER_SCENES.to_owned(),
    ];
    if let Ok(ReportInput { stamp: Some(stamp), .. }) = sessions {
        let simulated = "The votes are drawn from a model that is written in the study file. They only show that \
                         everything works together. --sessions DIR takes real votes.";
        let other = format!("The sessions are {stamp}: they are not people's answers to the study.");
        all.insert(0, if stamp == "simulated" { simulated.to_owned() } else { other });
    }
    all
}

/// An item with the properties that the items of all studies share.
fn base(id: &'static str, title: String, printed_in: &'static str, printed: String, here: String) -> Item {
    Item { id, title, publication: Publication::Reflection, printed_in, printed, here, ..Item::default() }
}

/// Figure 19.
fn opinions(request: &Request, sessions: &Sessions) -> Item {
    let printed = "mean opinion scores of consistency with 90 % intervals, as bars, of SSSR, Ours and RayTracing in \
                   Pica, Room and Wine. Their numbers are not printed.";
    let here = "the same for the study consistency: the mean over participants, and its interval by Student's t at the \
                level that the study file fixed.";
    let title = format!("Figure 19: mean opinion scores of consistency{}", stamp(sessions));
    let item = base("figure19", title, "Figure 19, section 6.2", printed.to_owned(), here.to_owned());
    with_scores(request, sessions, item, CONSISTENCY)
}

/// Adds a study's scores to an item, or says why there are none.
fn with_scores(request: &Request, sessions: &Sessions, mut item: Item, id: &str) -> Item {
    match study(sessions, id) {
        Ok((input, study)) => {
            item.blocks = scores(input, study);
            item.differs = differs(sessions);
        }
        Err(why) => {
            let mut grid = Grid::new("There are no numbers of this program.", &["study", "why"]);
            grid.rows.push(vec![Cell::word(id), Cell::None(why)]);
            item.tables.push(grid);
        }
    }
    item.call = request.sessions_call();
    item
}

/// The signed-rank test of §6.2.
fn test(request: &Request, sessions: &Sessions) -> Item {
    let columns = ["source", "contrast", "n", "z", "p", "p, exact"];
    let mut grid = Grid::new(stamped(sessions, "Wilcoxon's signed-rank test of the first study."), &columns);
    grid.rows.push(vec![
        Cell::word(SOURCES[0]),
        Cell::word("Ours and SSSR"),
        Cell::Number(f64::from(STUDY.participants), 0, ""),
        Cell::Number(STUDY.z, 3, ""),
        Cell::Number(STUDY.p, 3, ""),
        Cell::None("not printed".to_owned()),
    ]);
    let why = match study(sessions, CONSISTENCY) {
        Err(why) => Some(why),
        Ok((_, study)) => match study.all.contrasts.iter().find(|c| c.contrast.family == "primary") {
            None => Some("its file fixes no primary contrast".to_owned()),
            Some(c) => {
                let p = |p: Option<f64>| p.map_or(Cell::None("not computed".to_owned()), |p| Cell::word(p_text(p)));
                grid.rows.push(vec![
                    Cell::word(SOURCES[1]),
                    Cell::word(format!("{} − {}", c.contrast.a, c.contrast.b)),
                    Cell::Number(c.test.n as f64, 0, ""),
                    Cell::number(c.test.z, 3, "", "no difference"),
                    p(c.test.p_asymptotic),
                    p(c.test.p_exact),
                ]);
                None
            }
        },
    };
    if let Some(why) = why {
        let cells = vec![Cell::None(why); columns.len() - 1];
        grid.rows.push([Cell::word(SOURCES[1])].into_iter().chain(cells).collect());
    }
    let title = format!("The signed-rank test{}", stamp(sessions));
    let printed = format!(
        "z = {:.3} and p = {:.3}, which is below 0.01: a significant reduction in visual discomfort, with {} \
         participants.",
        STUDY.z, STUDY.p, STUDY.participants
    );
    let here = "the test of the contrast that the study file fixed beforehand, on each participant's sum over the \
                scenes. z is positive where the first method has the higher scores. The publication takes the \
                difference the other way round.";
    let mut item = base("signed-rank", title, "section 6.2", printed, here.to_owned());
    item.tables.push(grid);
    item.differs = vec![
        "The publication says neither what it pairs (participants or votes) nor how it treats ties and zeros."
            .to_owned(),
    ];
    item.differs.extend(differs(sessions));
    item.call = request.sessions_call();
    item
}

/// Figure 18.
fn choices(request: &Request, sessions: &Sessions, (id, figure, what): (&'static str, &str, &str)) -> Item {
    let title = format!("Figure {figure}: choices, study {id}{}", stamp(sessions));
    let printed = format!(
        "the distribution of the choices ({what}) and their mean scores, as bars. The text says that every mean is \
         above {:.1}. A score of 2 means no difference, and 3 means that Ours was chosen.",
        STUDY.preference_above
    );
    let mut item = base(
        if id == "quality" { "figure18a" } else { "figure18b" },
        title,
        "Figure 18, section 6.2",
        printed,
        format!("the same for the study {id}."),
    );
    let columns = ["condition", "mean score, printed", "mean score here", "other", "no difference", "Ours"];
    if let Ok((_, study)) = study(sessions, id)
        && let Some(preference) = &study.all.preference
    {
        let mut grid = Grid::new(stamped(sessions, "Mean scores and choices, condition by condition."), &columns);
        for c in &preference.conditions {
            let varies = |f: &&(String, String)| preference.conditions.iter().any(|o| !o.factors.contains(f));
            let name: Vec<&str> = c.factors.iter().filter(varies).map(|f| f.1.as_str()).collect();
            grid.rows.push(vec![
                Cell::word(if name.is_empty() { "all".to_owned() } else { name.join(", ") }),
                Cell::word(format!("above {:.1}", STUDY.preference_above)),
                Cell::Number(c.mos, 2, ""),
                Cell::Number(c.votes.losses as f64, 0, ""),
                Cell::Number(c.votes.ties as f64, 0, ""),
                Cell::Number(c.votes.wins as f64, 0, ""),
            ]);
        }
        item.tables.push(grid);
    }
    with_scores(request, sessions, item, id)
}

/// A study that the publication does not have.
fn other(input: &ReportInput, study: &StudyReport) -> Item {
    let title = study.study.title.clone().unwrap_or_else(|| study.study.id.clone());
    let stamp = input.stamp.as_deref().map_or(String::new(), |s| format!(" ({} data)", s.to_uppercase()));
    let mut item = base(
        "other-study",
        format!("Study {}: {title}{stamp}", study.study.id),
        "nowhere",
        "no such study.".to_owned(),
        "its scores and tests.".to_owned(),
    );
    item.blocks = scores(input, study);
    item
}
