//! The program's dark and light looks: colours, text sizes and spacing.

use egui::{
    Color32, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, TextStyle, Theme, Visuals, vec2,
};

use crate::inspect::plot::Ink;

/// Colours that panels use besides egui's own visuals.
#[derive(Clone, Debug, PartialEq)]
pub struct Palette {
    pub dark: bool,
    /// The one colour that draws the eye: the current value, the selection.
    pub accent: Color32,
    /// A second series in a plot.
    pub second: Color32,
    /// A third series.
    pub third: Color32,
    pub good: Color32,
    pub warning: Color32,
    pub error: Color32,
    /// Quiet text: units, captions.
    pub muted: Color32,
}

impl Palette {
    pub fn dark() -> Self {
        Self {
            dark: true,
            accent: ink(Ink::Accent, true),
            second: ink(Ink::Second, true),
            third: ink(Ink::Third, true),
            good: Color32::from_rgb(122, 204, 130),
            warning: Color32::from_rgb(240, 190, 90),
            error: Color32::from_rgb(240, 110, 100),
            muted: ink(Ink::Muted, true),
        }
    }

    pub fn light() -> Self {
        Self {
            dark: false,
            accent: ink(Ink::Accent, false),
            second: ink(Ink::Second, false),
            third: ink(Ink::Third, false),
            good: Color32::from_rgb(40, 130, 60),
            warning: Color32::from_rgb(145, 96, 0),
            error: Color32::from_rgb(190, 40, 40),
            muted: ink(Ink::Muted, false),
        }
    }

    pub fn of(dark: bool) -> Self {
        if dark { Self::dark() } else { Self::light() }
    }

    /// A colour of plots in this look.
    pub fn of_ink(&self, wanted: Ink) -> Color32 {
        ink(wanted, self.dark)
    }
}

/// Plots that are saved have the same colours.
fn ink(ink: Ink, dark: bool) -> Color32 {
    let [r, g, b] = ink.rgb(dark);
    Color32::from_rgb(r, g, b)
}

/// The surfaces of one look, from the deepest to the highest, with the text that stands on them.
struct Surfaces {
    /// Wells: text fields, plots, the bar behind tabs.
    well: Color32,
    panel: Color32,
    /// Menus, tooltips, windows.
    raised: Color32,
    control: Color32,
    control_hovered: Color32,
    control_active: Color32,
    line: Color32,
    line_strong: Color32,
    text: Color32,
    text_strong: Color32,
    selection: Color32,
}

const DARK: Surfaces = Surfaces {
    well: Color32::from_rgb(19, 21, 25),
    panel: Color32::from_rgb(29, 31, 36),
    raised: Color32::from_rgb(37, 40, 46),
    control: Color32::from_rgb(49, 53, 61),
    control_hovered: Color32::from_rgb(60, 65, 75),
    control_active: Color32::from_rgb(70, 76, 88),
    line: Color32::from_rgb(48, 51, 58),
    line_strong: Color32::from_rgb(88, 94, 106),
    text: Color32::from_rgb(203, 207, 215),
    text_strong: Color32::from_rgb(236, 239, 244),
    selection: Color32::from_rgb(34, 82, 130),
};

const LIGHT: Surfaces = Surfaces {
    well: Color32::from_rgb(255, 255, 255),
    panel: Color32::from_rgb(245, 246, 248),
    raised: Color32::from_rgb(252, 252, 253),
    control: Color32::from_rgb(224, 227, 232),
    control_hovered: Color32::from_rgb(212, 216, 223),
    control_active: Color32::from_rgb(198, 204, 213),
    line: Color32::from_rgb(212, 215, 221),
    line_strong: Color32::from_rgb(148, 155, 166),
    text: Color32::from_rgb(48, 52, 60),
    text_strong: Color32::from_rgb(16, 18, 22),
    selection: Color32::from_rgb(176, 212, 246),
};

/// Sets both looks up and switches to one.
pub fn apply(ctx: &egui::Context, dark: bool) {
    ctx.set_visuals_of(Theme::Dark, visuals(&DARK, &Palette::dark()));
    ctx.set_visuals_of(Theme::Light, visuals(&LIGHT, &Palette::light()));
    ctx.all_styles_mut(|style| {
        style.text_styles = text_styles();
        let spacing = &mut style.spacing;
        spacing.item_spacing = vec2(6.0, 5.0);
        spacing.button_padding = vec2(7.0, 2.0);
        spacing.interact_size = vec2(36.0, 20.0);
        spacing.menu_margin = Margin::same(5);
        spacing.window_margin = Margin::same(10);
        spacing.slider_width = 130.0;
        spacing.combo_width = 110.0;
        spacing.combo_height = 420.0;
        spacing.tooltip_width = 340.0;
        spacing.scroll = egui::style::ScrollStyle::thin();
        style.interaction.tooltip_delay = 0.35;
    });
    ctx.set_theme(if dark { Theme::Dark } else { Theme::Light });
}

