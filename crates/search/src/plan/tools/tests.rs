//! Plans of small parts, judged from their paths alone.

use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_grid::{Layout, LayoutSpec, Region, RegionShape, Zones, verify};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;

type Sliced = Vec<(Region, Zones)>;

/// A part whose layers differ a little, with up to 4 tools.
fn draw(rng: &mut Xoshiro256PlusPlus, side: u32) -> Sliced {
    let (width, height) = (rng.random_range(1..=side), rng.random_range(1..=side));
    let tools = rng.random_range(1..=4_u8);
    let mut ids: Vec<u8> = (0..width * height).map(|_| rng.random_range(0..tools)).collect();
    let mut inside = vec![true; ids.len()];
    let count = rng.random_range(1..=4);
    let mut layers = Vec::new();
    while layers.len() < count {
        if !rng.random_bool(0.4) {
            for (id, inside) in ids.iter_mut().zip(&mut inside) {
                *id = if rng.random_bool(0.1) { rng.random_range(0..tools) } else { *id };
                *inside ^= rng.random_bool(0.1);
            }
        }
        if let Ok(region) = Region::from_mask(width, height, inside.clone()) {
            let zones = Zones::new(&region, ids.clone()).unwrap();
            layers.push((region, zones));
        }
    }
    layers
}

fn refs(layers: &Sliced) -> Vec<LayerRef<'_>> {
    layers.iter().map(|(region, zones)| LayerRef { region, zones }).collect()
}

fn draw_costs(rng: &mut Xoshiro256PlusPlus) -> ToolCosts {
    if rng.random_bool(0.3) {
        return ToolCosts::uniform(4);
    }
    let row = |from: u8, rng: &mut Xoshiro256PlusPlus| {
        (0..4).map(|to| if to == from { 0 } else { rng.random_range(1..9) }).collect::<Vec<u32>>()
    };
    ToolCosts::new(&(0..4).map(|from| row(from, rng)).collect::<Vec<_>>()).unwrap()
}

/// All that a plan says of itself, counted from its paths.
fn judge(plan: &ToolPlan, layers: &Sliced, costs: &ToolCosts) {
    let mut visits: Vec<u8> = Vec::new();
    let mut lifts = 0;
    for (number, ((region, zones), layer)) in layers.iter().zip(&plan.layers).enumerate() {
        let order = layer.path.order();
        assert_eq!(verify(region, order), Ok(layer.path.pieces()));
        let steps = order.windows(2).filter(|step| region.adjacent(step[0], step[1]));
        let crossings = steps.filter(|step| zones.id(step[0]) != zones.id(step[1])).count();
        assert_eq!(crossings, layer.crossings as usize);
        assert_eq!(layer.kept_links.is_some(), number > 0);
        // The pieces of the cover, told apart again where two of them met.
        let zone = |cell: u32| zones.id(cell);
        let uncrossed: Vec<&[u32]> = layer
            .path
            .iter_pieces()
            .flat_map(|piece| piece.chunk_by(|&a, &b| zone(a) == zone(b)))
            .collect();
        let step = |pair: &[u32]| u64::from(costs.cost(zone(pair[0]), zone(pair[1])));
        let all_crossings: u64 =
            layer.path.iter_pieces().flat_map(|piece| piece.windows(2)).map(step).sum();
        match layer.crossing_cost {
            None => assert!(layer.pieces as usize >= uncrossed.len()),
            // Pieces that met add crossings to the path, but none to the cover.
            Some([cost, bound]) if layer.pieces == layer.path.pieces() => {
                assert_eq!(cost, all_crossings);
                assert!(bound <= cost);
            }
            Some([cost, bound]) => {
                assert!(
                    layer.pieces > layer.path.pieces() && bound <= cost && cost <= all_crossings
                );
            }
        }
        assert!(layer.piece_bound <= layer.pieces);
        visits.extend(order.iter().map(|&cell| zones.id(cell)));
        lifts += u64::from(layer.path.pieces()) - 1;
    }
    visits.dedup();
    let cost = visits.windows(2).map(|pair| u64::from(costs.cost(pair[0], pair[1]))).sum::<u64>();
    assert_eq!((&visits, lifts, cost), (&plan.visits, plan.lifts, plan.tool_cost));
    assert_eq!(plan.layers.len(), layers.len());
    if let Some(order) = &plan.order {
        assert!(order.bound <= cost, "a bound holds for every plan");
        assert!(plan.tool_changes() >= u64::from(order.least_changes));
    }
}

