//! Two pictures that take turns in the same place.

use std::time::{Duration, Instant};

use egui::Ui;

use crate::app::state::State;
use crate::app::view::CompareStyle;

/// Since when they take turns.
#[derive(Default)]
pub struct Blink {
    since: Option<Instant>,
}

impl Blink {
    /// The picture that is in front now: of those that blink, the one whose turn it is; of a difference, B; else the first.
    /// Asks for a frame when it is the other one's turn.
    pub fn update(&mut self, ui: &Ui, state: &State) -> usize {
        let compare = state.compare.filter(|compare| compare.style == CompareStyle::Blink);
        let Some(compare) = compare else {
            self.since = None;
            return usize::from(state.compare.is_some_and(|c| c.style == CompareStyle::Difference));
        };
        if state.hold {
            return 0;
        }
        let now = Instant::now();
        let since = *self.since.get_or_insert(now);
        let interval = Duration::from_millis(u64::from(compare.blink_ms.max(1)));
        let (slot, left) = turn(now.saturating_duration_since(since), interval);
        ui.ctx().request_repaint_after(left);
        slot
    }
}

/// Whose turn it is, and how long it is left.
fn turn(elapsed: Duration, interval: Duration) -> (usize, Duration) {
    let turns = elapsed.as_nanos() / interval.as_nanos();
    let into = Duration::from_nanos((elapsed.as_nanos() % interval.as_nanos()) as u64);
    ((turns % 2) as usize, interval - into)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_take_turns_of_equal_length() {
        let ms = Duration::from_millis;
        for (at, slot, left) in [(0, 0, 500), (499, 0, 1), (500, 1, 500), (700, 1, 300), (1000, 0, 500)] {
            assert_eq!(turn(ms(at), ms(500)), (slot, ms(left)), "{at}");
        }
    }
}
