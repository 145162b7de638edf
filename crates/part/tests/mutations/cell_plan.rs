//! A plan of cells, whose program is changed and checked.

use beadwork_base::Control;
use beadwork_grid::{Layout, LayoutSpec, Path, Region, Zones, cover};
use beadwork_part::Frame;
use beadwork_part::print::{self, Flavour, PrimeTower, Print, Printer, Purge, Title, Tool};

/// The plan that programs are checked against; its own program is a seed.
pub(crate) struct CellPlan {
    pub(crate) frame: Frame,
    region: Region,
    zones: Zones,
    path: Path,
}

impl CellPlan {
    pub(crate) fn new() -> Self {
        let region = Region::rectangle(8, 5).unwrap();
        let zones = LayoutSpec::new(Layout::LeftRight).zones(&region, 0).unwrap();
        let path = cover(&region, &Control::default()).unwrap();
        let frame = Frame {
            left_mm: 100.0,
            back_mm: 100.0,
            cell_mm: 0.5,
            layer_mm: 0.2,
            width: 8,
            height: 5,
        };
        Self { frame, region, zones, path }
    }

    pub(crate) fn layers(&self) -> [print::Layer<'_>; 2] {
        let Self { region, zones, path, .. } = self;
        [0, 1].map(|number| print::Layer { number, region, zones, path })
    }

    pub(crate) fn settings(flavour: Flavour) -> print::Settings {
        let tower = PrimeTower { left_mm: 120.0, front_mm: 50.0, width_mm: 10.0, depth_mm: 30.0 };
        let purge = Some(Purge::uniform(2, 2.0, Some(tower)));
        let printer = Printer { flavour, ..Printer::default() };
        print::Settings {
            tools: vec![Tool::default(); 2],
            purge,
            printer,
            ..print::Settings::default()
        }
    }

    pub(crate) fn print(&self, flavour: Flavour) -> String {
        let title = Title { part: "plate", version: "0" };
        Print::new(
            title,
            &self.layers(),
            &self.frame,
            &Self::settings(flavour),
            &Control::default(),
        )
        .unwrap()
        .program
        .emit()
    }
}