#[test]
fn plans_are_what_they_say() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for round in 0..400 {
        let layers = draw(&mut rng, 7);
        let costs = draw_costs(&mut rng);
        let constraints = Constraints::default();
        let plan = |mode, lift_cost, stacking| {
            let settings = Settings {
                mode,
                lift_cost,
                stacking,
                attempts: 10,
                ..Settings::new(&costs, &constraints)
            };
            let plan = tools_plan(&refs(&layers), &settings).unwrap();
            judge(&plan, &layers, &costs);
            plan
        };
        let stacking = [None, Some(Stacking::Keep), Some(Stacking::Break)][round % 3];
        let free = plan(Mode::Free, 0, stacking);
        assert_eq!(free.tool_cost, free.order.as_ref().unwrap().cost);
        assert!(free.layers.iter().all(|layer| !layer.is_continuous));
        let continuous = plan(Mode::Continuous, 0, stacking);
        assert!(continuous.layers.iter().all(|layer| layer.is_continuous));
        for (whole, cut) in continuous.layers.iter().zip(&free.layers) {
            assert!(whole.path.pieces() <= cut.path.pieces() || !whole.is_optimal());
        }
        let lift_cost = rng.random_range(0..20);
        let cheapest = plan(Mode::Cheapest, lift_cost, stacking);
        let at_price = |point: &FrontierPoint| point.tool_cost + u64::from(lift_cost) * point.lifts;
        let best = cheapest.frontier.iter().map(at_price).min().unwrap();
        assert!(
            cheapest.cost(lift_cost) <= best,
            "the plan is one of the frontier, with a lift less here and there"
        );
        assert!(
            best <= free.frontier.iter().chain(&continuous.frontier).map(at_price).min().unwrap()
        );
    }
}

#[test]
fn constraints_are_obeyed() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    for round in 0..200 {
        let layers = draw(&mut rng, 6);
        let costs = draw_costs(&mut rng);
        let same_order = round % 2 == 0;
        let first = layers[0].1.id(layers[0].0.cells().next().unwrap());
        let first = rng.random_bool(0.5).then_some(first);
        let before = if rng.random_bool(0.5) { vec![(2, 1)] } else { Vec::new() };
        let constraints = Constraints { before: before.clone(), first, same_order };
        let settings = Settings { lift_cost: 1, ..Settings::new(&costs, &constraints) };
        let plan = match tools_plan(&refs(&layers), &settings) {
            Err(PlanError::Order(OrderError::FirstContradicted { .. })) => continue,
            plan => plan.unwrap(),
        };
        judge(&plan, &layers, &costs);
        assert!(first.is_none_or(|first| plan.visits[0] == first));
        for ((_, zones), layer) in layers.iter().zip(&plan.layers) {
            let mut tools: Vec<u8> =
                layer.path.order().iter().map(|&cell| zones.id(cell)).collect();
            tools.dedup();
            let place = |tool| tools.iter().position(|&other| other == tool);
            for &(a, b) in &before {
                assert!(place(a).zip(place(b)).is_none_or(|(a, b)| a < b), "{tools:?}");
            }
            if same_order {
                let permutation = plan.order.as_ref().unwrap().permutation.as_ref().unwrap();
                let places: Vec<_> = tools
                    .iter()
                    .map(|tool| permutation.iter().position(|other| other == tool))
                    .collect();
                assert!(places.is_sorted(), "{tools:?} {permutation:?}");
            }
        }
    }
}

/// Layers of one row of cells, each with the tools given.
fn rows(tools: &[&[u8]]) -> Sliced {
    let row = |tools: &&[u8]| {
        let inside = (0..8).map(|x| x < tools.len()).collect();
        let region = Region::from_mask(8, 1, inside).unwrap();
        let ids = (0..8).map(|x| tools.get(x).copied().unwrap_or(Zones::OUTSIDE)).collect();
        let zones = Zones::new(&region, ids).unwrap();
        (region, zones)
    };
    tools.iter().map(row).collect()
}

#[test]
fn one_order_for_all_layers_is_one_even_where_others_cost_as_little() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let known: Vec<Vec<u8>> =
        vec![vec![0, 1, 2, 3], vec![3, 6], vec![1, 2], vec![1, 5], vec![1, 2], vec![1, 5]];
    let drawn = (0..300).map(|_| {
        let layer = |rng: &mut Xoshiro256PlusPlus| {
            let tools: Vec<u8> = (0..7).filter(|_| rng.random_bool(0.5)).collect();
            if tools.is_empty() { vec![0] } else { tools }
        };
        (0..rng.random_range(2..7)).map(|_| layer(&mut rng)).collect::<Vec<_>>()
    });
    for sets in std::iter::once(known).chain(drawn) {
        let layers = rows(&sets.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let costs = ToolCosts::uniform(7);
        let constraints = Constraints { same_order: true, ..Constraints::default() };
        let plan = tools_plan(&refs(&layers), &Settings::new(&costs, &constraints)).unwrap();
        judge(&plan, &layers, &costs);
        let order = plan.order.as_ref().unwrap();
        assert_eq!(plan.tool_cost, order.cost);
        let permutation = order.permutation.as_ref().unwrap();
        for ((_, zones), layer) in layers.iter().zip(&plan.layers) {
            let places = layer
                .path
                .order()
                .iter()
                .map(|&cell| permutation.iter().position(|&tool| tool == zones.id(cell)));
            assert!(places.is_sorted());
        }
    }
}

