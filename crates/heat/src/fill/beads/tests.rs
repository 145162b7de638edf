//! Orders of beads print the moves of the given layers, and take the time that their programs take.

use beadwork_base::{Control, Threads};
use beadwork_gcode::{Feature, Program};
use beadwork_part::ExtrusionMove;
use beadwork_part::print::{Print, Process, Settings, Title, Tool};
use beadwork_thermal::objective::Objective;
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{ProcessParameters, ThermalMaterial};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::fill::OrderName;
use crate::model::{LayerCost, Solver, ThermalModel};
use crate::plan::conventional;
use crate::planner::{self, Annealing, Planner};

const WIDTH_MM: f64 = 0.5;

fn frame(width: u32, height: u32) -> Frame {
    Frame { left_mm: 100.0, back_mm: 120.0, cell_mm: WIDTH_MM, layer_mm: 0.25, width, height }
}

fn timing() -> BeadTiming {
    let settings = Settings::default();
    BeadTiming { process: Process::default(), limits: settings.printer.limits() }
}

/// A bead along centres of cells.
fn bead(frame: &Frame, cells: &[[u32; 2]], feature: Feature) -> Bead {
    let mut points = cells.iter().map(|&[x, y]| frame.centre(x, y));
    let start_mm = points.next().unwrap();
    let moves = points.map(|to_mm| ExtrusionMove { to_mm, width_mm: WIDTH_MM, feature });
    Bead { tool: 0, start_mm, moves: moves.collect() }
}

/// A wall around a zigzag of infill, whose lines run along y in every second layer.
fn layer(frame: &Frame, number: usize) -> BeadLayer {
    let (width, height) = (frame.width, frame.height);
    let [right, top] = [width - 1, height - 1];
    let wall = [[0, 0], [right, 0], [right, top], [0, top], [0, 0]];
    let rows = if number.is_multiple_of(2) { 1..top } else { 1..right };
    let zigzag: Vec<[u32; 2]> = rows
        .flat_map(|row| {
            let ends = if number.is_multiple_of(2) {
                [[1, row], [right - 1, row]]
            } else {
                [[row, 1], [row, top - 1]]
            };
            if row.is_multiple_of(2) { [ends[1], ends[0]] } else { ends }
        })
        .collect();
    let wall = bead(frame, &wall, Feature::OuterWall);
    BeadLayer { number, beads: vec![wall, bead(frame, &zigzag, Feature::SolidInfill)] }
}

fn block(width: u32, height: u32, depth: usize) -> (Vec<BeadLayer>, Frame) {
    let frame = frame(width, height);
    ((0..depth).map(|number| layer(&frame, number)).collect(), frame)
}

/// The lines of some beads without their directions, sorted.
fn lines(beads: &[Bead]) -> Vec<[[i64; 2]; 2]> {
    let rounded = |[x, y]: [f64; 2]| [(x * 1e6).round() as i64, (y * 1e6).round() as i64];
    let sorted = |(from, to, _): ([f64; 2], [f64; 2], f64)| {
        let mut ends = [rounded(from), rounded(to)];
        ends.sort_unstable();
        ends
    };
    let mut lines: Vec<_> = beads.iter().flat_map(Bead::lines).map(sorted).collect();
    lines.sort_unstable();
    lines
}

/// Voxels of some events, sorted.
fn voxels(events: &[DepositionEvent]) -> Vec<[u32; 3]> {
    let mut voxels: Vec<[u32; 3]> = events.iter().filter_map(|event| event.voxel).collect();
    voxels.sort_unstable();
    voxels
}

