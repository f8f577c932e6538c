//! Which shapes block light under each shadow rule: one bit a shape, so that a filter costs one load.

use crate::scene::{Scene, ShadowRule};

/// A bit for each shape, plane and ground, and for each rule.
#[derive(Clone, Debug)]
pub struct Blockers {
    bits: [Vec<u64>; ShadowRule::ALL.len()],
}

impl Blockers {
    pub fn new(scene: &Scene) -> Self {
        let bits = ShadowRule::ALL.map(|rule| {
            let blocks: Vec<bool> = scene.materials.iter().map(|m| !m.lets_light_pass(rule)).collect();
            let materials = scene
                .shape_materials
                .iter()
                .copied()
                .chain(scene.unbounded().map(|(_, _, material)| material));
            let mut words = vec![0; (scene.shape_count() + scene.unbounded().count()).div_ceil(64)];
            for (shape, material) in materials.enumerate() {
                words[shape / 64] |= u64::from(blocks[material as usize]) << (shape % 64);
            }
            words
        });
        Self { bits }
    }

    /// Whether a shape stops light under `rule`.
    #[inline]
    pub fn under(&self, rule: ShadowRule) -> impl Fn(u32) -> bool + '_ {
        let words = &self.bits[rule as usize][..];
        move |shape| words[shape as usize / 64] >> (shape % 64) & 1 != 0
    }
}
