//! Shared by the tests of the solver: random parts, materials, processes and orders, and
//! comparisons.

#![allow(dead_code, reason = "no test uses all of it")]
#![allow(unreachable_pub, reason = "every test is a crate of its own")]
#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Pattern};
use beadwork_thermal::event::layer_events;
use beadwork_thermal::oracle::scalar::{ScalarSolver, Scheme};
use beadwork_thermal::simulation::Method;
use beadwork_thermal::{DepositionEvent, ProcessParameters, Simulation, ThermalMaterial};
use ndarray::Array3;
use rand::{Rng as _, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Random numbers, the same on every machine.
pub struct Random(Xoshiro256PlusPlus);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// A number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }

    /// A number from `min` to `max`, both included.
    pub fn between(&mut self, min: usize, max: usize) -> usize {
        min + self.below(max - min + 1)
    }

    /// A real number from `min` to `max`.
    pub fn real(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// True with a probability of 1 in `n`.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// A grid with the paper's voxels.
pub fn frame(width: usize, height: usize) -> Frame {
    let (width, height) = (width as u32, height as u32);
    Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height }
}

/// The part that has a voxel wherever `filled` is true at x, y and z.
pub fn part_of(frame: Frame, depth: usize, filled: impl Fn([usize; 3]) -> bool) -> Arc<Voxels> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let material = |(z, y, x)| if filled([x, y, z]) { 0 } else { Voxels::EMPTY };
    Arc::new(Voxels::new(frame, Array3::from_shape_fn((depth, height, width), material)))
}

pub fn block(width: usize, height: usize, depth: usize) -> Arc<Voxels> {
    part_of(frame(width, height), depth, |_| true)
}

/// A full block, one with holes, islands, a pyramid, one that leans over its foot, or a table, each
/// of up to `max` voxels along x, y and z.
pub fn random_part(random: &mut Random, max: [usize; 3]) -> Arc<Voxels> {
    let [width, height, depth] = max.map(|n| random.between(n.div_ceil(3), n));
    let frame = frame(width, height);
    let gap = random.between(2, 5);
    match random.below(6) {
        0 => block(width, height, depth),
        1 => {
            let holes: Vec<bool> =
                (0..width * height * depth).map(|_| !random.one_in(gap)).collect();
            part_of(frame, depth, |[x, y, z]| {
                (x, y, z) == (0, 0, 0) || holes[(z * height + y) * width + x]
            })
        }
        2 => part_of(frame, depth, |[x, y, _]| x % gap != 1 && y % (gap + 2) != 1),
        3 => part_of(frame, depth, |[x, y, z]| {
            let inside = |i: usize, n: usize| i >= z.min((n - 1) / 2) && i + z.min((n - 1) / 2) < n;
            inside(x, width) && inside(y, height)
        }),
        4 => part_of(frame, depth, |[x, _, z]| x <= z + gap && x + 2 * gap >= z),
        // A table: a top on four legs.
        _ => part_of(frame, depth, |[x, y, z]| {
            z + 1 == depth || ((x < 2 || x + 2 >= width) && (y < 2 || y + 2 >= height))
        }),
    }
}

/// Properties of plastics, and a little beyond.
pub fn random_material(random: &mut Random) -> ThermalMaterial {
    ThermalMaterial {
        name: "random".into(),
        conductivity_w_mk: random.real(0.1, 0.5),
        specific_heat_j_kgk: random.real(1000.0, 2000.0),
        density_kg_m3: random.real(900.0, 1300.0),
        emissivity: random.real(0.0, 1.0),
        ..ThermalMaterial::abs()
    }
}

pub fn random_process(random: &mut Random) -> ProcessParameters {
    ProcessParameters {
        extrusion_c: random.real(180.0, 260.0),
        plate_c: (!random.one_in(3)).then(|| random.real(20.0, 120.0)),
        ambient_c: random.real(15.0, 60.0),
        convection_w_m2k: if random.one_in(4) { 0.0 } else { random.real(0.0, 60.0) },
        print_mm_s: random.real(20.0, 80.0),
        travel_mm_s: (!random.one_in(3)).then(|| random.real(100.0, 200.0)),
        surface_resistance: random.one_in(2),
    }
}

/// All cells of a layer: by a pattern, by lines that are not neighbours, or in any order.
pub fn random_order(random: &mut Random, part: &Voxels, layer: usize) -> Vec<Cell> {
    let mut order: Vec<Cell> = part.cells(layer).collect();
    let width = part.frame.width;
    match random.below(4) {
        0 => random.shuffle(&mut order),
        1 => {
            let apart = random.between(2, 7) as u32;
            order.sort_by_key(|cell| (cell / width % apart, cell / width, cell % width));
        }
        2 => {
            let apart = random.between(2, 7) as u32;
            order.sort_by_key(|cell| (cell % width % apart, cell % width, cell / width));
        }
        _ => {
            if let Ok(region) = part.region(layer) {
                order = Pattern::ALL[random.below(Pattern::COUNT)].order(&region);
            }
        }
    }
    order
}