/// The colour behind the picture: the same in both looks, neutral, so that it does not tint what is judged.
pub const VIEWPORT_BACKGROUND: Color32 = Color32::from_rgb(17, 18, 20);

fn text_styles() -> std::collections::BTreeMap<TextStyle, FontId> {
    [
        (TextStyle::Small, FontId::new(10.5, FontFamily::Proportional)),
        (TextStyle::Body, FontId::new(12.5, FontFamily::Proportional)),
        (TextStyle::Button, FontId::new(12.5, FontFamily::Proportional)),
        (TextStyle::Heading, FontId::new(14.5, FontFamily::Proportional)),
        // Figures are set in it: all digits are equally wide, so that columns line up.
        (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
    ]
    .into()
}

fn visuals(surfaces: &Surfaces, palette: &Palette) -> Visuals {
    let mut v = if palette.dark { Visuals::dark() } else { Visuals::light() };
    let s = surfaces;
    v.panel_fill = s.panel;
    v.window_fill = s.raised;
    v.window_stroke = Stroke::new(1.0, s.line);
    v.extreme_bg_color = s.well;
    v.code_bg_color = s.well;
    v.faint_bg_color =
        if palette.dark { Color32::from_rgb(33, 36, 41) } else { Color32::from_rgb(238, 240, 243) };
    v.hyperlink_color = palette.accent;
    v.warn_fg_color = palette.warning;
    v.error_fg_color = palette.error;
    v.weak_text_color = Some(palette.muted);
    v.selection.bg_fill = s.selection;
    v.selection.stroke = Stroke::new(1.0, s.text_strong);
    v.slider_trailing_fill = true;
    v.striped = false;
    v.window_corner_radius = CornerRadius::same(5);
    v.menu_corner_radius = CornerRadius::same(5);
    let shadow = Shadow {
        offset: [0, 4],
        blur: 14,
        spread: 0,
        color: Color32::from_black_alpha(if palette.dark { 110 } else { 40 }),
    };
    v.window_shadow = shadow;
    v.popup_shadow = shadow;

    let w = &mut v.widgets;
    w.noninteractive.weak_bg_fill = s.panel;
    w.noninteractive.bg_fill = s.panel;
    w.noninteractive.bg_stroke = Stroke::new(1.0, s.line);
    w.noninteractive.fg_stroke = Stroke::new(1.0, s.text);
    w.inactive.weak_bg_fill = s.control;
    w.inactive.bg_fill = s.control;
    w.inactive.fg_stroke = Stroke::new(1.0, s.text);
    w.hovered.weak_bg_fill = s.control_hovered;
    w.hovered.bg_fill = s.control_hovered;
    w.hovered.bg_stroke = Stroke::new(1.0, s.line_strong);
    w.hovered.fg_stroke = Stroke::new(1.2, s.text_strong);
    w.active.weak_bg_fill = s.control_active;
    w.active.bg_fill = s.control_active;
    w.active.bg_stroke = Stroke::new(1.0, palette.accent);
    w.active.fg_stroke = Stroke::new(1.4, s.text_strong);
    w.open.weak_bg_fill = s.control_hovered;
    w.open.bg_fill = s.panel;
    w.open.bg_stroke = Stroke::new(1.0, s.line);
    w.open.fg_stroke = Stroke::new(1.0, s.text_strong);
    for widget in [&mut w.noninteractive, &mut w.inactive, &mut w.hovered, &mut w.active, &mut w.open] {
        widget.corner_radius = CornerRadius::same(3);
        widget.expansion = 0.0;
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast ratio of two opaque colours (WCAG 2.1).
    fn contrast(a: Color32, b: Color32) -> f32 {
        let luminance = |c: Color32| {
            let [r, g, b, _] = egui::Rgba::from(c).to_array();
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
        (a / b).max(b / a)
    }

    #[test]
    fn text_can_be_read_in_both_looks() {
        for (surfaces, palette) in [(&DARK, Palette::dark()), (&LIGHT, Palette::light())] {
            for background in [surfaces.well, surfaces.panel, surfaces.raised] {
                for color in
                    [surfaces.text, surfaces.text_strong, palette.muted, palette.error, palette.warning]
                {
                    let ratio = contrast(color, background);
                    assert!(ratio >= 4.4, "{color:?} on {background:?}: {ratio}");
                }
            }
            assert!(contrast(surfaces.text, surfaces.control) >= 4.4);
            assert!(contrast(surfaces.text_strong, surfaces.selection) >= 4.4);
        }
    }
}
