//! Tests of bead plans.

use beadwork_base::{Control, Threads};
use beadwork_gcode::Feature;
use beadwork_part::slice::{FillRule, LayerAreas, MaterialArea};
use beadwork_part::toolpath::{self, InfillPattern, Island, islands};
use beadwork_part::{Area, Ring};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::ThreadPoolBuilder;

use super::*;
use crate::{CostMatrix, Stop, join, travel};

fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Ring {
    vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
}

fn polygon(x: f64, y: f64, radius: f64, corners: u32) -> Ring {
    let corner = |number| {
        let angle = std::f64::consts::TAU * f64::from(number) / f64::from(corners);
        [x + radius * libm::cos(angle), y + radius * libm::sin(angle)]
    };
    (0..corners).map(corner).collect()
}

/// Layers of random plates with holes, some of which have two materials side by side.
fn random_layers(rng: &mut Xoshiro256PlusPlus) -> Vec<LayerAreas> {
    let count = rng.random_range(1..6);
    let tools = rng.random_range(1..=2_u8);
    let [width, height] = [0, 1].map(|_| rng.random_range(3.0..25.0));
    let hole = polygon(
        rng.random_range(2.0..width),
        rng.random_range(2.0..height),
        rng.random_range(0.5..4.0),
        rng.random_range(3..40),
    );
    let layer = |_| {
        let areas = (0..tools).filter_map(|material| {
            let left = f64::from(material) * width;
            let plate = Area::from_rings(&[rectangle(left, 0.0, width, height)], FillRule::NonZero);
            let hole = Area::from_rings(std::slice::from_ref(&hole), FillRule::NonZero);
            let area = plate.difference(&hole);
            (!area.is_empty()).then_some(MaterialArea { material, area })
        });
        LayerAreas { areas: areas.collect() }
    };
    (0..count).map(layer).collect()
}

fn random_toolpath(rng: &mut Xoshiro256PlusPlus) -> toolpath::Settings {
    toolpath::Settings {
        density: [0.0, 0.15, 0.3, 1.0][rng.random_range(0..4)],
        pattern: InfillPattern::ALL[rng.random_range(0..InfillPattern::ALL.len())],
        perimeters: rng.random_range(0..4),
        top_layers: rng.random_range(0..2),
        bottom_layers: rng.random_range(0..2),
        ..toolpath::Settings::default()
    }
}

/// A line as two points in ascending order, in units of 1e-6 mm.
fn key(a: [f64; 2], b: [f64; 2]) -> [[i64; 2]; 2] {
    let mut ends = [a, b].map(|point| point.map(|value| (value * 1e6).round() as i64));
    ends.sort_unstable();
    ends
}

/// Checks that the plan prints each line of the islands once, with the right tool and feature.
fn check(layers: &[Vec<Island>], plan: &BeadPlan, is_joined: bool) {
    assert_eq!(layers.len(), plan.layers.len());
    for (number, (islands, layer)) in layers.iter().zip(&plan.layers).enumerate() {
        assert_eq!(layer.number, number);
        let mut tools: Vec<u8> = layer.beads.iter().map(|bead| bead.tool).collect();
        tools.dedup();
        let used: Vec<u8> = plan.order.orders[number]
            .iter()
            .copied()
            .filter(|tool| layer.beads.iter().any(|bead| bead.tool == *tool))
            .collect();
        assert_eq!(tools, used, "each tool once, in its order");
        for tool in plan.order.orders[number].clone() {
            let beads: Vec<_> = layer.beads.iter().filter(|bead| bead.tool == tool).collect();
            let of_tool: Vec<_> = islands.iter().filter(|each| each.material == tool).collect();
            let slits_mm = check_lengths(&of_tool, &beads, is_joined);
            let lines: Vec<_> = beads.iter().flat_map(|bead| bead.lines()).collect();
            let mut printed: Vec<_> = lines.iter().map(|&(from, to, _)| key(from, to)).collect();
            printed.sort_unstable();
            let infill = of_tool.iter().flat_map(|island| &island.infill);
            let infill = infill.flat_map(|infill| &infill.lines).flat_map(|line| line.windows(2));
            let rings = of_tool.iter().flat_map(|island| &island.insets).map(|inset| &inset.ring);
            let rings = rings
                .flat_map(|ring| (0..ring.len()).map(|at| [ring[at], ring[(at + 1) % ring.len()]]));
            let mut missing_mm = 0.0;
            for [from, to] in infill.map(|pair| [pair[0], pair[1]]).chain(rings) {
                let key = key(from, to);
                if key[0] != key[1] && printed.binary_search(&key).is_err() {
                    missing_mm += missing([from, to], &lines);
                }
            }
            assert!(missing_mm <= slits_mm, "{missing_mm} mm are missing, {slits_mm} allowed");
        }
        let counts = plan.counts[number];
        assert_eq!(counts.beads, layer.beads.len());
        assert!(counts.bead_bound <= counts.beads && counts.infill_bound <= counts.infill);
    }
}