#[test]
fn every_order_prints_each_move_and_each_voxel_once() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(0);
    let mut number = |below: u64| (rng.next_u64() % below) as u32;
    let names = RowOrder::all();
    for case in 0..300 {
        let frame = frame(12, 9);
        // Walls and infill drawn at random, which cross each other.
        let features = [Feature::OuterWall, Feature::Infill, Feature::SolidInfill];
        let beads: Vec<Bead> = (0..=number(5))
            .map(|_| {
                let cells: Vec<[u32; 2]> =
                    (0..2 + number(7)).map(|_| [number(12), number(9)]).collect();
                bead(&frame, &cells, features[number(3) as usize])
            })
            .collect();
        let fill = Beads::new(&[BeadLayer { number: 0, beads: beads.clone() }], frame, timing());
        let listed = fill.conventional(0).path;
        assert_eq!(lines(&fill.beads(0, &listed)), lines(&beads));
        let expected = voxels(&fill.events(0, None, &listed));
        assert_eq!(expected.len(), fill.voxel_count(0));
        let part = fill.voxels();
        assert!(expected.iter().all(|&[x, y, z]| part.material(x, y, z as usize).is_some()));
        assert_eq!(expected.len(), part.count());

        let set = fill.lines(0, None);
        let mut permutation: Vec<usize> = (0..set.count()).collect();
        for last in (1..permutation.len()).rev() {
            permutation.swap(last, number(last as u64 + 1) as usize);
        }
        let name = names[case % names.len()];
        // A list in two parts is the list.
        let (begin, tail) = permutation.split_at(permutation.len() / 2);
        let mut joined = set.path(begin, None);
        let nozzle = fill.ends(0, &joined).map(|[_, end]| end);
        joined.extend(set.rest(tail, nozzle));
        assert_eq!(joined, set.path(&permutation, None));
        let from = (case % 3 > 0).then_some([101.0, 118.0]);
        for path in [
            fill.named(0, name).path,
            set.path(&permutation, from),
            set.path(&set.start(from), from),
        ] {
            let printed = fill.beads(0, &path);
            assert_eq!(lines(&printed), lines(&beads), "{name}");
            assert_eq!(voxels(&fill.events(0, from, &path)), expected);
            // Walls keep their order and their directions.
            let walls = |beads: &[Bead]| -> Vec<Bead> {
                let is_wall = |bead: &&Bead| bead.moves[0].feature == Feature::OuterWall;
                beads.iter().filter(is_wall).cloned().collect()
            };
            if name != RowOrder::Listed {
                assert_eq!(walls(&printed), walls(&beads));
            }
            // Time that is not travel does not depend on the order.
            let own = |path: &[TurnedBead]| -> f64 {
                let events = |&turned: &TurnedBead| fill.events(0, None, &vec![turned]);
                path.iter().flat_map(events).map(|event| event.seconds).sum()
            };
            assert!((own(&path) - own(&listed)).abs() < 1e-9);
        }
    }
}

#[test]
fn lines_that_follow_one_another_stay_linked() {
    let (layers, frame) = block(14, 10, 2);
    let fill = Beads::new(&layers, frame, timing());
    for (number, layer) in (0..).zip(&layers) {
        let named = |name: RowOrder| fill.beads(number, &fill.named(number, name).path);
        assert_eq!(named(RowOrder::Listed), layer.beads);
        let sequential = [false, true].map(|is_descending| Strips {
            sequence: "sequential".parse().unwrap(),
            rows: 1,
            is_descending,
        });
        // From one side, the rows are printed as they were linked.
        let beads = sequential.map(|strips| named(RowOrder::Strips(strips)));
        assert!(beads.iter().any(|beads| beads.len() == 2));
        // Strips of all rows are the sequential order.
        let whole = Strips { sequence: "golden".parse().unwrap(), rows: 99, ..sequential[0] };
        assert_eq!(named(RowOrder::Strips(whole)), beads[0]);
    }
}

