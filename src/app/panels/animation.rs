//! The form of an animation to export: a turn of the camera, or a range of time.

use egui::{DragValue, Ui};

use crate::app::view::AppView;
use crate::export::animation::Frames;

use super::glossary::Term;
use super::{numbers, widgets};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Turntable,
    Time,
}

impl Motion {
    const ALL: [Self; 2] = [Self::Turntable, Self::Time];
}

/// What was typed.
pub struct AnimationForm {
    motion: Motion,
    degrees: f32,
    from: f32,
    to: f32,
    count: u32,
    fps: u32,
}

impl Default for AnimationForm {
    fn default() -> Self {
        Self { motion: Motion::Turntable, degrees: 360.0, from: 0.0, to: 4.0, count: 100, fps: 25 }
    }
}

impl AnimationForm {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView) {
        let moves = view.scene.is_some_and(|scene| scene.is_animated());
        let describe = |motion: Motion| match motion {
            Motion::Turntable => ("Turntable", "the camera turns around its target, from where it stands"),
            Motion::Time => ("Time", "the scene moves, and gets a tree for each moment"),
        };
        if let Some(motion) =
            widgets::segmented(ui, Term::AnimationMotion, Some(self.motion), &Motion::ALL, &describe)
        {
            self.motion = motion;
        }
        match self.motion {
            Motion::Turntable => {
                let field =
                    DragValue::new(&mut self.degrees).range(-36_000.0..=36_000.0).speed(1.0).suffix("°");
                widgets::number(ui, Term::AnimationTurn, field);
            }
            Motion::Time => {
                let time = |value| DragValue::new(value).range(-1e6..=1e6).speed(0.05).suffix(" s");
                widgets::number(ui, Term::AnimationFrom, time(&mut self.from));
                widgets::number(ui, Term::AnimationTo, time(&mut self.to));
            }
        }
        let field = DragValue::new(&mut self.count).range(1..=Frames::MOST).speed(0.5);
        widgets::number(ui, Term::AnimationFrames, field);
        let field = DragValue::new(&mut self.fps).range(1..=Frames::MOST_FPS).speed(0.2);
        widgets::number(ui, Term::AnimationFps, field);
        let frames = self.frames();
        let mut text = format!(
            "{} of film, in the picture's size and samples.",
            numbers::elapsed(std::time::Duration::from_secs_f32(frames.seconds()))
        );
        if self.motion == Motion::Time && !moves {
            text += " Nothing moves in this scene.";
        }
        widgets::caption(ui, view.palette, text);
    }

    pub fn frames(&self) -> Frames {
        let Self { motion, degrees, from, to, count, fps } = *self;
        match motion {
            Motion::Turntable => Frames { count, fps, time: None, turn_degrees: degrees },
            Motion::Time => Frames { count, fps, time: Some([from, to]), turn_degrees: 0.0 },
        }
    }

    /// For the name of a file.
    pub fn word(&self) -> &'static str {
        match self.motion {
            Motion::Turntable => "turn",
            Motion::Time => "time",
        }
    }
}
