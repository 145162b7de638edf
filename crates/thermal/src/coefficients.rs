//! Coefficients of the discrete heat equation.
//!
//! The solver uses the standard seven-point finite-volume stencil on a grid of equal cuboid voxels.
//! Only voxels that are already deposited take part (element birth): a voxel exchanges heat with
//! its active neighbours, with the build plate and, through all other faces, with the air.
//! Everything that does not depend on the temperature is computed once, in double precision, and
//! stored here in single precision.
//!
//! **Why single precision.**
//! A sweep is limited by loads, and `f32` fits twice as many voxels into a register and a cache
//! line as `f64`.
//! Temperatures are stored relative to the air and stay below a few hundred kelvin, so one unit in
//! the last place is about 1.5e-5 K, far below the error of the discretisation.

use crate::material::ThermalMaterial;
use crate::process::ProcessParameters;
use crate::property::ZERO_CELSIUS_K;

/// Stefan-Boltzmann constant, W/(m² K⁴), rounded as in the paper (Kim et al. 2026).
pub(crate) const STEFAN_BOLTZMANN: f64 = 5.67e-8;

/// The faces of a voxel as bits of one byte.
///
/// A bit for one of the six faces is set if the voxel behind it is active, so that the face
/// conducts.
pub(crate) mod face {
    /// The faces towards smaller x, larger x, smaller y and larger y.
    pub(crate) const SIDES: [u8; 4] = [1, 2, 4, 8];
    /// The face towards the layer below.
    pub(crate) const BELOW: u8 = 16;
    /// The face towards the layer above.
    pub(crate) const ABOVE: u8 = 32;
    /// All six neighbours are active.
    pub(crate) const ALL: u8 = 63;
    /// The voxel and its six neighbours are active: no surface anywhere.
    pub(crate) const INTERIOR: u8 = ALL | ACTIVE;
    /// The lower face lies on the build plate.
    pub(crate) const PLATE: u8 = 64;
    /// The voxel itself is active.
    pub(crate) const ACTIVE: u8 = 128;
}

/// Coefficients of the semi-discrete heat equation, for every combination of covered faces.
///
/// With θ the temperature above the air, the rate of change of an active voxel is
///
/// ```text
/// dθ/dt = lateral · Σ θ(4 sides) + vertical · Σ θ(below, above)
///         + (diagonal - exposed_area · radiation(θ)) · θ
/// ```
///
/// where both sums run over *all* neighbours, active or not.
/// Two choices make that possible without a branch per neighbour:
///
/// - An inactive voxel has θ = 0, so it adds nothing to the sum; and the diagonal of the voxel does
///   not contain the conductance towards it.
///   Together this is exactly a face without conduction.
/// - The build plate lies half a voxel below the centres of the lowest layer.
///   The usual ghost value for such a Dirichlet boundary is 2 θ(plate) - θ.
///   Its constant part, 2 θ(plate), is stored in a layer of ghost voxels.
///   Its other part, -θ, adds a second `vertical` to the diagonal, as if the plate conducted twice
///   as well as a neighbour.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Coefficients {
    /// Conductance to each neighbour in the same layer, 1/s.
    pub(crate) lateral: f32,
    /// Conductance to the neighbour below and to the one above, 1/s.
    pub(crate) vertical: f32,
    /// Radiative heat transfer coefficient, W/(m² K), as a cubic polynomial in θ: coefficients of
    /// θ⁰ to θ³.
    ///
    /// Equals T⁴ - T(air)⁴ divided by θ = T - T(air), times emissivity and the Stefan-Boltzmann
    /// constant, so it is exact.
    pub(crate) radiation: [f32; 4],
    /// Coefficients of a voxel, indexed by its byte of [`face`] bits.
    pub(crate) by_faces: Box<[VoxelCoefficients; 256]>,
    /// Whether the build plate exchanges heat with layer 0.
    pub(crate) plate_conducts: bool,
    /// Value of the ghost voxels below layer 0: twice the plate's θ, or 0 if it does not conduct,
    /// K.
    pub(crate) plate_ghost: f32,
    /// θ at which a voxel is deposited and held, K.
    pub(crate) birth_theta: f32,
    /// Temperature of the air, °C, where θ = 0.
    pub(crate) ambient_c: f64,
    /// Convective heat transfer coefficient, W/(m² K).
    pub(crate) convection: f32,
    /// Area of one side, and of the top or the bottom, divided by a voxel's heat capacity, m² K/J.
    pub(crate) face_area: [f32; 2],
    /// Resistance of the half voxel behind a surface, if the process takes it into account.
    pub(crate) resistance: Option<SurfaceResistance>,
    /// Upper bound on the decay rates of the equation, 1/s (Gershgorin): forward Euler is stable
    /// for steps of up to 2 / `max_rate`.
    pub(crate) max_rate: f64,
}

