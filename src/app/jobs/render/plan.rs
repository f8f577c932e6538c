//! What the render thread does next: which picture, how coarse. Pure decisions, no rendering.

/// A first look at a new camera should take no longer than this: 20 pictures a second and some room.
pub const FIRST_LOOK_MS: f64 = 42.0;

/// The coarsest pixels, in pixels of the full picture.
pub const COARSEST: u32 = 8;

/// How far one picture of the viewport is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotProgress {
    /// Samples a pixel at full size.
    pub samples: u32,
    /// Samples a pixel at full size after which nothing is left to do; `None` for no end.
    pub goal: Option<u32>,
    /// The finest coarse picture of this key that was made.
    pub coarse: Option<u32>,
    /// How long a sample at full size will take, if a guess can be made.
    pub full_ms: Option<f64>,
}

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// One sample of a film that is smaller by `scale` on each side.
    Coarse { slot: usize, scale: u32 },
    /// One sample at full size.
    Full { slot: usize },
    /// Nothing, until the request changes.
    Rest,
}

/// How the request wants to be served.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Pace {
    /// A coarse first look, then refined.
    #[default]
    Refine,
    /// The camera or the scene moves: a first look is all that there is time for.
    Moving,
    /// Full size at once; for tests, which want the same steps on every machine.
    Direct,
    /// One sample is all.
    Paused,
}

/// Decides the next step. A picture without any look goes first; then the one with the fewest samples.
pub fn next_step(slots: &[SlotProgress], pace: Pace) -> Step {
    if pace != Pace::Direct
        && let Some((slot, scale)) = first_look(slots)
    {
        return if scale == 1 { Step::Full { slot } } else { Step::Coarse { slot, scale } };
    }
    if pace == Pace::Moving {
        return Step::Rest;
    }
    // A pause ends the refining; what nobody has seen yet is shown all the same.
    let pause = (pace == Pace::Paused).then_some(1);
    let goal = |s: &SlotProgress| pause.or(s.goal);
    let open = slots.iter().enumerate().filter(|(_, s)| goal(s).is_none_or(|goal| s.samples < goal));
    let Some((slot, progress)) = open.min_by_key(|(_, s)| s.samples) else {
        return Step::Rest;
    };
    match progress.coarse {
        Some(scale) if progress.samples == 0 && scale > 2 && pace != Pace::Direct => {
            Step::Coarse { slot, scale: scale / 2 }
        }
        _ => Step::Full { slot },
    }
}

/// The first picture that shows nothing yet, and how coarse its first look is.
fn first_look(slots: &[SlotProgress]) -> Option<(usize, u32)> {
    let (slot, progress) =
        slots.iter().enumerate().find(|(_, s)| s.samples == 0 && s.coarse.is_none() && s.goal != Some(0))?;
    let pictures = slots.len() as f64;
    let scale = progress.full_ms.map_or(COARSEST, |ms| coarseness(ms * pictures));
    Some((slot, scale))
}

/// The finest coarseness whose sample fits the first look.
fn coarseness(full_ms: f64) -> u32 {
    let mut scale = 1;
    while scale < COARSEST && full_ms / f64::from(scale * scale) > FIRST_LOOK_MS {
        scale *= 2;
    }
    scale
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slot(samples: u32, coarse: Option<u32>, full_ms: Option<f64>) -> SlotProgress {
        SlotProgress { samples, goal: None, coarse, full_ms }
    }

    #[test]
    fn an_unknown_picture_begins_as_coarse_as_can_be_and_gets_finer() {
        let mut s = slot(0, None, None);
        let mut scales = Vec::new();
        while let Step::Coarse { scale, .. } = next_step(&[s], Pace::Refine) {
            scales.push(scale);
            s.coarse = Some(scale);
        }
        assert_eq!(scales, [8, 4, 2]);
        assert_eq!(next_step(&[s], Pace::Refine), Step::Full { slot: 0 });
    }

    #[test]
    fn a_fast_picture_is_full_at_once_and_a_slow_one_fits_the_first_look() {
        assert_eq!(next_step(&[slot(0, None, Some(20.0))], Pace::Moving), Step::Full { slot: 0 });
        for full_ms in [50.0, 150.0, 600.0, 2000.0] {
            let Step::Coarse { scale, .. } = next_step(&[slot(0, None, Some(full_ms))], Pace::Moving) else {
                panic!("{full_ms} ms do not fit");
            };
            assert!(full_ms / f64::from(scale * scale) <= FIRST_LOOK_MS);
            assert!(full_ms / f64::from(scale * scale / 4) > FIRST_LOOK_MS, "coarser than needed");
        }
    }

    #[test]
    fn while_the_camera_moves_nothing_is_refined() {
        assert_eq!(next_step(&[slot(0, Some(4), Some(500.0))], Pace::Moving), Step::Rest);
        assert_eq!(
            next_step(&[slot(0, Some(4), Some(500.0))], Pace::Refine),
            Step::Coarse { slot: 0, scale: 2 }
        );
    }

    #[test]
    fn two_pictures_are_looked_at_in_turn() {
        let (a, b) = (slot(0, Some(8), Some(900.0)), slot(0, None, Some(900.0)));
        assert_eq!(next_step(&[a, b], Pace::Refine), Step::Coarse { slot: 1, scale: 8 });
        assert_eq!(
            next_step(&[slot(3, None, None), slot(2, None, None)], Pace::Refine),
            Step::Full { slot: 1 }
        );
    }

    #[test]
    fn a_reached_goal_a_pause_and_tests_are_respected() {
        let done = SlotProgress { goal: Some(4), ..slot(4, None, None) };
        assert_eq!(next_step(&[done], Pace::Refine), Step::Rest);
        assert_eq!(next_step(&[done, slot(9, None, None)], Pace::Refine), Step::Full { slot: 1 });
        assert_eq!(next_step(&[slot(1, None, None)], Pace::Paused), Step::Rest);
        assert_eq!(next_step(&[slot(0, Some(2), None)], Pace::Paused), Step::Full { slot: 0 });
        assert_eq!(next_step(&[slot(0, None, None)], Pace::Direct), Step::Full { slot: 0 });
        assert_eq!(next_step(&[], Pace::Refine), Step::Rest);
    }
}
