//! Which named orders of each layer are worth trying on the model.

use beadwork_base::{Control, Interrupted};

use super::setup::Options;
use crate::allotment::{Choice, allot};
use crate::fill::Fill;
use crate::model::{ModelDraft, NameOf, Screen, ThermalModel};
use crate::plan::{PlanError, conventional_drafts, drafts_seconds, layers};

/// Prices of time that options are picked at, relative to the one at which the estimated costs meet
/// the limit: the model's costs meet it at another.
const PRICES: [f64; 3] = [1.0, 0.5, 2.0];

/// What is worth trying.
pub(super) struct Shortlist<M: ThermalModel> {
    /// Orders of each layer; none for a layer without voxels.
    pub(super) drafts: Vec<Vec<ModelDraft<M>>>,
    /// Price of time under the limit by the estimates, in costs per second; `None` if even the
    /// fastest orders seem to exceed the limit.
    pub(super) price: Option<f64>,
}

impl<M: ThermalModel> Shortlist<M> {
    /// What orders of a layer are compared by.
    pub(super) fn score(&self, cost: f64, seconds: f64) -> f64 {
        self.price.map_or(seconds, |price| cost + price * seconds)
    }
}

/// For each layer with voxels, the conventional order and up to `count` more, which are promising
/// by the model's screen: those that are cheap at the price of time under the limit.
///
/// All layers are screened before any order is tried, since the price depends on all of them.
/// Between the layers, the state follows the orders that are cheapest within each layer's share of
/// the limit.
///
/// An interrupted call returns why.
pub(super) fn shortlist<M: ThermalModel>(
    model: &M,
    orders: &[NameOf<M>],
    (count, limit): (usize, f64),
    report: impl Fn(usize),
    control: &Control<'_>,
) -> Result<Result<Shortlist<M>, Interrupted>, PlanError> {
    let ratio = limit / drafts_seconds(model, &conventional_drafts(model.fill()));
    let mut state = model.clone();
    let mut estimated: Vec<Option<Options<M>>> = Vec::with_capacity(model.fill().layer_count());
    for (layer, is_printed) in layers(model.fill()) {
        report(estimated.len());
        if let Some(reason) = control.interrupted() {
            return Ok(Err(reason));
        }
        if !is_printed {
            estimated.push(None);
            continue;
        }
        let mut options = Options::new(&state, layer, orders, control);
        let screen = state.screen(layer).ok_or(PlanError::NoScreen)?;
        let candidates = &options.candidates;
        let costs = control.threads.map(candidates, |candidate| screen.cost(&candidate.path));
        options.choices.iter_mut().zip(costs).for_each(|(choice, cost)| choice.cost = cost);
        let next = cheapest_within(&options.choices, ratio * options.choices[0].seconds);
        state.deposit(layer, &options.candidates[next].path, &control.uninterrupted())?;
        estimated.push(Some(options));
    }
    let tables: Vec<Vec<Choice>> =
        estimated.iter().flatten().map(|options| options.choices.clone()).collect();
    let price = allot(&tables, limit).map(|allotment| allotment.price);
    let picked = |options: &Option<Options<M>>| match options {
        None => Vec::new(),
        Some(Options { candidates, choices }) => {
            picks(choices, count, price).into_iter().map(|at| candidates[at].clone()).collect()
        }
    };
    Ok(Ok(Shortlist { drafts: estimated.iter().map(picked).collect(), price }))
}

/// The cheapest option that takes at most `limit` seconds; the first one without any.
fn cheapest_within(choices: &[Choice], limit: f64) -> usize {
    let within = (0..choices.len()).filter(|&index| choices[index].seconds <= limit);
    within.min_by(|&a, &b| choices[a].cost.total_cmp(&choices[b].cost)).unwrap_or(0)
}

/// Indices of the first option and up to `count` others: the cheapest at each of [`PRICES`] in
/// turn, or the fastest without a price.
fn picks(choices: &[Choice], count: usize, price: Option<f64>) -> Vec<usize> {
    let rankings = PRICES.map(|factor| {
        let score = |index: usize| {
            let Choice { cost, seconds } = choices[index];
            price.map_or(seconds, |price| cost + factor * price * seconds)
        };
        let mut ranking: Vec<usize> = (1..choices.len()).collect();
        ranking.sort_by(|&a, &b| score(a).total_cmp(&score(b)));
        ranking
    });
    let mut picked = vec![0];
    for rank in 0..choices.len() - 1 {
        for ranking in &rankings {
            if picked.len() <= count && !picked.contains(&ranking[rank]) {
                picked.push(ranking[rank]);
            }
        }
    }
    picked.sort_unstable();
    picked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cheap_and_fast_options_are_picked_by_price() {
        let choices = [(5.0, 1.0), (9.0, 0.5), (1.0, 6.0), (3.0, 3.0), (8.0, 9.0)];
        let choices = choices.map(|(cost, seconds)| Choice { cost, seconds });
        let pick = |count, price| picks(&choices, count, price);
        assert_eq!(pick(1, Some(0.0)), [0, 2]);
        assert_eq!(pick(2, Some(0.0)), [0, 2, 3]);
        // At the price of 1, 0.5 and 2, options cost 9.5, 7, 6, 17; 9.25, 4, 4.5, 12.5; 10, 13,
        // 9, 26.
        assert_eq!(pick(1, Some(1.0)), [0, 3]);
        assert_eq!(pick(2, Some(1.0)), [0, 2, 3]);
        assert_eq!(pick(3, Some(1.0)), [0, 1, 2, 3]);
        // Without a price, time counts.
        assert_eq!(pick(1, None), [0, 1]);
        assert_eq!(pick(9, None), [0, 1, 2, 3, 4]);
        assert_eq!(picks(&choices[..1], 4, None), [0]);
        assert_eq!(cheapest_within(&choices, 4.0), 3);
        assert_eq!(cheapest_within(&choices, 0.1), 0);
    }
}
