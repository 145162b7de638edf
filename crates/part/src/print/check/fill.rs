//! Compares the extruded area of each material with its outlines.

use super::error::CheckError;
use crate::Area;

/// Extruded area and outlines of a tool, in all layers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolFill {
    /// Sum of length times width of the beads in mm².
    pub extruded_mm2: f64,
    /// Sum of the areas of the outlines in mm².
    pub outline_mm2: f64,
}

impl ToolFill {
    /// Extruded area divided by that of the outlines; `None` without outlines.
    pub fn ratio(&self) -> Option<f64> {
        (self.outline_mm2 > 0.0).then(|| self.extruded_mm2 / self.outline_mm2)
    }
}

/// Extruded area and outline of a tool in a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerFill {
    /// Number of the layer.
    pub layer: usize,
    /// The tool.
    pub tool: u8,
    /// The areas.
    pub areas: ToolFill,
}

/// Adds up areas by layer and tool.
#[derive(Debug)]
pub(super) struct FillTracker {
    layer_limits: Option<[f64; 2]>,
    total_limits: Option<[f64; 2]>,
    /// For each tool, the extruded area in the current layer, in mm².
    extruded_mm2: Vec<f64>,
    totals: Vec<ToolFill>,
    /// Those with the lowest and the highest ratio.
    extremes: [Option<LayerFill>; 2],
}

impl FillTracker {
    /// Limits are a minimum and a maximum of the ratio.
    pub(super) fn new(
        tools: usize,
        layer_limits: Option<[f64; 2]>,
        total_limits: Option<[f64; 2]>,
    ) -> Self {
        Self {
            layer_limits,
            total_limits,
            extruded_mm2: vec![0.0; tools],
            totals: vec![ToolFill::default(); tools],
            extremes: [None; 2],
        }
    }

    /// Adds the area of a move, in mm².
    pub(super) fn add(&mut self, tool: u8, area_mm2: f64) {
        self.extruded_mm2[usize::from(tool)] += area_mm2;
    }

    /// Ends a layer with these outlines, which have tools of their own.
    /// Outlines of tools without settings count as unfilled.
    pub(super) fn end_layer(
        &mut self,
        layer: usize,
        outlines: &[(u8, Area)],
    ) -> Result<(), CheckError> {
        for (tool, area) in outlines {
            let extruded_mm2 = self.extruded_mm2.get(usize::from(*tool)).copied().unwrap_or(0.0);
            let areas = ToolFill { extruded_mm2, outline_mm2: area.size_mm2() };
            if let Some(total) = self.totals.get_mut(usize::from(*tool)) {
                total.outline_mm2 += areas.outline_mm2;
            }
            let Some(ratio) = areas.ratio() else { continue };
            check(Some(layer), *tool, areas, self.layer_limits)?;
            let fill = Some(LayerFill { layer, tool: *tool, areas });
            let of = |fill: Option<LayerFill>| fill.and_then(|fill| fill.areas.ratio());
            let [lowest, highest] = &mut self.extremes;
            if of(*lowest).is_none_or(|low| ratio < low) {
                *lowest = fill;
            }
            if of(*highest).is_none_or(|high| ratio > high) {
                *highest = fill;
            }
        }
        for (total, extruded_mm2) in self.totals.iter_mut().zip(&mut self.extruded_mm2) {
            total.extruded_mm2 += std::mem::take(extruded_mm2);
        }
        Ok(())
    }

    /// Checks the totals of all layers.
    pub(super) fn finish(&self) -> Result<(), CheckError> {
        let mut totals = (0..=u8::MAX).zip(&self.totals);
        totals.try_for_each(|(tool, &areas)| check(None, tool, areas, self.total_limits))
    }

    /// For each tool, the sums over all layers.
    pub(super) fn totals(&self) -> &[ToolFill] {
        &self.totals
    }

    /// The material in a layer with the lowest ratio, and the one with the highest.
    pub(super) fn extremes(&self) -> [Option<LayerFill>; 2] {
        self.extremes
    }
}

fn check(
    layer: Option<usize>,
    tool: u8,
    areas: ToolFill,
    limits: Option<[f64; 2]>,
) -> Result<(), CheckError> {
    let (Some(limits), Some(ratio)) = (limits, areas.ratio()) else { return Ok(()) };
    if limits[0] <= ratio && ratio <= limits[1] {
        return Ok(());
    }
    let ToolFill { extruded_mm2, outline_mm2 } = areas;
    Err(CheckError::Fill { layer, tool, extruded_mm2, outline_mm2, limits })
}