/// Thermal resistance between a voxel's centre and its surfaces: distance over conductivity d / k.
///
/// A surface with the heat transfer coefficient h then has the effective coefficient h / (1 + h d /
/// k).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SurfaceResistance {
    /// For the four sides, m² K/W.
    pub(crate) side: f32,
    /// For top and bottom, m² K/W.
    pub(crate) top_bottom: f32,
}

/// Coefficients of one voxel, given which of its faces are covered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct VoxelCoefficients {
    /// Coefficient of the voxel's own θ, 1/s: minus its conductances and, without surface
    /// resistance, minus convection.
    /// Negative for an active voxel; 0 marks an inactive one.
    pub(crate) diagonal: f32,
    /// Area exposed to the air divided by the voxel's heat capacity, m² K/J.
    /// With surface resistance, only that of the four sides.
    pub(crate) exposed_area: f32,
    /// With surface resistance, the same for top and bottom, which have another resistance than the
    /// sides; otherwise 0.
    pub(crate) top_bottom_area: f32,
}

/// Diagonal of an active voxel without any exchange of heat.
///
/// Too small to change a temperature, but not 0, which would mark the voxel as inactive.
const ISOLATED: f32 = -1e-30;

/// Rounds both conductances so that every sum of conductances of one voxel is exact in single
/// precision.
///
/// Both become multiples of one power of two, chosen such that even four lateral and four vertical
/// conductances together are at most 2²⁴ times as large: then no sum needs more than the 24 bits of
/// an `f32`.
/// The relative change is about 1e-7.
///
/// Without this, the diagonal of a voxel would differ in its last digit from the sum of what its
/// neighbours receive.
/// That would be a small heat source in every voxel and every step, and over the hundred thousand
/// steps of a print it would add up.
fn round_for_exact_sums(conductances: [f64; 2]) -> [f64; 2] {
    let [lateral, vertical] = conductances;
    let max_sum = 4.0 * lateral + 4.0 * vertical;
    let quantum = (max_sum.log2().ceil() - f64::from(f32::MANTISSA_DIGITS)).exp2();
    conductances.map(|conductance| (conductance / quantum).round() * quantum)
}

