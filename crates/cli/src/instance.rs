//! Flags that name one layer: a generated layout, or a picture.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use beadwork_dataset::Size;
use beadwork_grid::{Layout, LayoutSpec, Region, RegionShape, Zones};
use beadwork_part::Picture;

/// Flags that name one layer.
#[derive(clap::Args)]
pub(crate) struct InstanceArgs {
    /// Layout: left_right, stripes, islands, voronoi, checkerboard or top_bottom.
    #[arg(long, value_name = "L", default_value = "voronoi", conflicts_with = "image")]
    layout: Layout,
    /// Size in cells.
    #[arg(long, value_name = "WxH", default_value = "30x30", conflicts_with = "image")]
    size: Size,
    /// Shape of the region: disc, ring, blob, rotated_rectangle, star or l; the whole grid by
    /// default.
    #[arg(long, value_name = "NAME", conflicts_with = "image")]
    shape: Option<RegionShape>,
    /// Number of zones; the default depends on the layout.
    #[arg(long, value_name = "K", conflicts_with = "image")]
    zones: Option<u8>,
    /// Side of an island or of a checkerboard block, in cells; the default depends on the layout.
    #[arg(long, value_name = "CELLS", conflicts_with = "image")]
    side: Option<u16>,
    /// PNG picture: each pixel is a cell, each colour a zone; transparent pixels lie outside.
    #[arg(long, value_name = "PNG")]
    image: Option<PathBuf>,
}

/// One layer with its name.
pub(crate) struct Instance {
    pub(crate) name: String,
    pub(crate) region: Region,
    pub(crate) zones: Zones,
    /// Colours of the zones in the picture.
    pub(crate) colours: Option<Vec<[u8; 3]>>,
}

impl InstanceArgs {
    pub(crate) fn load(&self, seed: u64) -> anyhow::Result<Instance> {
        if let Some(path) = &self.image {
            let in_file = || format!("cannot read '{}'", path.display());
            let bytes = fs::read(path).with_context(in_file)?;
            let Picture { region, zones, colours } =
                Picture::from_png(&bytes).with_context(in_file)?;
            let name = path
                .file_stem()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            return Ok(Instance { name, region, zones, colours: Some(colours) });
        }
        let defaults = LayoutSpec::new(self.layout);
        let spec = LayoutSpec {
            zones: self.zones.unwrap_or(defaults.zones),
            side: self.side.unwrap_or(defaults.side),
            ..defaults
        };
        let Size { width, height } = self.size;
        let region = match self.shape {
            Some(shape) => {
                shape.region(width, height, seed).with_context(|| format!("no {shape} fits"))?
            }
            None => Region::rectangle(width, height)?,
        };
        let zones = spec.zones(&region, seed)?;
        Ok(Instance { name: self.layout.name().to_owned(), region, zones, colours: None })
    }
}