#[test]
fn estimated_times_differ_as_those_of_programs() {
    let (layers, frame) = block(60, 40, 4);
    let fill = Beads::new(&layers, frame, timing());
    let settings = Settings { tools: vec![Tool::default()], ..Settings::default() };
    let exact = |layers: &[BeadLayer]| {
        let (title, control) = (Title { part: "block", version: "0" }, Control::default());
        let print = Print::of_beads(title, layers, &frame, &settings, &control).unwrap();
        let program: Program = print.program.emit().parse().unwrap();
        program.print_seconds(settings.printer.limits(), &control).unwrap()
    };
    let estimated = |name: RowOrder| {
        let (mut from, mut seconds) = (None, 0.0);
        for layer in 0..4 {
            let path = fill.named(layer, name).path;
            seconds += fill.seconds(layer, from, &path);
            from = fill.ends(layer, &path).map(|[_, end]| end);
        }
        seconds
    };
    let printed = |name: RowOrder| -> Vec<BeadLayer> {
        let beads = |layer: u32| fill.beads(layer, &fill.named(layer, name).path);
        (0..4).map(|layer| BeadLayer { number: layer as usize, beads: beads(layer) }).collect()
    };
    let (first, first_exact) = (estimated(RowOrder::Listed), exact(&layers));
    assert!((first / first_exact - 1.0).abs() < 0.1, "{first} {first_exact}");
    for name in ["scattered-7", "interleaved-2", "golden", "bit-reversed"] {
        for rows in [1, 3] {
            let strips = Strips { sequence: name.parse().unwrap(), rows, is_descending: false };
            let name = RowOrder::Strips(strips);
            let longer = exact(&printed(name)) - first_exact;
            let estimate = estimated(name) - first;
            assert!((estimate / longer - 1.0).abs() < 0.15, "{name}: {estimate} {longer}");
        }
    }
}

#[test]
fn planners_plan_beads() {
    let (layers, frame) = block(24, 14, 3);
    let fill = Beads::new(&layers, frame, timing());
    let part = Arc::new(fill.voxels());
    let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
    let model = |objective: Objective| {
        let cost = LayerCost::of(objective).unwrap();
        let method = Method::default();
        Solver::of_fill(fill.clone(), part.clone(), &material, &process, method, cost).unwrap()
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for objective in [Objective::Reward, Objective::NoTravel] {
        let model = model(objective);
        let listed = conventional(&model, &Control::default()).unwrap();
        for planner in
            [Planner::Constant, Planner::Greedy, Planner::SmartScan, Planner::Lines, Planner::Beam]
        {
            let settings = planner::Settings {
                planner,
                beam_width: 2,
                orders: RowOrder::all().into_iter().step_by(7).collect(),
                annealing: Some(Annealing {
                    trials: 60,
                    model_trials: 120,
                    ..Annealing::default()
                }),
                max_seconds: 1.06 * listed.seconds(),
                ..planner::Settings::default()
            };
            let plan = planner::plan(&model, &settings, &Control::default()).unwrap();
            assert!(plan.seconds() <= settings.max_seconds);
            assert!(plan.cost() <= listed.cost(), "{planner}");
            if planner == Planner::Lines {
                assert!(plan.cost() < 0.97 * listed.cost(), "{} {}", plan.cost(), listed.cost());
            }
            let mut state = model.clone();
            for (layer, planned) in (0..).zip(&plan.layers) {
                let cost = state.deposit(layer, &planned.path, &Control::default()).unwrap();
                assert!((cost - planned.cost).abs() < 1e-9);
                let printed = fill.beads(layer, &planned.path);
                assert_eq!(lines(&printed), lines(&layers[layer as usize].beads));
            }
            let parallel = Control::on(Threads::Pool(&pool));
            assert_eq!(planner::plan(&model, &settings, &parallel).unwrap(), plan, "{planner}");
        }
    }
}

#[test]
fn missing_layers_and_empty_ones_print_nothing() {
    let (mut layers, frame) = block(10, 8, 3);
    layers[1].beads.clear();
    let fill = Beads::new(&layers, frame, timing());
    assert_eq!((fill.layer_count(), fill.voxel_count(1)), (3, 0));
    layers.remove(1);
    assert_eq!(Beads::new(&layers, frame, timing()).voxel_count(1), 0);
    assert_eq!(Beads::new(&[], frame, timing()).layer_count(), 0);
}