impl Coefficients {
    /// Coefficients for voxels of a width (along x and y) and a height in metres.
    pub(crate) fn new(
        material: &ThermalMaterial,
        process: &ProcessParameters,
        width_m: f64,
        height_m: f64,
    ) -> Self {
        let capacity = material.heat_capacity_j_m3k();
        let conductance = |length_m: f64| material.diffusivity_m2_s() / length_m.powi(2);
        let [lateral, vertical] =
            round_for_exact_sums([conductance(width_m), conductance(height_m)]);
        let air_k = process.ambient_c + ZERO_CELSIUS_K;
        let grey = material.emissivity * STEFAN_BOLTZMANN;
        let plate_theta = process.plate_c.map(|plate_c| plate_c - process.ambient_c);
        let hottest_c = process.extrusion_c.max(process.plate_c.unwrap_or(process.ambient_c));
        let hottest_k = hottest_c.max(process.ambient_c) + ZERO_CELSIUS_K;
        let h = process.convection_w_m2k;
        let mut max_rate: f64 = 0.0;
        let mut by_faces = Box::new([VoxelCoefficients::default(); 256]);
        for (faces, voxel) in (0u8..=255).zip(by_faces.iter_mut()) {
            let on_plate = faces & face::PLATE != 0;
            // Two kinds of bytes never occur and keep the default: an inactive voxel, and one with
            // both the plate and another voxel below it.
            if faces & face::ACTIVE == 0 || on_plate && faces & face::BELOW != 0 {
                continue;
            }
            let sides = face::SIDES.iter().filter(|&&side| faces & side != 0).count() as f64;
            let top_bottom =
                f64::from(u8::from(faces & face::BELOW != 0) + u8::from(faces & face::ABOVE != 0));
            // The plate is half a voxel away, so it conducts twice as well as a neighbour.
            let plate = if on_plate && plate_theta.is_some() { 2.0 } else { 0.0 };
            let exposed_sides = (4.0 - sides) / width_m / capacity;
            let exposed_top_bottom =
                (2.0 - top_bottom - f64::from(u8::from(on_plate))) / height_m / capacity;
            let conduction = sides * lateral + (top_bottom + plate) * vertical;
            // Without surface resistance, convection is linear in θ and belongs to the diagonal.
            // With it, convection and radiation pass the resistance together, which is not linear.
            let decay = if process.surface_resistance {
                *voxel = VoxelCoefficients {
                    diagonal: 0.0,
                    exposed_area: exposed_sides as f32,
                    top_bottom_area: exposed_top_bottom as f32,
                };
                conduction
            } else {
                let exposed = exposed_sides + exposed_top_bottom;
                *voxel = VoxelCoefficients {
                    diagonal: 0.0,
                    exposed_area: exposed as f32,
                    top_bottom_area: 0.0,
                };
                conduction + h * exposed
            };
            voxel.diagonal = ISOLATED.min(-decay as f32);
            // Gershgorin's circle theorem: no eigenvalue of the Jacobian is larger in magnitude
            // than the maximum, over all rows, of the sum of the row's absolute coefficients.
            // The slope of radiation, 4 ε σ T³ for each area, is largest at the hottest
            // temperature.
            let loss_slope =
                (h + 4.0 * grey * hottest_k.powi(3)) * (exposed_sides + exposed_top_bottom);
            let off_diagonal = sides * lateral + top_bottom * vertical;
            max_rate = max_rate.max(conduction + off_diagonal + loss_slope);
        }
        let half_resistance = |length_m: f64| (length_m / 2.0 / material.conductivity_w_mk) as f32;
        Self {
            lateral: lateral as f32,
            vertical: vertical as f32,
            radiation: [4.0 * air_k.powi(3), 6.0 * air_k.powi(2), 4.0 * air_k, 1.0]
                .map(|power| (grey * power) as f32),
            by_faces,
            plate_conducts: plate_theta.is_some(),
            plate_ghost: 2.0 * plate_theta.unwrap_or(0.0) as f32,
            birth_theta: (process.extrusion_c - process.ambient_c) as f32,
            ambient_c: process.ambient_c,
            convection: h as f32,
            face_area: [1.0 / width_m / capacity, 1.0 / height_m / capacity]
                .map(|area| area as f32),
            resistance: process.surface_resistance.then(|| SurfaceResistance {
                side: half_resistance(width_m),
                top_bottom: half_resistance(height_m),
            }),
            max_rate,
        }
    }

    /// Heat that a voxel loses to the air by convection and radiation, K/s, given its θ and its
    /// exposed areas.
    ///
    /// The sweeps compute the same with convection in the diagonal (`kernel/equation.rs`).
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled for the vector width of the caller")]
    pub(crate) fn surface_loss(&self, theta: f32, exposed_area: f32, top_bottom_area: f32) -> f32 {
        let [r0, r1, r2, r3] = self.radiation;
        let h = ((r3 * theta + r2) * theta + r1) * theta + r0 + self.convection;
        let passed = match self.resistance {
            None => h * exposed_area,
            Some(SurfaceResistance { side, top_bottom }) => {
                h / (1.0 + h * side) * exposed_area + h / (1.0 + h * top_bottom) * top_bottom_area
            }
        };
        passed * theta
    }

    /// Derivative of surface heat loss with respect to temperature at θ, 1/s, for a number of
    /// exposed sides and of exposed tops and bottoms.
    pub(crate) fn surface_loss_slope(&self, theta: f32, sides: f32, tops_bottoms: f32) -> f32 {
        let [side_area, top_bottom_area] = self.face_area;
        let [r0, r1, r2, r3] = self.radiation;
        let h = self.convection + ((4.0 * r3 * theta + 3.0 * r2) * theta + 2.0 * r1) * theta + r0;
        let SurfaceResistance { side, top_bottom } = self.resistance.unwrap_or_default();
        h / (1.0 + h * side) * side_area * sides
            + h / (1.0 + h * top_bottom) * top_bottom_area * tops_bottoms
    }

    /// Conductance to the next voxel along an axis (0, 1, 2 for x, y, z), 1/s.
    pub(crate) fn conductance(&self, axis: usize) -> f32 {
        if axis == 2 { self.vertical } else { self.lateral }
    }

    /// The diagonal of a voxel without the conduction to one of its neighbours along an axis.
    pub(crate) fn without_neighbour(&self, diagonal: f32, axis: usize) -> f32 {
        (diagonal + self.conductance(axis)).min(ISOLATED)
    }
}
