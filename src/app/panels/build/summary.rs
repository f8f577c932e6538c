//! Build settings in a few words.

use crate::accel::{Block, BuildConfig, Builder, Improver, Layout, Morton, StopRule, Update, Width};

/// Settings in a few words, as in `binned 16 · leaf 2 · width 4 split`.
pub fn summary(config: &BuildConfig) -> String {
    let mut text = config.builder.name().to_owned();
    if config.builder.uses_bins() {
        text += &format!(" {}", config.bins);
    }
    if config.builder == Builder::Ploc {
        text += &format!(" {}", config.radius);
    }
    if config.builder.uses_morton() && config.morton != Morton::default() {
        text += &format!(" · {} bits", config.morton.name());
    }
    if config.builder == Builder::Spatial {
        let default = BuildConfig::default();
        if config.split_alpha != default.split_alpha {
            text += &format!(" · alpha {:.1e}", config.split_alpha);
        }
        if config.split_budget != default.split_budget {
            text += &format!(" · budget {}", config.split_budget);
        }
    }
    if config.pre_split > 0.0 {
        text += &format!(" · pre-split {}", config.pre_split);
    }
    text += &format!(" · leaf {}", config.leaf_limit());
    if config.block != Block::default() {
        text += &format!(" · blocks of {}", config.block.name());
    }
    text += &match config.width {
        Width::W2 => " · binary".to_owned(),
        width => format!(" · {}-wide {}", width.name(), config.widen.name()),
    };
    if config.layout == Layout::Compressed {
        text += " · compressed";
    }
    if config.improver != Improver::None {
        text += &format!(" · {} {}", config.improver.name(), config.rounds);
    }
    if config.improver == Improver::Reinsertion {
        text += &format!(" x {}", config.share);
    }
    if config.stop != StopRule::Limit && !config.is_optimal() && config.builder.weighs_cost() {
        text += &format!(" · stop {}", config.stop.name());
    }
    if config.update == Update::Refit {
        text += " · refit";
    }
    let costs = (config.traversal_cost, config.intersection_cost);
    if costs != (1.0, 1.0) {
        text += &format!(" · costs {} {}", costs.0, costs.1);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Widen;

    #[test]
    fn a_summary_says_what_differs_and_nothing_else() {
        let config = BuildConfig::default();
        assert_eq!(summary(&config), "binned 16 · leaf 2 · 8-wide split");
        let config =
            BuildConfig { builder: Builder::Sweep, width: Width::W4, widen: Widen::Collapse, ..config };
        assert_eq!(summary(&config), "sweep · leaf 2 · 4-wide collapse");
        let config = BuildConfig {
            improver: Improver::Reinsertion,
            width: Width::W4,
            widen: Widen::Optimal,
            stop: StopRule::Cost,
            ..BuildConfig::default()
        };
        assert_eq!(summary(&config), "binned 16 · leaf 2 · 4-wide optimal · reinsertion 10 x 0.1");
        let config = BuildConfig {
            width: Width::W2,
            stop: StopRule::Cost,
            traversal_cost: 1.5,
            ..BuildConfig::default()
        };
        assert_eq!(summary(&config), "binned 16 · leaf 2 · binary · stop cost · costs 1.5 1");
    }
}
