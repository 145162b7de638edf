//! A limit on how even any order can be, by an argument.
//!
//! The deviation of temperatures at a layer's end has two parts: that between layers, and that
//! within layers.
//!
//! 1. **Layer means hardly depend on the order**, as the same heat is brought in the same time.
//!    So the deviation between layers is that of the conventional order.
//! 2. **Every line is at least as warm as a lone one** of the same age, in a layer that is
//!    otherwise complete and everywhere as cold as its coldest voxel: by superposition, the heat of
//!    the other lines only adds to it.
//!    Whatever the order, some line was printed last, one before it, and so on, so the ages are
//!    known.
//! 3. **All other heat is taken as spread evenly**: the smallest deviation of the layer's
//!    temperatures that have its mean and are nowhere below those of lone lines; and none within
//!    the layers below.
//!
//! With lines of one cell, this is a limit for any order of cells; with lines as long as the
//! layer's, for orders of whole lines.
//!
//! It is an argument and no proof: the first step is an observation, and lines with other lengths
//! than the mean are not treated.
//! It holds for prints in which travel takes no time; waiting makes any print more even.

mod floor;
mod lone_line;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Region;
use beadwork_part::slice::Voxels;
use beadwork_part::{Axis, Corner, LineOrder, Order, Sequence};
use beadwork_thermal::simulation::{DepositError, Method, SetupError};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use thiserror::Error;

use self::floor::min_squares;
use self::lone_line::{LoneLine, Pedestal};
use crate::fill::{Cells, CellsError};

/// Maximum number of layers below a lone line: 2 mm of layers of 0.25 mm.
const MAX_PEDESTAL: u32 = 8;

/// Deviations at the end of each layer in a print without travel, K; 0 for layers without cells.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatBound {
    /// What any order of cells is expected to reach at best.
    pub any_order_std_c: Vec<f64>,
    /// What any order of whole lines is expected to reach at best.
    pub whole_lines_std_c: Vec<f64>,
    /// What the conventional order reaches.
    pub conventional_std_c: Vec<f64>,
}

