//! What `study check` reports of a study that can be read: conditions, an order, its length, and what must be rendered.

use cyclopean_analysis::journal::record::{Condition, Purpose, Side};
use serde::Serialize;

use super::definition::{Definition, OrderKind};
use super::observer::SimulatedObserver;
use super::order;
use super::plan::Plan;
use super::store::Store;

/// See the module's documentation.
#[derive(Debug, Clone, Serialize)]
pub struct Preview {
    pub study: String,
    pub conditions: Vec<Condition>,
    pub row: u64,
    /// Indices into `conditions`, in the order of the row, with what each presentation is for.
    pub order: Vec<PreviewedPresentation>,
    /// Length of presentations, blanks and answers, without pages and breaks.
    pub minutes: f64,
    pub stimuli: usize,
    /// Stimuli that are not whole in the store.
    pub to_render: Vec<String>,
    pub warnings: Vec<String>,
}

#[derive(Debug, Clone, Serialize)]
pub struct PreviewedPresentation {
    pub condition: u32,
    pub purpose: Purpose,
    pub a_is: Option<Side>,
}

/// A person's usual time on the panel, seconds, for a study that does not state it.
const ANSWER_SECONDS: f64 = 4.0;

impl Preview {
    pub fn new(definition: &Definition, store: &Store, row: u64) -> Preview {
        let plan = Plan::draw(definition, row);
        let shown = |p: &cyclopean_analysis::journal::record::Planned| PreviewedPresentation {
            condition: p.condition,
            purpose: p.purpose,
            a_is: p.a_is,
        };
        let answer = definition.simulation.as_ref().map_or(ANSWER_SECONDS, |s| s.response_seconds);
        let segments: f64 = definition.protocol.iter().map(|s| s.seconds).sum();
        let each = segments + 2.0 * definition.blank.seconds + answer;
        Preview {
            study: definition.id.clone(),
            row,
            order: plan.presentations.iter().map(shown).collect(),
            minutes: each * plan.presentations.len() as f64 / 60.0,
            stimuli: plan.stimuli.len(),
            to_render: plan.stimuli.iter().filter(|s| store.find(s).is_err()).map(|s| s.label()).collect(),
            warnings: warnings(definition, &plan),
            conditions: plan.conditions,
        }
    }

    /// The report for people, line by line.
    pub fn lines(&self) -> Vec<String> {
        let mut out = vec![format!("study {}: {} conditions", self.study, self.conditions.len())];
        for condition in &self.conditions {
            let factors: Vec<String> = condition.factors.iter().map(|(k, v)| format!("{k} {v}")).collect();
            out.push(format!("  {:>3}  {}", condition.id, factors.join(", ")));
        }
        let word = |s: &PreviewedPresentation| match s.purpose {
            Purpose::Practice => format!("({})", s.condition),
            Purpose::Trial => s.condition.to_string(),
            Purpose::Catch => format!("[{}]", s.condition),
        };
        let order: Vec<String> = self.order.iter().take(200).map(word).collect();
        let more = if self.order.len() > 200 { " …" } else { "" };
        out.push(format!("order of row {} ((practice), [catch]): {}{more}", self.row, order.join(" ")));
        out.push(format!("length: {:.1} minutes, without pages and breaks", self.minutes));
        out.push(format!("stimuli: {}, of them to render: {}", self.stimuli, self.to_render.len()));
        out.extend(self.to_render.iter().map(|label| format!("  {label}")));
        out.extend(self.warnings.iter().map(|w| format!("warning: {w}")));
        out
    }
}

fn warnings(d: &Definition, plan: &Plan) -> Vec<String> {
    let mut out = Vec::new();
    let n = d.conditions().len();
    let rows = if d.order.kind == OrderKind::LatinSquare { order::williams_rows(n) } else { 1 };
    if u64::from(d.participants) % rows != 0 {
        let participants = d.participants;
        out.push(format!("{n} conditions need {rows} rows; {participants} participants are no multiple: unbalanced"));
    }
    if d.analysis.equivalence.is_some() && d.participants < 15 {
        out.push(format!("{} participants: equivalence has little power below 15", d.participants));
    }
    if plan.presentations.iter().any(|p| p.a_is.is_some()) && d.participants % 2 == 1 {
        out.push("an odd number of participants: A and B are balanced over pairs of rows".to_owned());
    }
    let nothing_measured = vec![None; plan.stimuli.len()];
    let derives = d.simulation.as_ref().is_some_and(|s| s.from_inconsistency.is_some());
    if let Err(error) = SimulatedObserver::new(d, plan, &[], "p", &nothing_measured)
        && !derives
    {
        out.push(format!("a dry run is not possible: {error}"));
    }
    out
}