/// The whole part, layer by layer.
pub fn random_events(
    random: &mut Random,
    part: &Voxels,
    process: &ProcessParameters,
) -> Vec<DepositionEvent> {
    let mut events = Vec::new();
    let mut last = None;
    for layer in 0..part.depth {
        let order = random_order(random, part, layer);
        events.extend(layer_events(&order, layer as u32, last, &part.frame, process));
        last = order.last().copied().or(last);
    }
    events
}

/// The same events with random pauses of up to `pause_s` between them, and other durations: a third
/// of them are multiplied by 0.1 to `max_factor`.
pub fn uneven(
    random: &mut Random,
    events: Vec<DepositionEvent>,
    pause_s: f64,
    max_factor: f64,
) -> Vec<DepositionEvent> {
    let mut uneven = Vec::with_capacity(events.len());
    for mut event in events {
        if random.one_in(40) {
            uneven.push(DepositionEvent::pause(random.real(0.0, pause_s)));
        }
        if random.one_in(3) {
            event.seconds *= random.real(0.1, max_factor);
        }
        uneven.push(event);
    }
    uneven
}

/// A part and its print.
pub struct Print {
    pub part: Arc<Voxels>,
    pub material: ThermalMaterial,
    pub process: ProcessParameters,
    pub events: Vec<DepositionEvent>,
}

impl Print {
    pub fn random(random: &mut Random, max: [usize; 3]) -> Self {
        let part = random_part(random, max);
        let (material, process) = (random_material(random), random_process(random));
        let events = random_events(random, &part, &process);
        Self { part, material, process, events }
    }

    /// A print with the paper's material and process.
    pub fn paper(random: &mut Random, part: Arc<Voxels>) -> Self {
        let (material, process) = (ThermalMaterial::abs(), ProcessParameters::default());
        let events = random_events(random, &part, &process);
        Self { part, material, process, events }
    }

    pub fn empty(&self, method: Method) -> Simulation {
        Simulation::new(self.part.clone(), &self.material, &self.process, method).unwrap()
    }

    pub fn run(&self, method: Method) -> Simulation {
        let mut simulation = self.empty(method);
        run(&mut simulation, &self.events);
        simulation
    }

    pub fn run_scalar(&self, scheme: Scheme) -> ScalarSolver {
        let mut solver =
            ScalarSolver::new(self.part.clone(), &self.material, &self.process, scheme).unwrap();
        solver.run(&self.events);
        solver
    }
}

/// Runs through valid events to their end.
pub fn run(simulation: &mut Simulation, events: &[DepositionEvent]) {
    simulation.run(events, &Control::default()).unwrap();
}

pub fn pause(simulation: &mut Simulation, seconds: f64) {
    simulation.pause(seconds, &Control::default()).unwrap();
}

/// x, y and z of all voxels of a part.
pub fn voxels(part: &Voxels) -> impl Iterator<Item = [u32; 3]> {
    let width = part.frame.width;
    (0..part.depth)
        .flat_map(move |z| part.cells(z).map(move |cell| [cell % width, cell / width, z as u32]))
}

/// The temperatures of all voxels, °C; NaN for those that are not deposited.
pub fn field(simulation: &Simulation) -> Vec<f64> {
    let part = simulation.part();
    voxels(part).map(|voxel| simulation.temperature_c(voxel).unwrap_or(f64::NAN)).collect()
}

/// The bits of [`field`].
pub fn bits(simulation: &Simulation) -> Vec<u64> {
    field(simulation).into_iter().map(f64::to_bits).collect()
}

pub fn scalar_field(part: &Voxels, solver: &ScalarSolver) -> Vec<f64> {
    voxels(part).map(|voxel| solver.temperature_c(voxel).unwrap_or(f64::NAN)).collect()
}

/// Difference between two fields.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    pub rms: f64,
    pub max: f64,
}

pub fn difference(a: &[f64], b: &[f64]) -> Difference {
    assert_eq!(a.len(), b.len());
    let (mut squares, mut max, mut count) = (0.0, 0.0f64, 0);
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.is_nan(), b.is_nan(), "a voxel is deposited in one field only");
        if !a.is_nan() {
            let distance = (a - b).abs();
            assert!(distance.is_finite(), "{a} and {b}");
            squares += distance * distance;
            max = max.max(distance);
            count += 1;
        }
    }
    Difference { rms: (squares / f64::from(count.max(1))).sqrt(), max }
}
