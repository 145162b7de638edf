//! The heat equation of one voxel, as numbers.

use crate::material::Material;
use crate::process::Process;
use crate::property::ZERO_CELSIUS_K;

/// Stefan and Boltzmann's constant, W/(m² K⁴), as the paper gives it.
pub(crate) const STEFAN_BOLTZMANN: f64 = 5.67e-8;

/// The six faces of a voxel, as bits: set where heat is conducted to an active neighbour.
pub(crate) mod face {
    /// Towards less x, more x, less y, more y.
    pub(crate) const SIDES: [u8; 4] = [1, 2, 4, 8];
    /// Towards the layer below.
    pub(crate) const BELOW: u8 = 16;
    /// Towards the layer above.
    pub(crate) const ABOVE: u8 = 32;
    /// All neighbours are active.
    pub(crate) const ALL: u8 = 63;
    /// The voxel is active and all its neighbours.
    pub(crate) const INTERIOR: u8 = ALL | ACTIVE;
    /// The lower face lies on the build plate.
    pub(crate) const PLATE: u8 = 64;
    /// The voxel itself is active.
    pub(crate) const ACTIVE: u8 = 128;
}

/// What one voxel gains and loses, for each way its faces can be covered.
///
/// With θ the temperature above that of the air, g the conductances and Σ over *all* six
/// neighbours, of which inactive ones hold 0:
///
/// dθ/dt = `lateral` Σ θ(sides) + `vertical` Σ θ(below, above) - (`damping` + `exposure` ·
/// radiation(θ)) θ
///
/// So a missing neighbour needs no test: it adds nothing, and the damping of the voxel lacks its
/// conductance.
/// The build plate, half a voxel below the centre, is a layer of ghosts that hold twice the plate's
/// θ, and a damping of twice the vertical conductance.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Law {
    /// Conductance to a neighbour in the layer, 1/s.
    pub(crate) lateral: f32,
    /// Conductance to a neighbour below or above, 1/s.
    pub(crate) vertical: f32,
    /// Radiation, W/(m² K), is a cubic polynomial of θ, by rising powers.
    pub(crate) radiation: [f32; 4],
    /// For each set of faces.
    pub(crate) voxels: Box<[Voxel; 256]>,
    /// Whether the build plate takes up heat.
    pub(crate) plate: bool,
    /// θ of the build plate's ghosts: twice the plate's.
    pub(crate) ghost: f32,
    /// θ of a voxel at birth.
    pub(crate) birth: f32,
    /// The air, °C: where θ is 0.
    pub(crate) ambient_c: f64,
    /// Convection, W/(m² K), and the area of a side and of top or bottom by the heat capacity of a
    /// voxel, m² K/J.
    pub(crate) air: [f32; 3],
    /// If a surface passes h / (1 + h d / k): convection in W/(m² K), and d / k of the sides and of
    /// top and bottom.
    pub(crate) resistance: Option<[f32; 3]>,
    /// The largest rate at which differences can die out, 1/s.
    pub(crate) fastest: f64,
}

/// The numbers of a voxel with some of its faces covered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Voxel {
    /// Rate at which the voxel's own θ counts against it, 1/s, negative; 0 stands for "not active".
    pub(crate) damping: f32,
    /// Area open to the air by heat capacity, m² K/J; with surface resistance that of the sides
    /// alone.
    pub(crate) exposure: f32,
    /// With surface resistance, area of top and bottom open to the air by heat capacity, m² K/J;
    /// else 0.
    pub(crate) caps: f32,
}

/// Stands for "active, but nothing to exchange heat with": so small that it changes nothing, but
/// not 0.
const ISOLATED: f32 = -1e-30;

/// The same conductances but for the seventh digit, so that any sum of those of a voxel is exact in
/// single precision.
///
/// Otherwise what a voxel gives to its neighbours differs, in the last digit, from what its damping
/// takes off it: over the hundred thousand steps of a print, heat would come from nowhere.
fn summable(conductances: [f64; 2]) -> [f64; 2] {
    let [lateral, vertical] = conductances;
    let most = 4.0 * lateral + 4.0 * vertical;
    let quantum = (most.log2().ceil() - f64::from(f32::MANTISSA_DIGITS)).exp2();
    conductances.map(|conductance| (conductance / quantum).round() * quantum)
}

