//! What the tests of the solver share: random parts, materials, processes and orders, and
//! comparisons.

#![allow(dead_code, reason = "no test uses all of it")]
#![allow(unreachable_pub, reason = "every test is a crate of its own")]
#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

use std::sync::Arc;

use beadwork_grid::Cell;
use beadwork_part::slice::Voxels;
use beadwork_part::{Frame, Pattern};
use beadwork_thermal::plain::{Plain, Scheme};
use beadwork_thermal::{Material, Method, Process, Simulation, Slot, layer_slots};
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

    pub fn between(&mut self, least: usize, most: usize) -> usize {
        least + self.below(most - least + 1)
    }

    /// A number from `least` to `most`.
    pub fn real(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// True once in `n` times.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// The paper's voxels.
pub fn frame(width: usize, height: usize) -> Frame {
    let (width, height) = (width as u32, height as u32);
    Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width, height }
}

/// The part that has a voxel wherever `filled` says so, at x, y and z.
pub fn part_of(frame: Frame, depth: usize, filled: impl Fn([usize; 3]) -> bool) -> Arc<Voxels> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let material = |(z, y, x)| if filled([x, y, z]) { 0 } else { Voxels::EMPTY };
    Arc::new(Voxels::new(frame, Array3::from_shape_fn((depth, height, width), material)))
}

pub fn block(width: usize, height: usize, depth: usize) -> Arc<Voxels> {
    part_of(frame(width, height), depth, |_| true)
}

/// A full block, one with holes, islands, a pyramid, or one that leans over its foot.
pub fn random_part(random: &mut Random, most: [usize; 3]) -> Arc<Voxels> {
    let [width, height, depth] = most.map(|n| random.between(n.div_ceil(3), n));
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
        // A table: a top that only its legs carry.
        _ => part_of(frame, depth, |[x, y, z]| {
            z + 1 == depth || ((x < 2 || x + 2 >= width) && (y < 2 || y + 2 >= height))
        }),
    }
}

/// Properties of plastics, and somewhat beyond.
pub fn random_material(random: &mut Random) -> Material {
    Material {
        name: "random".into(),
        conductivity_w_mk: random.real(0.1, 0.5),
        specific_heat_j_kgk: random.real(1000.0, 2000.0),
        density_kg_m3: random.real(900.0, 1300.0),
        emissivity: random.real(0.0, 1.0),
        ..Material::abs()
    }
}

pub fn random_process(random: &mut Random) -> Process {
    Process {
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
pub fn random_slots(random: &mut Random, part: &Voxels, process: &Process) -> Vec<Slot> {
    let mut slots = Vec::new();
    let mut last = None;
    for layer in 0..part.depth {
        let order = random_order(random, part, layer);
        slots.extend(layer_slots(&order, layer as u32, last, &part.frame, process));
        last = order.last().copied().or(last);
    }
    slots
}

/// The same with pauses of up to `pause_s` here and there, and slots of other lengths: up to
/// `stretch` times.
pub fn uneven(random: &mut Random, slots: Vec<Slot>, pause_s: f64, stretch: f64) -> Vec<Slot> {
    let mut uneven = Vec::with_capacity(slots.len());
    for mut slot in slots {
        if random.one_in(40) {
            uneven.push(Slot::pause(random.real(0.0, pause_s)));
        }
        if random.one_in(3) {
            slot.seconds *= random.real(0.1, stretch);
        }
        uneven.push(slot);
    }
    uneven
}

/// One part, its print and all that it depends on.
pub struct Print {
    pub part: Arc<Voxels>,
    pub material: Material,
    pub process: Process,
    pub slots: Vec<Slot>,
}

impl Print {
    pub fn random(random: &mut Random, most: [usize; 3]) -> Self {
        let part = random_part(random, most);
        let (material, process) = (random_material(random), random_process(random));
        let slots = random_slots(random, &part, &process);
        Self { part, material, process, slots }
    }

    /// As the paper prints.
    pub fn paper(random: &mut Random, part: Arc<Voxels>) -> Self {
        let (material, process) = (Material::abs(), Process::default());
        let slots = random_slots(random, &part, &process);
        Self { part, material, process, slots }
    }

    pub fn empty(&self, method: Method) -> Simulation {
        Simulation::new(self.part.clone(), &self.material, &self.process, method).unwrap()
    }

    pub fn run(&self, method: Method) -> Simulation {
        let mut simulation = self.empty(method);
        simulation.run(&self.slots).unwrap();
        simulation
    }

    pub fn run_plain(&self, scheme: Scheme) -> Plain {
        let mut plain =
            Plain::new(self.part.clone(), &self.material, &self.process, scheme).unwrap();
        plain.run(&self.slots);
        plain
    }
}

/// x, y and z of all voxels of a part.
pub fn voxels(part: &Voxels) -> impl Iterator<Item = [u32; 3]> {
    let width = part.frame.width;
    (0..part.depth)
        .flat_map(move |z| part.cells(z).map(move |cell| [cell % width, cell / width, z as u32]))
}

/// The temperatures of all voxels, °C; NaN for those not deposited.
pub fn field(simulation: &Simulation) -> Vec<f64> {
    let part = simulation.part();
    voxels(part).map(|voxel| simulation.temperature_c(voxel).unwrap_or(f64::NAN)).collect()
}

/// Their bits.
pub fn bits(simulation: &Simulation) -> Vec<u64> {
    field(simulation).into_iter().map(f64::to_bits).collect()
}

pub fn plain_field(part: &Voxels, plain: &Plain) -> Vec<f64> {
    voxels(part).map(|voxel| plain.temperature_c(voxel).unwrap_or(f64::NAN)).collect()
}

/// How two fields differ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    pub rms: f64,
    pub max: f64,
}

pub fn difference(a: &[f64], b: &[f64]) -> Difference {
    assert_eq!(a.len(), b.len());
    let (mut squares, mut max, mut count) = (0.0, 0.0f64, 0);
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.is_nan(), b.is_nan(), "one is deposited in one only");
        if !a.is_nan() {
            let gap = (a - b).abs();
            assert!(gap.is_finite(), "{a} and {b}");
            squares += gap * gap;
            max = max.max(gap);
            count += 1;
        }
    }
    Difference { rms: (squares / f64::from(count.max(1))).sqrt(), max }
}
