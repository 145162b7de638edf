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
use super::settings::{Order, Settings};
use super::tour::Tour;
use crate::Stop;

/// Orders beads and loops for little travel.
///
/// Each item is printed once, in an order that [`Settings::order`] allows; the result may end
/// anywhere.
///
/// Up to 8 items with few entries get the shortest route, with [`Stop::Optimal`]: equally short
/// routes aside, only rounding errors could hide a shorter one.
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
    let problem = Problem::new(items, settings.order, settings.from);
    let exact = exact::shortest(&problem);
    let is_exact = exact.is_some();
    let (visits, stop) = match exact {
        Some(visits) => (visits, Stop::Optimal),
        None => improve(&problem, settings, control),
    };
    let travel_mm = travel_mm(items, &visits, settings.from);
    let bound_mm = match settings.bound_iterations {
        0 => None,
        _ if is_exact => Some(shortened(travel_mm)),
        iterations => bound(&problem, travel_mm, iterations, control),
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
    let problem = Problem::new(items, order, None);
    Ok(match exact::shortest(&problem) {
        Some(visits) => Some(shortened(route::travel_mm(items, &visits, None))),
        None => bound(&problem, travel_mm, iterations, control),
    })
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
    let problem = Problem::new(items, order, from);
    let Nearest { sequence, entry, .. } = Nearest::new(&problem);
    let visits = Tour::new(&problem, sequence, entry).visits();
    let travel_mm = travel_mm(items, &visits, from);
    Ok(Route { visits, travel_mm, bound_mm: None, stop: Stop::Done })
}
