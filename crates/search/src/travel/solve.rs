//! Nearest neighbours, local search and kicks, one after the other.

use beadwork_base::Control;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::bound::bound;
use super::entries::improve_entries;
use super::exact;
use super::item::{self, Item, TravelError};
use super::kicks::kick;
use super::local_search::LocalSearch;
use super::nearest::Nearest;
use super::neighbours::Neighbours;
use super::problem::Problem;
use super::route::{self, Route, Visit, travel_mm};
use super::settings::{Order, Retraction, Settings};
use super::tour::Tour;
use crate::Stop;

/// Orders beads and loops for little travel and, if they cost anything, few retractions.
///
/// Each item is printed once, in an order that [`Settings::order`] allows; the result may end
/// anywhere.
///
/// Up to 8 items with few entries get the cheapest route, with [`Stop::Optimal`]: only rounding
/// errors could hide a cheaper one.
///
/// An interrupted call returns the best route so far, with the reason in [`Route::stop`].
/// Progress counts kicks.
/// It takes O(n log n) expected steps for n items before the bound, with a factor that grows with
/// [`Settings::kicks_per_item`]; loops take time in proportion to their entries.
/// Works on the calling thread only.
pub fn solve(
    items: &[Item<'_>],
    settings: &Settings,
    control: &Control<'_>,
) -> Result<Route, TravelError> {
    item::check(items, settings.from)?;
    let &Settings { order, from, retraction, .. } = settings;
    if let Some(Retraction { beyond_mm, cost_mm }) = retraction
        && ![beyond_mm, cost_mm].iter().all(|value| value.is_finite() && *value >= 0.0)
    {
        return Err(TravelError::Retraction);
    }
    let problem = Problem::new(items, order, from, retraction);
    let exact = exact::cheapest(&problem);
    let is_exact = exact.is_some();
    let (visits, stop) = match exact {
        Some(visits) => (visits, Stop::Optimal),
        None => improve(&problem, settings, control),
    };
    let travel_mm = travel_mm(items, &visits, settings.from);
    let bound_mm = match settings.bound_iterations {
        0 => None,
        _ if is_exact && retraction.is_none() => Some(shortened(travel_mm)),
        iterations => shortest_mm(items, order, from, travel_mm, iterations, control),
    };
    let stop = if travel_mm <= 0.0 && !stop.is_interrupted() { Stop::Optimal } else { stop };
    Ok(Route { visits, travel_mm, bound_mm, stop })
}

/// Proven lower bound in mm on the travel of every allowed route from anywhere, with rounding taken
/// into account; `None` if there are more items than [`MAX_BOUNDED`](super::MAX_BOUNDED).
///
/// `travel_mm` is the travel of a known route, as short as possible; `iterations` as
/// [`Settings::bound_iterations`], at least 1.
/// It takes O(n²) steps for n items and each iteration.
pub fn lower_bound_mm(
    items: &[Item<'_>],
    order: Order,
    travel_mm: f64,
    iterations: u32,
    control: &Control<'_>,
) -> Result<Option<f64>, TravelError> {
    item::check(items, None)?;
    Ok(shortest_mm(items, order, None, travel_mm, iterations, control))
}

/// Lower bound on the travel of every allowed route of valid items, whatever retractions cost.
fn shortest_mm(
    items: &[Item<'_>],
    order: Order,
    from: Option<[f64; 2]>,
    travel_mm: f64,
    iterations: u32,
    control: &Control<'_>,
) -> Option<f64> {
    let problem = Problem::new(items, order, from, None);
    match exact::cheapest(&problem) {
        Some(visits) => Some(shortened(route::travel_mm(items, &visits, from))),
        None => bound(&problem, travel_mm, iterations, control),
    }
}

/// A bound from the length of a shortest route: the dynamic programme compares sums of rounded
/// distances.
fn shortened(travel_mm: f64) -> f64 {
    travel_mm * (1.0 - 1e-12)
}

/// Finds a route by local search.
pub(super) fn improve(
    problem: &Problem<'_>,
    settings: &Settings,
    control: &Control<'_>,
) -> (Vec<Visit>, Stop) {
    let Nearest { sequence, entry, .. } = Nearest::new(problem);
    let tour = Tour::new(problem, sequence, entry);
    if problem.items.is_empty() {
        return (Vec::new(), Stop::Optimal);
    }
    let neighbours = Neighbours::new(problem);
    let mut search = LocalSearch::new(tour, &neighbours);
    improve_entries(&mut search.tour);
    search.push_all();
    search.run(|| control.interrupted().is_some());
    search.clear();
    improve_entries(&mut search.tour);
    search.tour.commit();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    let kicks = u64::from(settings.kicks_per_item) * problem.items.len() as u64;
    let stop = kick(&mut search, kicks, &mut rng, control);
    improve_entries(&mut search.tour);
    (search.tour.visits(), stop)
}

/// The route that goes from each item to the nearest one that may follow, for comparison.
pub fn nearest_neighbour(
    items: &[Item<'_>],
    order: Order,
    from: Option<[f64; 2]>,
) -> Result<Route, TravelError> {
    item::check(items, from)?;
    let problem = Problem::new(items, order, from, None);
    let Nearest { sequence, entry, .. } = Nearest::new(&problem);
    let visits = Tour::new(&problem, sequence, entry).visits();
    let travel_mm = travel_mm(items, &visits, from);
    Ok(Route { visits, travel_mm, bound_mm: None, stop: Stop::Done })
}