/// Length in mm of what is not printed of a line, about.
fn missing([from, to]: [[f64; 2]; 2], lines: &[([f64; 2], [f64; 2], f64)]) -> f64 {
    const STEP_MM: f64 = 0.02;
    let count = (distance(from, to) / STEP_MM).ceil();
    let is_missing = |sample: &f64| {
        let share = (sample + 0.5) / count;
        let point = [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
        let is_near = |line: &([f64; 2], [f64; 2], f64)| {
            crate::segment::project(point, [line.0, line.1]).1 < 1e-6
        };
        !lines.iter().any(is_near)
    };
    let samples = (0..count as u32).map(f64::from);
    samples.filter(is_missing).count() as f64 * distance(from, to) / count
}

/// Walls have the length of their lines, apart from slits; infill has more, because it is linked.
/// Returns how much slits may cut out.
fn check_lengths(islands: &[&Island], beads: &[&beadwork_part::Bead], is_joined: bool) -> f64 {
    let ring_mm = |ring: &Ring| -> f64 {
        (0..ring.len()).map(|at| distance(ring[at], ring[(at + 1) % ring.len()])).sum()
    };
    let insets = islands.iter().flat_map(|island| &island.insets);
    let walls_mm: f64 = insets.clone().map(|inset| ring_mm(&inset.ring)).sum();
    let infill = || islands.iter().flat_map(|island| &island.infill);
    let lines = infill().flat_map(|infill| &infill.lines).flat_map(|line| line.windows(2));
    let infill_mm: f64 = lines.map(|pair| distance(pair[0], pair[1])).sum::<f64>()
        + infill().flat_map(|infill| &infill.loops).map(ring_mm).sum::<f64>();
    // Each splice removes a bead and cuts two slits.
    let loops = insets.count() + infill().map(|infill| infill.loops.len()).sum::<usize>();
    let slits_mm = if is_joined { 2.0 * 0.52 * loops as f64 } else { 1e-6 };
    let mut printed_mm = [0.0; 2];
    for bead in beads {
        let mut from = bead.start_mm;
        for step in &bead.moves {
            let length = distance(from, step.to_mm);
            from = step.to_mm;
            match step.feature {
                Feature::OuterWall | Feature::InnerWall => printed_mm[0] += length,
                Feature::Infill | Feature::SolidInfill => printed_mm[1] += length,
                _ => {}
            }
        }
    }
    assert!(printed_mm[0] >= walls_mm - slits_mm, "{printed_mm:?} {walls_mm}");
    // Steps between joined loops are short.
    assert!(printed_mm[0] <= walls_mm + 1.2 * (beads.len() + 40 * islands.len()) as f64);
    assert!(printed_mm[1] >= infill_mm - slits_mm, "{printed_mm:?} {infill_mm}");
    slits_mm
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn every_line_is_printed_once() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    let control = Control::default();
    let [mut joined, mut separate] = [0; 2];
    for _ in 0..120 {
        let areas = random_layers(&mut rng);
        let toolpath = random_toolpath(&mut rng);
        let layers = islands(&areas, &toolpath, &control).unwrap();
        let costs = CostMatrix::uniform(2);
        let mut settings = Settings {
            seam: Seam::ALL[rng.random_range(0..Seam::ALL.len())],
            order: [travel::Order::Free, travel::Order::Stages][rng.random_range(0..2)],
            seed: rng.random(),
            ..Settings::default()
        };
        let plan = solve(&layers, &toolpath, &costs, &settings, &control).unwrap();
        check(&layers, &plan, false);
        separate += plan.total().beads;
        settings.join = Some(join::Settings::default());
        let plan = solve(&layers, &toolpath, &costs, &settings, &control).unwrap();
        check(&layers, &plan, true);
        joined += plan.total().beads;
    }
    assert!(joined < separate / 2, "{joined} {separate}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let ring = |side: f64| vec![rectangle(0.0, 0.0, side, side), rectangle(2.0, 2.0, 3.0, 3.0)];
    let layer = |number: u32| {
        let area = Area::from_rings(&ring(20.0 - 0.1 * f64::from(number)), FillRule::EvenOdd);
        LayerAreas { areas: vec![MaterialArea { material: 0, area }] }
    };
    let areas: Vec<LayerAreas> = (0..40).map(layer).collect();
    let toolpath = toolpath::Settings::default();
    let layers = islands(&areas, &toolpath, &Control::default()).unwrap();
    let settings = Settings { bound_iterations: 20, ..Settings::default() };
    let pool = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let plans = [Threads::One, Threads::Pool(&pool)].map(|threads| {
        let control = Control::on(threads);
        solve(&layers, &toolpath, &CostMatrix::uniform(1), &settings, &control).unwrap()
    });
    assert_eq!(plans[0], plans[1]);
    let plan = &plans[0];
    assert_eq!(plan.stop, Stop::Optimal);
    let bound = plan.travel_bound_mm.unwrap();
    assert!(bound > 0.0 && bound <= plan.travel_mm, "{bound} {}", plan.travel_mm);
    assert_eq!(plan.lifts(), plan.total().beads - plan.layers.len());
}

#[test]
fn seams_are_where_the_rule_says() {
    let layer = |number: u32| {
        let rings = [polygon(0.1 * f64::from(number), 0.0, 8.0, 60)];
        let area = Area::from_rings(&rings, FillRule::NonZero);
        LayerAreas { areas: vec![MaterialArea { material: 0, area }] }
    };
    let areas: Vec<LayerAreas> = (0..20).map(layer).collect();
    let toolpath = toolpath::Settings::default();
    let layers = islands(&areas, &toolpath, &Control::default()).unwrap();
    let seams_of = |seam| {
        let settings = Settings { seam, ..Settings::default() };
        let costs = CostMatrix::uniform(1);
        let plan = solve(&layers, &toolpath, &costs, &settings, &Control::default()).unwrap();
        let outer = |layer: &beadwork_part::BeadLayer| {
            let mut beads = layer.beads.iter();
            beads.find(|bead| bead.moves[0].feature == Feature::OuterWall).unwrap().start_mm
        };
        plan.layers.iter().map(outer).collect::<Vec<_>>()
    };
    let steps = |seams: &[[f64; 2]]| {
        seams.windows(2).map(|pair| distance(pair[0], pair[1])).fold(0.0, f64::max)
    };
    let rear = seams_of(Seam::Rear);
    assert!(rear.iter().all(|seam| seam[1] > 7.6), "{rear:?}");
    assert!(steps(&seams_of(Seam::Aligned)) < 1.2);
    assert!(steps(&seams_of(Seam::Random)) > 3.0);
}

#[test]
fn tools_follow_each_other_along_short_ways() {
    // Eight squares around a ring, of tools in a mixed order.
    let tools = [3, 6, 0, 4, 7, 1, 5, 2];
    let square = |(at, &material): (usize, &u8)| {
        let angle = std::f64::consts::TAU * at as f64 / 8.0;
        let [x, y] = [30.0 * angle.cos(), 30.0 * angle.sin()];
        let rings = [rectangle(x, y, x + 10.0, y + 10.0)];
        MaterialArea { material, area: Area::from_rings(&rings, FillRule::EvenOdd) }
    };
    let mut areas: Vec<MaterialArea> = tools.iter().enumerate().map(square).collect();
    areas.sort_unstable_by_key(|area| area.material);
    let areas = vec![LayerAreas { areas }; 6];
    let toolpath = toolpath::Settings::default();
    let layers = islands(&areas, &toolpath, &Control::default()).unwrap();
    let plan = |tool_change_mm| {
        let settings = Settings { tool_change_mm, bound_iterations: 20, ..Settings::default() };
        let costs = CostMatrix::uniform(8);
        let plan = solve(&layers, &toolpath, &costs, &settings, &Control::default()).unwrap();
        check(&layers, &plan, false);
        assert!(plan.travel_bound_mm.unwrap() <= plan.travel_mm);
        assert_eq!((plan.stop, plan.order.changes), (Stop::Optimal, 6 * 7));
        plan
    };
    let seat = |tool: u8| tools.iter().position(|&one| one == tool).unwrap();
    let short = plan(None);
    for order in &short.order.orders {
        for pair in order.windows(2) {
            let apart = seat(pair[0]).abs_diff(seat(pair[1]));
            assert!(apart == 1 || apart == 7, "{order:?}");
        }
    }
    let all_travel = |plan: &BeadPlan| -> f64 {
        let beads: Vec<&beadwork_part::Bead> =
            plan.layers.iter().flat_map(|layer| &layer.beads).collect();
        beads.windows(2).map(|pair| distance(pair[0].end_mm(), pair[1].start_mm)).sum()
    };
    // At a prime tower, the order of the tools does not matter to travel.
    let tower = plan(Some([100.0, 0.0]));
    assert!(all_travel(&short) < 0.7 * all_travel(&tower));
}

#[test]
fn layers_may_be_empty() {
    let toolpath = toolpath::Settings::default();
    let plan = |layers: &[Vec<Island>]| {
        let costs = CostMatrix::uniform(1);
        solve(layers, &toolpath, &costs, &Settings::default(), &Control::default()).unwrap()
    };
    assert_eq!(plan(&[]).total(), Counts::default());
    let plan = plan(&[Vec::new(), Vec::new()]);
    assert_eq!((plan.layers.len(), plan.lifts(), plan.stop), (2, 0, Stop::Optimal));
}

#[test]
fn tools_are_not_fetched_for_what_is_too_small() {
    // The second material is too thin in every other layer.
    let layer = |number: u32| {
        let width = if number.is_multiple_of(2) { 3.0 } else { 0.05 };
        let rings = [rectangle(0.0, 0.0, 9.0, 9.0), rectangle(9.0, 0.0, width, 9.0)];
        let areas = rings.iter().zip(0..).map(|(ring, material)| {
            let area = Area::from_rings(std::slice::from_ref(ring), FillRule::NonZero);
            MaterialArea { material, area }
        });
        LayerAreas { areas: areas.collect() }
    };
    let areas: Vec<LayerAreas> = (0..4).map(layer).collect();
    let toolpath = toolpath::Settings::default();
    let layers = islands(&areas, &toolpath, &Control::default()).unwrap();
    assert_eq!(layers[1].len(), 2);
    let costs = CostMatrix::uniform(2);
    let plan = solve(&layers, &toolpath, &costs, &Settings::default(), &Control::default());
    let plan = plan.unwrap();
    check(&layers, &plan, false);
    assert_eq!(plan.order.orders[1].len(), 1);
    let beads = plan.layers.iter().flat_map(|layer| &layer.beads);
    let mut tools: Vec<u8> = beads.map(|bead| bead.tool).collect();
    tools.dedup();
    assert_eq!(plan.order.changes as usize, tools.len() - 1);
}

#[test]
fn joined_thin_walls_stay_within_the_outline() {
    // A block with a fin that is thinner than a bead.
    for fin in [0.3, 0.45, 0.6] {
        let (low, high) = (5.0 - fin / 2.0, 5.0 + fin / 2.0);
        let ring = vec![
            [0.0, 0.0],
            [10.0, 0.0],
            [10.0, low],
            [18.0, low],
            [18.0, high],
            [10.0, high],
            [10.0, 10.0],
            [0.0, 10.0],
        ];
        let area = Area::from_rings(std::slice::from_ref(&ring), FillRule::NonZero);
        let areas = [LayerAreas { areas: vec![MaterialArea { material: 0, area }] }];
        let toolpath = toolpath::Settings::default();
        let layers = islands(&areas, &toolpath, &Control::default()).unwrap();
        assert!(!layers[0][0].skeletons.is_empty());
        let settings = Settings { join: Some(join::Settings::default()), ..Settings::default() };
        let costs = CostMatrix::uniform(1);
        let plan = solve(&layers, &toolpath, &costs, &settings, &Control::default()).unwrap();
        check(&layers, &plan, true);
        assert!(plan.layers[0].beads.len() < 3, "the fin is joined to the block");
        let from_edge = |point: [f64; 2]| {
            let nearest = |at: usize| {
                let edge = [ring[at], ring[(at + 1) % ring.len()]];
                crate::segment::project(point, edge).1
            };
            (0..ring.len()).map(nearest).fold(f64::INFINITY, f64::min)
        };
        for bead in &plan.layers[0].beads {
            let mut from = bead.start_mm;
            for step in &bead.moves {
                let is_skeleton = matches!(step.feature, Feature::ThinWall | Feature::GapFill);
                let needed = if is_skeleton { 0.004 } else { 0.45 * step.width_mm - 0.002 };
                for part in (0..=10).map(f64::from) {
                    let point = [0, 1].map(|k| from[k] + part / 10.0 * (step.to_mm[k] - from[k]));
                    assert!(from_edge(point) >= needed, "{fin}: {point:?}");
                }
                from = step.to_mm;
            }
        }
    }
}
