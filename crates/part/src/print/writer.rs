//! Writes toolpaths as G-code commands, with tool changes and the prime tower between them.
//!
//! Cells and beads reach the writer as toolpaths.
//! Each piece of a path through cells is one bead with constant flow per length; it runs from the
//! outer edge of its first cell through the centres of the cells to the outer edge of its last one.
//! Where the zone changes within a piece, the old tool stops at the edge between the two cells, and
//! the new tool continues from there after a tool change.

use beadwork_gcode::{Feature, Line};

use super::machine::Machine;
use super::prime_tower::PrimeTowerPlan;
use super::settings::Settings;
use super::toolpath::Toolpath;
use crate::Frame;

/// The printer, and what its layers have in common.
pub(super) struct Writer<'a> {
    frame: &'a Frame,
    settings: &'a Settings,
    machine: Machine<'a>,
}

impl<'a> Writer<'a> {
    /// A writer at the start of a file; `tool` prints first.
    pub(super) fn new(
        frame: &'a Frame,
        settings: &'a Settings,
        tool: u8,
        used_tools: Vec<u8>,
    ) -> Self {
        Self { frame, settings, machine: Machine::new(settings, tool, used_tools) }
    }

    pub(super) fn into_lines(self) -> Vec<Line> {
        self.machine.into_lines()
    }

    /// Writes what precedes the first layer.
    pub(super) fn start(&mut self) {
        self.machine.start();
    }

    /// Writes what follows the last layer.
    pub(super) fn end(&mut self) {
        self.machine.end();
    }

    /// Writes a layer: first the outline and the rows of the prime tower that no tool change will
    /// fill, if the layer has a tower, then the toolpaths of the part, with tool changes between
    /// them.
    pub(super) fn layer(
        &mut self,
        number: usize,
        toolpaths: &[Toolpath],
        tower: Option<&PrimeTowerPlan>,
    ) {
        self.machine.begin_layer(number, self.frame.top_mm(number), self.frame.layer_mm);
        if let Some(tower) = tower {
            let purged = self.purged_rows(toolpaths, tower);
            self.tower_bead(number, tower, &tower.outline());
            let rest = if number == 0 {
                tower.solid(purged, tower.rows() - purged)
            } else {
                tower.sparse(purged)
            };
            self.tower_bead(number, tower, &rest);
        }
        let mut rows = 0;
        for toolpath in toolpaths {
            let (from, to) = (self.machine.tool(), toolpath.tool);
            if from != to {
                let needed = tower.map_or(0, |tower| self.rows_between(from, to, tower));
                self.change_tool(number, to, tower.map(|tower| (tower, rows, needed)));
                rows += needed;
            }
            self.bead(toolpath);
        }
    }

    /// Number of rows of the tower that a layer purges into.
    fn purged_rows(&self, toolpaths: &[Toolpath], tower: &PrimeTowerPlan) -> i32 {
        let mut tool = self.machine.tool();
        let rows = toolpaths.iter().map(|toolpath| {
            let before = std::mem::replace(&mut tool, toolpath.tool);
            self.rows_between(before, toolpath.tool, tower)
        });
        rows.sum()
    }

    /// Number of rows that a tool change purges into.
    fn rows_between(&self, from: u8, to: u8, tower: &PrimeTowerPlan) -> i32 {
        let purge = self.settings.purge.as_ref();
        tower.rows_for(purge.map_or(0.0, |purge| purge.prime_tower_mm3(from, to)))
    }

    /// Changes to a tool and purges into `tower`, which is given with its first free row and the
    /// number of rows to fill.
    ///
    /// The change takes place above the first of these rows: filament that drips meanwhile is
    /// covered by the purge.
    fn change_tool(&mut self, layer: usize, to: u8, tower: Option<(&PrimeTowerPlan, i32, i32)>) {
        let purge = tower.filter(|&(_, _, rows)| rows > 0);
        let purge = purge.map(|(tower, begin, rows)| (tower, tower.solid(begin, rows)));
        let above_mm = purge.as_ref().map(|(tower, corners)| tower.position_mm(corners[0]));
        self.machine.change_tool(to, above_mm);
        if let Some((tower, corners)) = &purge {
            self.tower_bead(layer, tower, corners);
            self.machine.retract();
        }
    }

    fn tower_bead(&mut self, layer: usize, tower: &PrimeTowerPlan, corners: &[[i32; 2]]) {
        let position_mm = |corner| tower.position_mm(corner);
        let kind = (self.machine.tool(), Feature::PrimeTower);
        let toolpath =
            Toolpath::along_cells(corners, position_mm, kind, layer, self.frame, self.settings);
        if let Some(toolpath) = toolpath {
            self.bead(&toolpath);
        }
    }

    /// Travels to the start of a toolpath and extrudes along its moves.
    fn bead(&mut self, toolpath: &Toolpath) {
        let Some(first) = toolpath.moves.first() else { return };
        self.machine.travel(toolpath.start_mm);
        self.machine.begin_feature(first.feature, first.width_mm);
        self.machine.unretract();
        for step in &toolpath.moves {
            self.machine.extrude(step);
        }
    }
}
