//! The nearest hit while a ray walks.

use crate::geometry::{Hit, Ray, ShapeHit};

use super::block::Passed;

/// The nearest hit so far. Of a triangle that is hit for sure only bounds of the distance are kept, as long as they
/// tell it from every other: most rays compute one hit in double precision, when the walk is over, and the walk need not
/// wait for it.
#[derive(Clone, Copy, Debug)]
pub struct Best<'a> {
    /// Exact, if nothing is pending; else with the upper bound as its distance.
    hit: Hit,
    pending: Option<Passed<'a>>,
}

impl<'a> Best<'a> {
    #[inline(always)]
    pub fn new(hit: Hit) -> Self {
        Self { hit, pending: None }
    }

    /// A hit that may be of a triangle of which only bounds are known.
    #[inline(always)]
    pub fn pending(hit: Hit, pending: Option<Passed<'a>>) -> Self {
        let t = pending.as_ref().map_or(hit.t, |passed| passed.upper);
        Self { hit: Hit { t, ..hit }, pending }
    }

    /// Nothing behind this can be the nearest hit.
    #[inline(always)]
    pub fn t_max(&self) -> f32 {
        self.hit.t
    }

    /// The nearest hit, or the triangle that is it, as far as that is known.
    #[inline(always)]
    pub fn known(self) -> Result<Hit, Passed<'a>> {
        match self.pending {
            Some(passed) => Err(passed),
            None => Ok(self.hit),
        }
    }

    /// The nearest hit itself.
    #[inline(always)]
    pub fn exact(&mut self, ray: &Ray) -> &mut Hit {
        if let Some(passed) = self.pending.take() {
            self.hit = passed.hit(ray);
        }
        &mut self.hit
    }

    /// Takes a triangle that lies behind `t_min` for sure. Answers whether bounds were enough to decide; if not,
    /// [`Best::keep`] what the exact test says.
    #[inline(always)]
    pub fn pass(&mut self, passed: Passed<'a>) -> bool {
        let before = match &self.pending {
            Some(pending) => pending.lower,
            None => self.hit.t,
        };
        let nearer = passed.upper < before;
        if nearer {
            self.hit.t = passed.upper;
            self.pending = Some(passed);
        }
        nearer || passed.lower > self.hit.t
    }

    /// Replaces the hit by what `shape` answered if that is nearer.
    #[inline(always)]
    pub fn keep(&mut self, ray: &Ray, shape: u32, answer: Option<ShapeHit>) {
        if let Some(ShapeHit { t, u, v }) = answer {
            let hit = self.exact(ray);
            if hit.is_beaten_by(t, shape) {
                *hit = Hit { t, shape, u, v };
            }
        }
    }
}