/// Error of [`heat_bound`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BoundError {
    /// The print cannot be simulated.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A layer is not a valid region.
    #[error(transparent)]
    Cells(#[from] CellsError),
    /// A layer cannot be deposited, or the call was interrupted.
    #[error(transparent)]
    Deposit(#[from] DepositError),
}

impl HeatBound {
    /// Limit on the gain of the reward without travel for any order, in % of that of the
    /// conventional order; `None` if that has no deviation.
    pub fn any_order_percent(&self) -> Option<f64> {
        self.percent(&self.any_order_std_c)
    }

    /// The same for orders of whole lines.
    pub fn whole_lines_percent(&self) -> Option<f64> {
        self.percent(&self.whole_lines_std_c)
    }

    fn percent(&self, bound: &[f64]) -> Option<f64> {
        let sum = |std_c: &[f64]| std_c.iter().fold(0.0, |sum, std_c| sum + std_c);
        let conventional = sum(&self.conventional_std_c);
        (conventional > 0.0).then(|| 100.0 * (1.0 - sum(bound) / conventional))
    }
}

/// What is known of a layer at its end in the conventional order.
struct LayerEnd {
    /// Number and mean temperature, °C, of the voxels of this layer.
    own: (f64, f64),
    /// Mean over all voxels, °C, and the sum of the squared differences of the means of the layers
    /// below from it, K².
    mean_c: f64,
    squares_below: f64,
    /// Lowest temperature of this layer and the layer below, at the start and at the end, °C; the
    /// plate is below the first layer.
    floor_c: f64,
    std_c: f64,
    /// Mean lengths of its lines along x and y, in cells, at least 1.
    lines: [u32; 2],
}

/// Estimates how even the layers of a part can be at their ends, if travel takes no time.
///
/// Simulates the print in the conventional order once, and a few lone lines.
/// Progress counts layers.
///
/// # Errors
/// If the print cannot be simulated, or the call is interrupted.
pub fn heat_bound(
    part: &Arc<Voxels>,
    material: &ThermalMaterial,
    process: &ProcessParameters,
    method: Method,
    control: &Control<'_>,
) -> Result<HeatBound, BoundError> {
    let process = ProcessParameters { travel_mm_s: None, ..process.clone() };
    let own = control.without_progress();
    let mut print = Simulation::new(part.clone(), material, &process, method)?;
    let mut ends = Vec::with_capacity(part.depth);
    let cells = Cells::new(part, &process)?;
    for layer in 0..part.depth {
        control.report(layer, part.depth);
        let region = cells.region(layer as u32);
        let end = region.map(|region| conventional_end(&mut print, layer, region, &own));
        ends.push(end.transpose()?);
    }
    let floors: Vec<f64> = ends.iter().flatten().map(|end| end.floor_c).collect();
    let celsius = floors.iter().sum::<f64>() / (floors.len() as f64).max(1.0);
    let cell_s = part.frame.cell_mm / process.print_mm_s;
    let longest = ends.iter().flatten().map(|end| end.own.0).fold(0.0, f64::max) * cell_s;

    // Layers of the same length of lines share a simulation.
    let pedestal = |layer: usize| (layer as u32).min(MAX_PEDESTAL);
    let filled = ends.iter().enumerate().filter_map(|(layer, end)| Some((layer, end.as_ref()?)));
    let kinds = filled.flat_map(|(layer, end)| {
        let [x, y] = end.lines;
        [1, x, y].map(|length| (pedestal(layer), length))
    });
    let kinds: Vec<(u32, u32)> = kinds.collect::<BTreeSet<_>>().into_iter().collect();
    let simulated = own.threads.map(&kinds, |&(layers, length)| {
        let sizes = (part.frame.cell_mm, part.frame.layer_mm, longest);
        let pedestal = Pedestal { layers, celsius };
        let own = own.on_one_thread();
        LoneLine::simulate(length, pedestal, sizes, (material, &process), method, &own)
    });
    let simulated = simulated.into_iter().collect::<Result<Vec<_>, _>>()?;
    let lines: BTreeMap<(u32, u32), LoneLine> = kinds.into_iter().zip(simulated).collect();

    let bound_of = |layer: usize, end: &LayerEnd, length: u32| {
        let line = &lines[&(pedestal(layer), length)];
        let scale = process.extrusion_c - end.floor_c;
        let count = end.own.0 as usize;
        let mut floors = Vec::with_capacity(count + length as usize);
        let mut age_s = 0.0;
        while floors.len() < count {
            floors.extend(line.at(age_s).map(|relative| end.floor_c + relative * scale));
            age_s += f64::from(length) * cell_s;
        }
        floors.truncate(count);
        let within = min_squares(&mut floors, end.own.1);
        let between = (end.own.1 - end.mean_c).powi(2) * end.own.0;
        let total = ends[..=layer].iter().flatten().map(|end| end.own.0).sum::<f64>();
        ((within + between + end.squares_below) / total).sqrt()
    };
    let bounds = own.threads.map_numbers(part.depth, |layer| match &ends[layer] {
        None => (0.0, 0.0),
        Some(end) => {
            let [x, y] = end.lines.map(|length| bound_of(layer, end, length));
            (bound_of(layer, end, 1), x.min(y))
        }
    });
    let conventional = ends.iter().map(|end| end.as_ref().map_or(0.0, |end| end.std_c));
    Ok(HeatBound {
        any_order_std_c: bounds.iter().map(|bound| bound.0).collect(),
        whole_lines_std_c: bounds.iter().map(|bound| bound.1).collect(),
        conventional_std_c: conventional.collect(),
    })
}

/// Deposits a layer in the conventional order.
fn conventional_end(
    print: &mut Simulation,
    layer: usize,
    region: &Region,
    control: &Control<'_>,
) -> Result<LayerEnd, DepositError> {
    let plate_c = print.process().plate_c.unwrap_or(print.process().ambient_c);
    let below = layer.checked_sub(1).map(|below| below as u32);
    let lower = if layer == 0 { plate_c } else { f64::INFINITY };
    let coldest = |print: &Simulation| {
        let layers = [below, Some(layer as u32)].into_iter().flatten();
        let statistics = layers.filter_map(|layer| print.layer_statistics(layer));
        statistics.map(|layer| layer.min_c).fold(lower, f64::min)
    };
    let before = coldest(print);
    print.deposit(layer as u32, &Order::CONVENTIONAL.order(region), control)?;
    let floor_c = before.min(coldest(print));
    let all = print.statistics().expect("the layer has cells");
    let of = |layer: usize| print.layer_statistics(layer as u32);
    let squares = |layer: usize| {
        of(layer).map_or(0.0, |own| own.count as f64 * (own.mean_c - all.mean_c).powi(2))
    };
    let own = of(layer).expect("the layer has cells");
    Ok(LayerEnd {
        own: (own.count as f64, own.mean_c),
        mean_c: all.mean_c,
        squares_below: (0..layer).map(squares).sum(),
        floor_c,
        std_c: all.std_c,
        lines: [Axis::X, Axis::Y].map(|axis| mean_line(region, axis)),
    })
}

/// Mean length of the lines of a layer along an axis, in cells, at least 1.
fn mean_line(region: &Region, axis: Axis) -> u32 {
    let order = LineOrder { sequence: Sequence::Sequential, axis, corner: Corner::MinXMinY };
    let (cells, lines) = (region.cell_count(), order.lines(region).len() as u32);
    (cells + lines / 2) / lines
}

#[cfg(test)]
mod tests;
