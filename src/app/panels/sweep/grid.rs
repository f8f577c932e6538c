//! Which settings a sweep goes over: choices that are on or off, and lists of numbers.

use egui::{Button, RichText, TextEdit, Ui, vec2};

use crate::accel::{BuildConfig, Builder, Improver, StopRule, Widen, Width};
use crate::inspect::sweep::SweepGrid;

use super::super::glossary::Term;
use super::super::widgets;

/// What is chosen, and the texts of the lists.
pub struct GridForm {
    builders: Vec<Builder>,
    widths: Vec<Width>,
    widens: Vec<Widen>,
    stops: Vec<StopRule>,
    improvers: Vec<Improver>,
    bins: String,
    leaf: String,
    traversal: String,
}

impl GridForm {
    /// The grid around some settings.
    pub fn of(base: &BuildConfig) -> Self {
        let SweepGrid { builders, widths, widens, stops, improvers, bins, leaf, .. } =
            SweepGrid::around(base);
        let text = |list: &[usize]| list.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let (bins, leaf) = (text(&bins), text(&leaf));
        let traversal = "0.5, 1, 2, 4".to_owned();
        Self { builders, widths, widens, stops, improvers, bins, leaf, traversal }
    }

    /// Draws it.
    ///
    /// # Errors
    /// What is wrong with a list, in a sentence.
    pub fn ui(&mut self, ui: &mut Ui, base: &BuildConfig) -> Result<SweepGrid, String> {
        chips(ui, Term::Builder, &mut self.builders, &Builder::ALL, |b| (b.name(), b.description()));
        chips(ui, Term::Width, &mut self.widths, &Width::ALL, |w| (w.name(), "children a node at most"));
        if self.widths.iter().any(|w| *w != Width::W2) {
            chips(ui, Term::Widen, &mut self.widens, &Widen::ALL, |w| (w.name(), w.description()));
        }
        chips(ui, Term::Stop, &mut self.stops, &StopRule::ALL, |s| (s.name(), s.description()));
        chips(ui, Term::Improver, &mut self.improvers, &Improver::ALL, |i| (i.name(), i.description()));
        let has_bins = self.builders.iter().any(|b| b.uses_bins());
        list(ui, Term::BinsList, &mut self.bins, has_bins);
        list(ui, Term::LeafList, &mut self.leaf, true);
        let weighs = self.weighs_costs();
        list(ui, Term::TraversalList, &mut self.traversal, weighs);
        self.grid(base)
    }

    /// The grid that is set.
    ///
    /// # Errors
    /// What is wrong with a list, in a sentence.
    pub fn grid(&self, base: &BuildConfig) -> Result<SweepGrid, String> {
        let traversal_costs = match self.weighs_costs() {
            true => numbers(&self.traversal, "C_t", |x: &f32| *x >= 1e-6 && *x <= BuildConfig::MAX_COST)?,
            false => vec![base.traversal_cost],
        };
        Ok(SweepGrid {
            builders: self.builders.clone(),
            widths: self.widths.clone(),
            widens: self.widens.clone(),
            stops: self.stops.clone(),
            improvers: self.improvers.clone(),
            bins: numbers(&self.bins, "Bins", |n: &usize| BuildConfig::BINS.contains(n))?,
            leaf: numbers(&self.leaf, "Leaf limits", |n: &usize| BuildConfig::LEAF.contains(n))?,
            traversal_costs,
            ..SweepGrid::around(base)
        })
    }

    fn weighs_costs(&self) -> bool {
        let optimal = self.widens.contains(&Widen::Optimal) && self.widths.iter().any(|w| *w != Width::W2);
        optimal || self.stops.contains(&StopRule::Cost)
    }
}

/// Choices of which each is on or off; one always is on.
fn chips<T: Copy + PartialEq>(
    ui: &mut Ui,
    term: Term,
    chosen: &mut Vec<T>,
    all: &[T],
    describe: impl Fn(T) -> (&'static str, &'static str),
) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(3.0, 3.0);
        let label = RichText::new(term.label());
        ui.add(egui::Label::new(label).selectable(false)).on_hover_text(term.text());
        ui.add_space(4.0);
        for &choice in all {
            let (name, description) = describe(choice);
            let on = chosen.contains(&choice);
            let button = Button::selectable(on, name).frame_when_inactive(true);
            let response = ui
                .add(button)
                .on_hover_text(format!("{name}: {description}"))
                .accessible_name(format!("Sweep {} {name}", term.label()));
            if response.clicked() {
                if !on {
                    chosen.push(choice);
                    chosen.sort_by_key(|c| all.iter().position(|a| a == c));
                } else if chosen.len() > 1 {
                    chosen.retain(|c| *c != choice);
                }
            }
        }
    });
}

fn list(ui: &mut Ui, term: Term, text: &mut String, enabled: bool) {
    widgets::row(ui, term, |ui| {
        let edit = TextEdit::singleline(text).desired_width(ui.available_width());
        ui.add_enabled(enabled, edit).accessible_name(term.label()).on_hover_text(term.text());
    });
}

/// Numbers with commas or blanks between.
fn numbers<T: std::str::FromStr>(
    text: &str,
    name: &str,
    allowed: impl Fn(&T) -> bool,
) -> Result<Vec<T>, String> {
    let parts = text.split([',', ' ']).filter(|part| !part.is_empty());
    let mut found = Vec::new();
    for part in parts {
        match part.parse::<T>() {
            Ok(number) if allowed(&number) => found.push(number),
            _ => return Err(format!("{name}: '{part}' is not allowed there.")),
        }
    }
    if found.is_empty() { Err(format!("{name}: the list is empty.")) } else { Ok(found) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_with_commas_and_blanks_and_refused_with_a_reason() {
        let bins = |text| numbers(text, "Bins", |n: &usize| BuildConfig::BINS.contains(n));
        assert_eq!(bins("4, 8,16 32"), Ok(vec![4, 8, 16, 32]));
        assert_eq!(bins("4, 999"), Err("Bins: '999' is not allowed there.".to_owned()));
        assert_eq!(bins(" , "), Err("Bins: the list is empty.".to_owned()));
    }

    #[test]
    fn costs_count_only_where_something_weighs_them() {
        let base = BuildConfig::default();
        let mut form = GridForm::of(&base);
        assert_eq!(form.grid(&base).map(|grid| grid.count(&base)), Ok(40));
        form.stops.push(StopRule::Cost);
        assert_eq!(form.grid(&base).map(|grid| grid.count(&base)), Ok(40 + 4 * 40));
        form.traversal = "x".to_owned();
        assert!(form.grid(&base).is_err());
    }
}
