//! The tree follows the session: whenever scene, moment or settings differ from the tree at hand, the next one is built.

use std::sync::Arc;

use super::Jobs;
use crate::app::jobs::TreeKey;
use crate::app::jobs::build::{BuildMessage, BuildRequest};
use crate::app::jobs::figures::FiguresKey;
use crate::app::state::State;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for message in jobs.build.poll(&context) {
        match message {
            BuildMessage::Built { key, world } => {
                let Some(document) = &mut state.document else { continue };
                if document.load != key.scene.load {
                    continue;
                }
                let is_new_moment = document.tree.scene != key.scene;
                let broken = super::load::broken_tree(&world).filter(|_| document.tree.file != key.file);
                state.marked = state.marked.take().filter(|_| document.tree.file == key.file);
                document.world = Arc::clone(&world);
                document.tree = key;
                // A moving scene would fill the history with the same settings again and again.
                if !is_new_moment {
                    state.remember_build(key, &world);
                }
                if let Some(message) = broken {
                    state.messages.error(message);
                }
            }
            BuildMessage::Failed { key, message } => {
                state.messages.error(message);
                if jobs.memo.build == Some(key) {
                    state.session.set_tree(None);
                }
            }
            BuildMessage::Counted { key, rays } => {
                state.remember_rays(&key.tree, &rays);
                state.figures = Some((key, rays));
            }
        }
    }
}

pub fn start(jobs: &mut Jobs, state: &State) {
    let (Some(document), Some(scene), Some(camera)) = (&state.document, state.wanted_scene(), state.camera())
    else {
        return;
    };
    let key = TreeKey::wanted(scene, &state.session);
    if jobs.memo.build == Some(key) {
        return;
    }
    jobs.memo.build = Some(key);
    if document.tree == key {
        // Back at the tree at hand: nothing to build, and nothing that runs is wanted.
        jobs.build.cancel();
        return;
    }
    let staged = (document.tree.scene == scene).then(|| Arc::clone(&document.world.scene));
    let is_only_moved = document.tree.config == key.config && document.tree.file == key.file;
    let before = is_only_moved.then(|| Arc::clone(&document.world));
    let [width, height] =
        state.measured_size().unwrap_or([state.session.render.width, state.session.render.height]);
    let request = BuildRequest {
        key,
        still: Arc::clone(&document.still),
        staged,
        before,
        session: state.session.clone(),
        figures: FiguresKey { tree: key, camera, width, height },
    };
    let context = jobs.context.clone();
    jobs.build.request(&context, request);
}
