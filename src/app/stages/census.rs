//! What is known of every node, while somebody looks at it: the family at once, the rest when the camera rests.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::TreeKey;
use crate::app::jobs::census::{CensusMessage, CensusRequest, CensusWants, VisitsKey};
use crate::app::state::State;
use crate::app::view::SiblingKey;
use crate::inspect::census::Weight;
use crate::world::NodeFigure;

/// What was last asked for.
pub type CensusMemo = Option<(TreeKey, CensusWants)>;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for message in jobs.census.poll(&context) {
        match message {
            CensusMessage::Census { tree, census } => state.census = Some((tree, census)),
            CensusMessage::Overlaps { tree, measure, pairs } => {
                state.overlaps = Some((tree, measure, Arc::new(pairs)));
            }
            CensusMessage::Visits { key, visits } => state.visits = Some((key, Arc::new(visits))),
        }
    }
}

/// Follows the tree that is shown, and asks for what is looked at.
pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let Some(document) = &state.document else { return };
    let tree = document.tree;
    state.selections.follow(&document.world, tree);
    let looked_at =
        now.showing.tree || now.showing.rays || now.showing.splits || state.selections.current().is_some();
    if !looked_at || state.animating {
        if jobs.memo.census.take().is_some() {
            jobs.census.cancel();
        }
        return;
    }
    let wants = missing(state, now, tree);
    let census = state.census.as_ref().filter(|(key, _)| *key == tree).map(|(_, census)| Arc::clone(census));
    if census.is_some() && wants == CensusWants::default() {
        return;
    }
    // What was asked for and not found out is not asked for again and again.
    let is_asked = |(asked_tree, asked): (TreeKey, CensusWants)| {
        let running = !jobs.census.is_idle();
        asked_tree == tree
            && (if running { wants.is_within(&asked) } else { wants == asked && census.is_some() })
    };
    if jobs.memo.census.is_some_and(is_asked) {
        return;
    }
    jobs.memo.census = Some((tree, wants));
    let request = CensusRequest {
        tree,
        world: Arc::clone(&document.world),
        census,
        settings: state.session.render,
        wants,
    };
    let context = jobs.context.clone();
    jobs.census.request(&context, request);
}

/// What is looked at and not known.
fn missing(state: &State, now: &Now, tree: TreeKey) -> CensusWants {
    let Some(document) = &state.document else { return CensusWants::default() };
    let census = state.census.as_ref().filter(|(key, _)| *key == tree).map(|(_, census)| census);
    let view = &state.tree_view;
    let is_known = |figure| census.is_some_and(|census| census.known_values(figure).is_some());
    let figure = Some(view.figure).filter(|f| now.showing.tree && *f != NodeFigure::Visits && !is_known(*f));
    let by = |weight| view.weight == weight || view.order == SiblingKey::Weight(weight);
    let sah_below = !census.is_some_and(|census| census.knows_sah_below());
    let overlaps = Some(view.measure).filter(|measure| {
        let known = state.overlaps.as_ref();
        now.showing.tree && known.is_none_or(|(key, known, _)| *key != tree || known != measure)
    });
    let wants_visits = now.showing.tree
        && (by(Weight::Visits) || view.figure == NodeFigure::Visits || state.selections.current().is_some());
    // A broken tree is drawn, but another one is traced.
    let is_traced = std::ptr::eq(document.world.shown_tree(), &document.world.tree);
    let rests = now.hold || !state.is_moving(now.time);
    let visits = visits_key(state, tree).filter(|key| {
        let is_known = state.visits.as_ref().is_some_and(|(known, _)| known == key);
        wants_visits && is_traced && rests && !is_known
    });
    CensusWants { figure, sah_below, overlaps, visits }
}

/// Of the frame that is looked at now.
fn visits_key(state: &State, tree: TreeKey) -> Option<VisitsKey> {
    let [width, height] = state.measured_size()?;
    Some(VisitsKey { tree, camera: state.camera()?, width, height, count: state.session.count })
}