/// A disc that moves: layers that differ at their rims, of three zones.
fn leaning(layers: u32) -> Sliced {
    let layer = |number: u32| {
        let region = RegionShape::Disc.region(24, 24, 0).unwrap();
        let shifted = |cell: u32| {
            let (x, y) = region.xy(cell);
            x >= number && region.contains(region.cell(x - number, y))
        };
        let mask = (0..region.grid_len() as u32).map(shifted).collect();
        let region = Region::from_mask(24, 24, mask).unwrap();
        let zones =
            LayoutSpec::new(Layout::Voronoi).zones(&Region::rectangle(24, 24).unwrap(), 3).unwrap();
        let zones = Zones::new(&region, zones.ids().to_vec()).unwrap();
        (region, zones)
    };
    (0..layers).map(layer).collect()
}

#[test]
fn stacking_decides_between_equals() {
    let layers = leaning(8);
    let (costs, constraints) = (ToolCosts::uniform(3), Constraints::default());
    let plan = |stacking| {
        let settings =
            Settings { mode: Mode::Continuous, stacking, ..Settings::new(&costs, &constraints) };
        let plan = tools_plan(&refs(&layers), &settings).unwrap();
        judge(&plan, &layers, &costs);
        let kept: u32 = plan.layers.iter().filter_map(|layer| layer.kept_links).sum();
        let merit: Vec<_> =
            plan.layers.iter().map(|layer| (layer.path.pieces(), layer.crossings)).collect();
        (kept, merit)
    };
    let [alone, keep, cross] = [None, Some(Stacking::Keep), Some(Stacking::Break)].map(plan);
    assert!(keep.0 > alone.0 && cross.0 < alone.0, "{} {} {}", keep.0, alone.0, cross.0);
    for (stacked, alone) in keep.1.iter().chain(&cross.1).zip(alone.1.iter().cycle()) {
        assert!(stacked <= alone);
    }
}

#[test]
fn threads_change_nothing_and_progress_is_told() {
    let mut layers = leaning(5);
    layers.extend_from_within(2..4);
    let (costs, constraints) = (ToolCosts::uniform(3), Constraints::default());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let most = AtomicUsize::new(0);
    let told = |progress: Progress| {
        most.fetch_max(progress.done, Ordering::Relaxed);
    };
    for stacking in [None, Some(Stacking::Keep)] {
        most.store(0, Ordering::Relaxed);
        let settings = Settings { lift_cost: 1, stacking, ..Settings::new(&costs, &constraints) };
        let one = tools_plan(&refs(&layers), &settings).unwrap();
        let two = Settings { pool: Some(&pool), observer: Some(&told), ..settings };
        let two = tools_plan(&refs(&layers), &two).unwrap();
        let orders = |plan: &ToolPlan| {
            plan.layers.iter().map(|layer| layer.path.order().to_vec()).collect::<Vec<_>>()
        };
        assert_eq!(orders(&one), orders(&two));
        assert_eq!(most.load(Ordering::Relaxed), layers.len());
    }
}

#[test]
fn impossible_plans_are_refused() {
    let layers = leaning(2);
    let layers = refs(&layers);
    let costs = ToolCosts::uniform(3);
    let refused = |layers: &[LayerRef<'_>], costs: &ToolCosts, mode, constraints: &Constraints| {
        tools_plan(layers, &Settings { mode, ..Settings::new(costs, constraints) }).unwrap_err()
    };
    let none = Constraints::default();
    assert_eq!(refused(&[], &costs, Mode::Free, &none), PlanError::NoLayers);
    let few = refused(&layers, &ToolCosts::uniform(2), Mode::Continuous, &none);
    assert_eq!(few, PlanError::Order(OrderError::UnknownTool { tool: 2, tools: 2 }));
    let same = Constraints { same_order: true, ..none.clone() };
    assert_eq!(refused(&layers, &costs, Mode::Continuous, &same), PlanError::Constraint);
    let dear = ToolCosts::new(&[vec![0, 1, 1], vec![1, 0, 20_000], vec![1, 1, 0]]).unwrap();
    assert!(matches!(refused(&layers, &dear, Mode::Continuous, &none), PlanError::Costs(_)));
    // Without crossings they cost what they may.
    let free = Settings { mode: Mode::Free, ..Settings::new(&dear, &none) };
    assert!(tools_plan(&layers, &free).is_ok());
    let other = (
        Region::rectangle(3, 2).unwrap(),
        Zones::new(&Region::rectangle(3, 2).unwrap(), vec![0; 6]).unwrap(),
    );
    let planes = [layers[0], LayerRef { region: &other.0, zones: &other.1 }];
    let expected = PlanError::Plane { layer: 1, expected: [24, 24], got: [3, 2] };
    assert_eq!(refused(&planes, &costs, Mode::Free, &none), expected);
    let cancel = AtomicBool::new(true);
    let settings = Settings { cancel: Some(&cancel), ..Settings::new(&costs, &none) };
    assert_eq!(tools_plan(&layers, &settings).unwrap_err(), PlanError::Cancelled);
}