impl Law {
    /// For voxels of a width and a height in metres.
    pub(crate) fn new(material: &Material, process: &Process, width_m: f64, height_m: f64) -> Self {
        let capacity = material.heat_capacity_j_m3k();
        let conductance = |length_m: f64| material.diffusivity_m2_s() / length_m.powi(2);
        let [lateral, vertical] = summable([conductance(width_m), conductance(height_m)]);
        let air_k = process.ambient_c + ZERO_CELSIUS_K;
        let grey = material.emissivity * STEFAN_BOLTZMANN;
        let plate = process.plate_c.map(|plate| plate - process.ambient_c);
        let hottest = process.extrusion_c.max(process.plate_c.unwrap_or(process.ambient_c));
        let hottest_k = hottest.max(process.ambient_c) + ZERO_CELSIUS_K;
        let h = process.convection_w_m2k;
        let mut fastest: f64 = 0.0;
        let mut voxels = Box::new([Voxel::default(); 256]);
        for (faces, voxel) in (0u8..=255).zip(voxels.iter_mut()) {
            if faces & face::ACTIVE == 0
                || faces & (face::PLATE | face::BELOW) == face::PLATE | face::BELOW
            {
                continue;
            }
            let on_plate = faces & face::PLATE != 0;
            let sides = face::SIDES.iter().filter(|&&side| faces & side != 0).count() as f64;
            let caps =
                f64::from(u8::from(faces & face::BELOW != 0) + u8::from(faces & face::ABOVE != 0));
            let touch = if on_plate && plate.is_some() { 2.0 } else { 0.0 };
            let open_sides = (4.0 - sides) / width_m / capacity;
            let open_caps = (2.0 - caps - f64::from(u8::from(on_plate))) / height_m / capacity;
            let conduction = sides * lateral + (caps + touch) * vertical;
            // All of the air's losses are in the damping, or, with resistance, all of them outside.
            let damping = if process.surface_resistance {
                *voxel =
                    Voxel { damping: 0.0, exposure: open_sides as f32, caps: open_caps as f32 };
                conduction
            } else {
                let open = open_sides + open_caps;
                *voxel = Voxel { damping: 0.0, exposure: open as f32, caps: 0.0 };
                conduction + h * open
            };
            voxel.damping = ISOLATED.min(-damping as f32);
            // Gershgorin's disc; at the hottest, a surface radiates 4 ε σ T³ a kelvin.
            let loss = (h + 4.0 * grey * hottest_k.powi(3)) * (open_sides + open_caps);
            let others = sides * lateral + caps * vertical;
            fastest = fastest.max(conduction + others + loss);
        }
        let half_k = |length: f64| (length / 2.0 / material.conductivity_w_mk) as f32;
        Self {
            lateral: lateral as f32,
            vertical: vertical as f32,
            radiation: [4.0 * air_k.powi(3), 6.0 * air_k.powi(2), 4.0 * air_k, 1.0]
                .map(|power| (grey * power) as f32),
            voxels,
            plate: plate.is_some(),
            ghost: 2.0 * plate.unwrap_or(0.0) as f32,
            birth: (process.extrusion_c - process.ambient_c) as f32,
            ambient_c: process.ambient_c,
            air: [h, 1.0 / width_m / capacity, 1.0 / height_m / capacity]
                .map(|number| number as f32),
            resistance: process
                .surface_resistance
                .then(|| [h as f32, half_k(width_m), half_k(height_m)]),
            fastest,
        }
    }

    /// What a voxel at a temperature loses to the air, K/s, given its exposure and its caps.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "to be compiled for the lanes of the processor")]
    pub(crate) fn lost(&self, theta: f32, exposure: f32, caps: f32) -> f32 {
        let [r0, r1, r2, r3] = self.radiation;
        let h = ((r3 * theta + r2) * theta + r1) * theta + r0 + self.air[0];
        let passed = match self.resistance {
            None => h * exposure,
            Some([_, side, cap]) => h / (1.0 + h * side) * exposure + h / (1.0 + h * cap) * caps,
        };
        passed * theta
    }

    /// What surfaces at a temperature lose for each kelvin more, 1/s: so many sides, tops and
    /// bottoms of voxels.
    pub(crate) fn air_loss(&self, theta: f32, sides: f32, caps: f32) -> f32 {
        let [convection, side, cap] = self.air;
        let [r0, r1, r2, r3] = self.radiation;
        let h = convection + ((4.0 * r3 * theta + 3.0 * r2) * theta + 2.0 * r1) * theta + r0;
        let [behind_side, behind_cap] =
            self.resistance.map_or([0.0; 2], |[_, side, cap]| [side, cap]);
        h / (1.0 + h * behind_side) * side * sides + h / (1.0 + h * behind_cap) * cap * caps
    }

    /// The conductance to the next voxel along an axis, 1/s.
    pub(crate) fn conductance(&self, axis: usize) -> f32 {
        if axis == 2 { self.vertical } else { self.lateral }
    }

    /// The damping of a voxel with one neighbour less along an axis.
    pub(crate) fn closed(&self, damping: f32, axis: usize) -> f32 {
        (damping + self.conductance(axis)).min(ISOLATED)
    }
}
