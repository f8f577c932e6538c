//! What figures of a tree say in advance of its rays, held against what the rays then paid.

use serde::{Deserialize, Serialize};

use super::stats::TreeStats;
use crate::render::bench::RaySetKind;
use crate::render::ray_costs::RayCosts;

/// The weight of EPO beside the SAH cost that fitted measured times best in Aila, Karras, Laine, "On Quality Metrics of
/// Bounding Volume Hierarchies", 2013, section 5.
pub const EPO_WEIGHT: f64 = 0.71;

/// A figure that is known before any ray is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Prediction {
    SahCost,
    Epo,
    SahEpo,
}

impl Prediction {
    pub const ALL: [Self; 3] = [Self::SahCost, Self::Epo, Self::SahEpo];

    /// The name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::SahCost => "SAH cost",
            Self::Epo => "EPO",
            Self::SahEpo => "0.29 SAH + 0.71 EPO",
        }
    }
}

/// One tree: what was predicted, and what rays paid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Forecast {
    pub sah_cost: Option<f64>,
    pub epo: Option<f64>,
    pub ray_costs: RayCosts,
}

impl Forecast {
    pub fn of(stats: &TreeStats) -> Self {
        Self {
            sah_cost: stats.figures.sah_cost.map(|cost| cost.total()),
            epo: stats.epo,
            ray_costs: stats.ray_costs,
        }
    }

    pub fn predicted(&self, prediction: Prediction) -> Option<f64> {
        match prediction {
            Prediction::SahCost => self.sah_cost,
            Prediction::Epo => self.epo,
            Prediction::SahEpo => {
                let (sah, epo) = self.sah_cost.zip(self.epo)?;
                Some((1.0 - EPO_WEIGHT) * sah + EPO_WEIGHT * epo)
            }
        }
    }
}

/// How well a prediction orders these trees: of all pairs whose rays of this kind paid differently, the share that the
/// prediction puts in the right order; a pair that it holds for equal counts half. `None` without such a pair.
pub fn agreement(trees: &[Forecast], prediction: Prediction, kind: RaySetKind) -> Option<f64> {
    let known = |tree: &Forecast| tree.predicted(prediction).zip(tree.ray_costs.of(kind));
    let known: Vec<(f64, f64)> = trees.iter().filter_map(known).collect();
    let (mut right, mut pairs) = (0.0, 0_usize);
    for (i, (predicted, paid)) in known.iter().enumerate() {
        for (other_predicted, other_paid) in &known[i + 1..] {
            if paid == other_paid {
                continue;
            }
            pairs += 1;
            right += match predicted.total_cmp(other_predicted) {
                std::cmp::Ordering::Equal => 0.5,
                order if order == paid.total_cmp(other_paid) => 1.0,
                _ => 0.0,
            };
        }
    }
    (pairs > 0).then(|| right / pairs as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(sah_cost: f64, epo: f64, primary: f64) -> Forecast {
        let ray_costs = RayCosts { primary: Some(primary), ..RayCosts::default() };
        Forecast { sah_cost: Some(sah_cost), epo: Some(epo), ray_costs }
    }

    #[test]
    fn the_combination_is_that_of_the_paper() {
        let predicted = tree(10.0, 2.0, 1.0).predicted(Prediction::SahEpo).expect("both are known");
        assert!((predicted - (2.9 + 1.42)).abs() < 1e-12);
        let unknown = Forecast { epo: None, ..tree(10.0, 2.0, 1.0) };
        assert_eq!(unknown.predicted(Prediction::SahEpo), None);
    }

    #[test]
    fn agreement_counts_pairs_in_the_right_order() {
        let primary = |trees: &[Forecast], prediction| agreement(trees, prediction, RaySetKind::Primary);
        // By SAH: pairs (1, 2) right, (1, 3) right, (2, 3) wrong. By EPO: all wrong but a tie.
        let trees = [tree(1.0, 5.0, 10.0), tree(3.0, 5.0, 20.0), tree(2.0, 1.0, 30.0)];
        assert_eq!(primary(&trees, Prediction::SahCost), Some(2.0 / 3.0));
        assert_eq!(primary(&trees, Prediction::Epo), Some(0.5 / 3.0));
        assert_eq!(agreement(&trees, Prediction::SahCost, RaySetKind::Shadow), None);
        assert_eq!(primary(&trees[..1], Prediction::SahCost), None);
        let same = [tree(1.0, 1.0, 10.0), tree(2.0, 1.0, 10.0)];
        assert_eq!(primary(&same, Prediction::SahCost), None, "equal costs have no order");
    }
}
