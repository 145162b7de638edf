//! How a line cools in a layer that is otherwise cold.

use std::sync::Arc;

use beadwork_base::Control;
use beadwork_grid::Cell;
use beadwork_part::Frame;
use beadwork_part::slice::Voxels;
use beadwork_thermal::event::layer_events;
use beadwork_thermal::simulation::{DepositError, Method};
use beadwork_thermal::{ProcessParameters, Simulation, ThermalMaterial};
use ndarray::Array3;

use super::BoundError;

/// Cells of the layers on each side of the line.
const MARGIN: u32 = 8;

/// Growth of the times between samples.
const GROWTH: f64 = 1.1;

/// Temperatures of the cells of a lone line: 0 is the temperature that they would have if the line
/// were as cold as the layer around it, and 1 that of the filament.
#[derive(Clone, Debug)]
pub(super) struct LoneLine {
    /// Times since the last cell was deposited, s, ascending from 0.
    times_s: Vec<f64>,
    /// The temperatures of all cells at each of the times.
    cells: Vec<Vec<f64>>,
}

/// What is around the line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pedestal {
    /// Layers below the line; 0 for a line on the plate.
    pub(super) layers: u32,
    /// Temperature of these and of the line's own layer when the line begins, °C.
    pub(super) celsius: f64,
}

impl LoneLine {
    /// Simulates a line of `length` cells for some seconds after its end.
    pub(super) fn simulate(
        length: u32,
        pedestal: Pedestal,
        (cell_mm, layer_mm, seconds): (f64, f64, f64),
        (material, process): (&ThermalMaterial, &ProcessParameters),
        method: Method,
        control: &Control<'_>,
    ) -> Result<Self, BoundError> {
        let (width, height) = (length + 2 * MARGIN, 2 * MARGIN + 1);
        let frame = Frame { left_mm: 0.0, back_mm: 0.0, cell_mm, layer_mm, width, height };
        let shape = [pedestal.layers + 1, height, width].map(|size| size as usize);
        let part = Arc::new(Voxels::new(frame, Array3::zeros(shape)));
        let all: Vec<Cell> = (0..width * height).collect();
        let first = MARGIN * width + MARGIN;
        let (cells, around): (Vec<Cell>, Vec<Cell>) =
            all.iter().partition(|&&cell| (first..first + length).contains(&cell));
        let events =
            |cells: &[Cell]| layer_events(cells, pedestal.layers, None, &part.frame, process);
        let mut line = Simulation::new(part.clone(), material, process, method)?;
        for layer in 0..pedestal.layers {
            line.deposit(layer, &all, control)?;
        }
        line.run(&events(&around), control)?;
        let mut bare = line.clone();
        bare.run(&events(&cells), control)?;
        let celsius = Array3::from_elem(shape, pedestal.celsius);
        for simulation in [&mut line, &mut bare] {
            simulation
                .set_temperatures_c(celsius.view())
                .expect("temperatures of plates and prints are in range");
        }
        line.run(&events(&cells), control)?;
        let cell_s = cell_mm / process.print_mm_s;
        bare.pause(f64::from(length) * cell_s, control).map_err(DepositError::from)?;
        let end = bare.temperature_c([MARGIN, MARGIN, pedestal.layers]);
        let scale = process.extrusion_c - end.expect("the cell is deposited");
        let relative = |line: &Simulation, bare: &Simulation| -> Vec<f64> {
            let cell = |cell: u32| {
                let voxel = [MARGIN + cell, MARGIN, pedestal.layers];
                let temperatures = line.temperature_c(voxel).zip(bare.temperature_c(voxel));
                let (own, bare) = temperatures.expect("both are deposited");
                (own - bare) / scale
            };
            (0..length).map(cell).collect()
        };
        let mut times_s = vec![0.0];
        let mut cells = vec![relative(&line, &bare)];
        let mut now = 0.0;
        while now < seconds {
            let next = f64::max(now + cell_s, now * GROWTH);
            for simulation in [&mut line, &mut bare] {
                simulation.pause(next - now, control).map_err(DepositError::from)?;
            }
            now = next;
            times_s.push(now);
            cells.push(relative(&line, &bare));
        }
        Ok(Self { times_s, cells })
    }

    /// The relative temperatures of all cells at a time after the line's end, s, by linear
    /// interpolation; after the last sample, those of the last sample.
    pub(super) fn at(&self, time_s: f64) -> impl Iterator<Item = f64> {
        let after = self.times_s.partition_point(|&time| time <= time_s);
        let (from, to) = (after.saturating_sub(1), after.min(self.times_s.len() - 1));
        let span = self.times_s[to] - self.times_s[from];
        let share = if span > 0.0 { (time_s - self.times_s[from]) / span } else { 0.0 };
        self.cells[from].iter().zip(&self.cells[to]).map(move |(a, b)| a + share * (b - a))
    }
}
