//! Films by key: what was rendered once is kept, so that going back to a view or a tree continues where it was.

use std::sync::Arc;

use super::super::keys::FilmKey;
use crate::render::Film;
use crate::render::film::FilmContent;

/// Films, the most recently used last, at most a fixed number of bytes and never less than two.
#[derive(Debug)]
pub struct FilmStore {
    films: Vec<(FilmKey, Arc<Film>)>,
    most_bytes: usize,
}

impl FilmStore {
    pub fn new(most_bytes: usize) -> Self {
        Self { films: Vec::new(), most_bytes }
    }

    /// The film of that key; an empty one if there is none yet.
    pub fn take(&mut self, key: &FilmKey) -> Arc<Film> {
        match self.films.iter().position(|(k, _)| k == key) {
            Some(i) => self.films.remove(i).1,
            None => Arc::new(Film::new(key.width, key.height, key.subject)),
        }
    }

    /// Keeps a film, and forgets those that were not used for longest.
    pub fn put(&mut self, key: FilmKey, film: Arc<Film>) {
        self.films.retain(|(k, _)| *k != key);
        self.films.push((key, film));
        let mut bytes: usize = self.films.iter().map(|(_, film)| film_bytes(film)).sum();
        while bytes > self.most_bytes && self.films.len() > 2 {
            let (_, oldest) = self.films.remove(0);
            bytes -= film_bytes(&oldest);
        }
    }

    pub fn get(&self, key: &FilmKey) -> Option<&Arc<Film>> {
        self.films.iter().find(|(k, _)| k == key).map(|(_, film)| film)
    }

    /// Samples a pixel of that key's film.
    pub fn samples(&self, key: &FilmKey) -> u32 {
        self.get(key).map_or(0, |film| film.samples)
    }

    /// Forgets the films of other loads: those scenes are gone.
    pub fn keep_loads(&mut self, loads: &[u64]) {
        self.films.retain(|(key, _)| loads.contains(&key.scene.load));
    }
}

fn film_bytes(film: &Film) -> usize {
    match &film.content {
        FilmContent::Color(pixels) => size_of_val(&pixels[..]),
        FilmContent::Number(pixels) => size_of_val(&pixels[..]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::BuildConfig;
    use crate::app::jobs::keys::{SceneKey, TreeKey};
    use crate::render::film::FilmSubject;
    use crate::render::{CountKind, RenderSettings, View};
    use crate::scene::{Camera, ShadowRule};

    fn key(seed: u64, load: u64) -> FilmKey {
        let tree = TreeKey { scene: SceneKey::for_tests(load), config: BuildConfig::default(), file: None };
        let subject = FilmSubject {
            view: View::Depth,
            count: CountKind::default(),
            shadow_rule: ShadowRule::default(),
        };
        let settings = RenderSettings { width: 10, height: 10, seed, ..Default::default() };
        FilmKey::new(&tree, &Camera::default(), &settings, subject)
    }

    fn film(samples: u32) -> Arc<Film> {
        let content = FilmContent::Number(vec![0.0; 100]);
        Arc::new(Film { width: 10, height: 10, subject: key(0, 1).subject, samples, content })
    }

    #[test]
    fn the_longest_unused_film_is_forgotten_first() {
        let mut store = FilmStore::new(1200);
        for seed in 0..3 {
            store.put(key(seed, 1), film(seed as u32 + 1));
        }
        let first = store.take(&key(0, 1));
        store.put(key(0, 1), first);
        store.put(key(3, 1), film(4));
        assert_eq!(store.samples(&key(1, 1)), 0, "the one that was not used");
        assert_eq!([0, 2, 3].map(|seed| store.samples(&key(seed, 1))), [1, 3, 4]);
    }

    #[test]
    fn two_films_are_kept_whatever_their_size() {
        let mut store = FilmStore::new(1);
        store.put(key(0, 1), film(1));
        store.put(key(1, 1), film(2));
        assert_eq!([0, 1].map(|seed| store.samples(&key(seed, 1))), [1, 2]);
    }

    #[test]
    fn another_scene_empties_the_store() {
        let mut store = FilmStore::new(10_000);
        store.put(key(0, 1), film(1));
        store.put(key(0, 2), film(2));
        store.keep_loads(&[2]);
        assert_eq!((store.samples(&key(0, 1)), store.samples(&key(0, 2))), (0, 2));
    }
}
