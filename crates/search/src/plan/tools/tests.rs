//! Plans of small parts, checked from their paths alone.

use std::sync::Mutex;

use beadwork_base::{CancelToken, Control, Interrupted, Threads};
use beadwork_grid::{Layout, LayoutSpec, Region, RegionShape, Zones, verify};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::CostMatrix;
use crate::plan::{Constraints, OrderError};

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

/// Costs of four tools: uniform, whole numbers, or numbers that are rounded.
fn draw_costs(rng: &mut Xoshiro256PlusPlus) -> CostMatrix {
    let unit = match rng.random_range(0..6) {
        0 | 1 => return CostMatrix::uniform(4),
        2 => 1.0 / 7.0,
        _ => 1.0,
    };
    let costs: Vec<f64> = (0..16).map(|_| unit * f64::from(rng.random_range(1..9))).collect();
    CostMatrix::from_fn(4, |from, to| costs[4 * from + to]).unwrap()
}

/// Plans without control.
fn plan_alone(
    layers: &Sliced,
    costs: &CostMatrix,
    settings: &Settings,
) -> Result<ToolPlan, PlanError> {
    solve(&refs(layers), costs, settings, &Control::default())
}

/// Checks all statements of a plan against its paths.
fn check(plan: &ToolPlan, layers: &Sliced, costs: &CostMatrix) {
    let mut visits: Vec<u8> = Vec::new();
    let mut lifts = 0;
    for (number, ((region, zones), layer)) in layers.iter().zip(&plan.layers).enumerate() {
        let order = layer.path.order();
        assert_eq!(verify(region, order), Ok(layer.path.pieces()));
        let steps = order.windows(2).filter(|step| region.adjacent(step[0], step[1]));
        let crossings = steps.filter(|step| zones.id(step[0]) != zones.id(step[1])).count();
        assert_eq!(crossings, layer.crossings as usize);
        assert_eq!(layer.kept_links.is_some(), number > 0);
        // The pieces of the cover, separated again where the path joined two of them.
        let zone = |cell: u32| zones.id(cell);
        let uncrossed: Vec<&[u32]> = layer
            .path
            .iter_pieces()
            .flat_map(|piece| piece.chunk_by(|&a, &b| zone(a) == zone(b)))
            .collect();
        let step = |pair: &[u32]| costs.step(zone(pair[0]), zone(pair[1]));
        let all_crossings: u64 =
            layer.path.iter_pieces().flat_map(|piece| piece.windows(2)).map(step).sum();
        let all_crossings = costs.unscaled(all_crossings);
        match layer.crossing_cost {
            None => assert!(layer.pieces as usize >= uncrossed.len()),
            // Joined pieces add crossings to the path, but none to the cover.
            Some([cost, bound]) if layer.pieces == layer.path.pieces() => {
                assert_eq!(cost.to_bits(), all_crossings.to_bits());
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
    assert_eq!((&visits, lifts), (&plan.visits, plan.lifts));
    visits.splice(0..0, plan.loaded);
    let cost = visits.windows(2).map(|pair| costs.step(pair[0], pair[1])).sum::<u64>();
    assert_eq!(costs.unscaled(cost).to_bits(), plan.tool_cost.to_bits());
    visits.dedup();
    assert_eq!(visits.len() as u64 - 1, plan.tool_changes());
    assert_eq!(plan.layers.len(), layers.len());
    assert!(plan.order.bound <= plan.tool_cost, "the bound holds for every plan");
    assert!(plan.tool_changes() >= u64::from(plan.order.min_changes));
}

#[test]
fn plans_agree_with_their_paths() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for round in 0..400 {
        let layers = draw(&mut rng, 7);
        let costs = draw_costs(&mut rng);
        let loaded = rng.random_bool(0.5).then_some(rng.random_range(0..4));
        let plan = |mode, lift_cost, stacking| {
            let constraints = Constraints { loaded, ..Constraints::default() };
            let settings = Settings {
                mode,
                lift_cost,
                stacking,
                attempts: 10,
                constraints,
                ..Settings::default()
            };
            let plan = plan_alone(&layers, &costs, &settings).unwrap();
            check(&plan, &layers, &costs);
            plan
        };
        let stacking = [None, Some(Stacking::Keep), Some(Stacking::Break)][round % 3];
        let free = plan(Mode::Free, 0.0, stacking);
        assert_eq!(free.tool_cost.to_bits(), free.order.cost.to_bits());
        assert!(free.layers.iter().all(|layer| !layer.is_continuous));
        let continuous = plan(Mode::Continuous, 0.0, stacking);
        assert!(continuous.layers.iter().all(|layer| layer.is_continuous));
        for (whole, cut) in continuous.layers.iter().zip(&free.layers) {
            assert!(whole.path.pieces() <= cut.path.pieces() || !whole.is_optimal());
        }
        let lift_cost =
            f64::from(rng.random_range(0..20_u32)) / if round % 2 == 0 { 1.0 } else { 3.0 };
        let cheapest = plan(Mode::Cheapest, lift_cost, stacking);
        let cost = |point: &FrontierPoint| point.tool_cost + lift_cost * point.lifts as f64;
        let best = cheapest.frontier.iter().map(cost).fold(f64::MAX, f64::min);
        assert!(
            cheapest.cost(lift_cost) <= best + 1e-3,
            "the plan is one of the frontier, whose paths may join pieces"
        );
        let others = free.frontier.iter().chain(&continuous.frontier).map(cost);
        assert!(best <= others.fold(f64::MAX, f64::min) + 1e-3);
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
        let constraints =
            Constraints { before: before.clone(), first, same_order, ..Constraints::default() };
        let settings = Settings { lift_cost: 1.0, constraints, ..Settings::default() };
        let plan = match plan_alone(&layers, &costs, &settings) {
            Err(PlanError::Order(OrderError::FirstContradicted { .. })) => continue,
            plan => plan.unwrap(),
        };
        check(&plan, &layers, &costs);
        assert!(first.is_none_or(|first| plan.visits[0] == first));
        for ((_, zones), layer) in layers.iter().zip(&plan.layers) {
            let mut tools: Vec<u8> =
                layer.path.order().iter().map(|&cell| zones.id(cell)).collect();
            tools.dedup();
            let position = |tool| tools.iter().position(|&other| other == tool);
            for &(a, b) in &before {
                assert!(position(a).zip(position(b)).is_none_or(|(a, b)| a < b), "{tools:?}");
            }
            if same_order {
                let permutation = plan.order.permutation.as_ref().unwrap();
                let positions: Vec<_> = tools
                    .iter()
                    .map(|tool| permutation.iter().position(|other| other == tool))
                    .collect();
                assert!(positions.is_sorted(), "{tools:?} {permutation:?}");
            }
        }
    }
}

/// Layers of one row of cells each, with the given tools.
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

/// More tools than an exact order can be found for.
#[test]
fn parts_of_many_tools_are_planned() {
    let ids: Vec<u8> = (0..18 * 3).map(|cell| (cell * 7 % 18) as u8).collect();
    let region = Region::rectangle(18, 3).unwrap();
    let zones = Zones::new(&region, ids).unwrap();
    let layers = vec![(region, zones); 3];
    let costs = CostMatrix::from_fn(18, |from, to| (1 + (from * 31 + to * 17) % 23) as f64);
    let costs = costs.unwrap();
    for mode in Mode::ALL {
        for loaded in [None, Some(4)] {
            let constraints = Constraints { loaded, ..Constraints::default() };
            let settings = Settings { mode, lift_cost: 2.0, constraints, ..Settings::default() };
            let plan = plan_alone(&layers, &costs, &settings).unwrap();
            check(&plan, &layers, &costs);
            if mode == Mode::Free {
                assert_eq!(plan.tool_cost.to_bits(), plan.order.cost.to_bits());
            }
        }
    }
}

#[test]
fn all_layers_follow_one_order_even_if_others_are_as_cheap() {
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
        let costs = CostMatrix::uniform(7);
        let constraints = Constraints { same_order: true, ..Constraints::default() };
        let settings = Settings { constraints, ..Settings::default() };
        let plan = plan_alone(&layers, &costs, &settings).unwrap();
        check(&plan, &layers, &costs);
        assert_eq!(plan.tool_cost.to_bits(), plan.order.cost.to_bits());
        let permutation = plan.order.permutation.as_ref().unwrap();
        for ((_, zones), layer) in layers.iter().zip(&plan.layers) {
            let positions = layer
                .path
                .order()
                .iter()
                .map(|&cell| permutation.iter().position(|&tool| tool == zones.id(cell)));
            assert!(positions.is_sorted());
        }
    }
}

/// A leaning cylinder: discs of three zones, each shifted by one cell against the one below.
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
fn stacking_decides_between_equally_good_paths() {
    let layers = leaning(8);
    let costs = CostMatrix::uniform(3);
    let plan = |stacking| {
        let settings = Settings { mode: Mode::Continuous, stacking, ..Settings::default() };
        let plan = plan_alone(&layers, &costs, &settings).unwrap();
        check(&plan, &layers, &costs);
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
fn threads_change_nothing_and_each_layer_is_reported_once() {
    let mut layers = leaning(5);
    layers.extend_from_within(2..4);
    layers.extend(vec![layers[0].clone(); 60]);
    let costs = CostMatrix::uniform(3);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let seen = Mutex::new(Vec::new());
    let progress = |progress: beadwork_base::Progress| seen.lock().unwrap().push(progress);
    for stacking in [None, Some(Stacking::Keep), Some(Stacking::Break)] {
        let settings = Settings { lift_cost: 1.0, stacking, ..Settings::default() };
        let one = plan_alone(&layers, &costs, &settings).unwrap();
        let control = Control {
            threads: Threads::Pool(&pool),
            progress: Some(&progress),
            ..Control::default()
        };
        let two = solve(&refs(&layers), &costs, &settings, &control).unwrap();
        let orders = |plan: &ToolPlan| {
            plan.layers.iter().map(|layer| layer.path.order().to_vec()).collect::<Vec<_>>()
        };
        assert_eq!(orders(&one), orders(&two));
        let mut seen = std::mem::take(&mut *seen.lock().unwrap());
        assert!(seen.iter().all(|progress| progress.total == 67));
        seen.sort_by_key(|progress| progress.done);
        assert!(seen.iter().map(|progress| progress.done).eq(1..=67));
    }
}

#[test]
fn forbidden_changes_are_avoided_tool_by_tool() {
    let layers = rows(&[&[0, 1, 2], &[2, 1], &[0, 2]]);
    // From 0 only to 1, from 1 only to 2, from 2 only to 0.
    let cost = |from, to| if to == (from + 1) % 3 { 1.0 } else { f64::INFINITY };
    let costs = CostMatrix::from_fn(3, cost).unwrap();
    let plan = |mode| plan_alone(&layers, &costs, &Settings { mode, ..Settings::default() });
    let free = plan(Mode::Free).unwrap();
    check(&free, &layers, &costs);
    assert!(free.tool_cost.is_finite());
    let error = plan(Mode::Cheapest).unwrap_err();
    assert_eq!(error, PlanError::Forbidden { mode: Mode::Cheapest, from: 0, to: 2 });
    assert_eq!(
        error.to_string(),
        "mode cheapest: change from tool 0 to tool 2 is forbidden; only mode free can avoid changes"
    );
}

/// Costs beyond what the exact search can sum are rounded for it, but not for the plan.
#[test]
fn large_costs_have_valid_bounds() {
    let layers = leaning(3);
    let costs = CostMatrix::from_fn(3, |from, to| 123_456.0 + 7001.0 * (from * 3 + to) as f64);
    let costs = costs.unwrap();
    for mode in Mode::ALL {
        let settings = Settings { mode, lift_cost: 1e5, ..Settings::default() };
        check(&plan_alone(&layers, &costs, &settings).unwrap(), &layers, &costs);
    }
}

#[test]
fn impossible_plans_are_refused() {
    let layers = leaning(2);
    let layers = refs(&layers);
    let costs = CostMatrix::uniform(3);
    let error = |layers: &[LayerRef<'_>], costs: &CostMatrix, settings: &Settings| {
        solve(layers, costs, settings, &Control::default()).unwrap_err()
    };
    let continuous = Settings { mode: Mode::Continuous, ..Settings::default() };
    assert_eq!(error(&[], &costs, &Settings::default()), PlanError::NoLayers);
    let few = error(&layers, &CostMatrix::uniform(2), &continuous);
    assert_eq!(few, PlanError::Order(OrderError::UnknownTool { tool: 2, tools: 2 }));
    let constraints = Constraints { same_order: true, ..Constraints::default() };
    let same = Settings { constraints, ..continuous.clone() };
    assert_eq!(error(&layers, &costs, &same), PlanError::Constraint);
    let settings = Settings { lift_cost: -1.0, ..Settings::default() };
    assert_eq!(error(&layers, &costs, &settings), PlanError::LiftCost(-1.0));
    let other = (
        Region::rectangle(3, 2).unwrap(),
        Zones::new(&Region::rectangle(3, 2).unwrap(), vec![0; 6]).unwrap(),
    );
    let sizes = [layers[0], LayerRef { region: &other.0, zones: &other.1 }];
    let wrong = error(&sizes, &costs, &Settings::default());
    assert_eq!(wrong, PlanError::GridSize { layer: 1, expected: [24, 24], got: [3, 2] });
    assert_eq!(wrong.to_string(), "layer 1: grid is 3 x 2 cells, the first layer's is 24 x 24");
    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    let cancelled = solve(&layers, &costs, &Settings::default(), &control).unwrap_err();
    assert_eq!(cancelled, PlanError::Interrupted(Interrupted::Cancelled));
}
