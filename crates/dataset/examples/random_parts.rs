//! Draws a sheet of 24 random parts:
//! `cargo run --release -p beadwork-dataset --example random_parts -- holes sheet.png`.
//!
//! Arguments: a kind of part and the PNG file to write.
//! The parts are those of [`Preset::Grid32`] with the seeds 0 to 23, row by row.

use std::error::Error;

use beadwork_dataset::random_part::{Kind, Preset, Settings, random_part};
use beadwork_grid::{Region, Zones};
use beadwork_part::Picture;
use beadwork_part::slice::Voxels;

const COLUMNS: usize = 6;
const ROWS: usize = 4;

/// Half the width of a voxel in pixels; half its depth is half as much.
const HALF: i64 = 4;

/// Height of a voxel in pixels.
const RISE: i64 = 2;

/// Number of shades of each face: from dark at the bottom to light at the top.
const SHADES: usize = 32;

/// The three visible faces, as red, green and blue: top, left and right.
const FACES: [[u8; 3]; 3] = [[255, 214, 150], [214, 130, 60], [150, 84, 40]];

struct Sheet {
    width: usize,
    /// Zone of each pixel.
    ids: Vec<u8>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let [kind, file] = &arguments[..] else {
        return Err("expected two arguments: the kind of part and a PNG file".into());
    };
    let kind: Kind = kind.parse()?;
    let settings = Settings { kind, ..Settings::preset(Preset::Grid32) };
    let side = 2 * HALF as usize * settings.width as usize;
    let tile = [side + 8, side / 2 + RISE as usize * settings.max_layers as usize + 8];
    let (width, height) = (tile[0] * COLUMNS, tile[1] * ROWS);
    let mut sheet = Sheet { width, ids: vec![Zones::OUTSIDE; width * height] };
    for seed in 0..COLUMNS * ROWS {
        let part = random_part(&settings, seed as u64)?;
        let origin = [
            (seed % COLUMNS * tile[0] + tile[0] / 2) as i64,
            (seed / COLUMNS * tile[1] + 4) as i64 + RISE * i64::from(settings.max_layers),
        ];
        sheet.draw(&part, origin);
    }
    let inside = sheet.ids.iter().map(|&id| id != Zones::OUTSIDE).collect();
    let region = Region::from_mask(width as u32, height as u32, inside)?;
    let zones = Zones::new(&region, sheet.ids)?;
    let shade = |id: usize| {
        let light = 0.45 + 0.55 * (id % SHADES) as f64 / SHADES as f64;
        FACES[id / SHADES].map(|channel| (f64::from(channel) * light) as u8)
    };
    let colours = (0..FACES.len() * SHADES).map(shade).collect();
    std::fs::write(file, Picture { region, zones, colours }.to_png())?;
    Ok(())
}

impl Sheet {
    /// Draws voxels as seen from the front and above, the hidden ones first.
    /// `origin` is the pixel of the grid's back corner on the build plate.
    fn draw(&mut self, part: &Voxels, [left, top]: [i64; 2]) {
        for z in 0..part.depth {
            for y in 0..part.frame.height {
                for x in (0..part.frame.width).filter(|&x| part.material(x, y, z).is_some()) {
                    let (column, row) = (i64::from(x), i64::from(y));
                    let at = [
                        left + (column - row) * HALF,
                        top + (column + row) * HALF / 2 - z as i64 * RISE,
                    ];
                    self.voxel(at, z * SHADES / part.depth);
                }
            }
        }
    }

    /// Draws one voxel; `at` is the back corner of its bottom face.
    fn voxel(&mut self, [left, top]: [i64; 2], shade: usize) {
        for dx in -HALF..HALF {
            // The top face is a rhombus of 2 * HALF by HALF pixels, raised by the voxel's height.
            let half_height = (HALF - dx.max(-1 - dx)) / 2;
            let middle = top + HALF / 2;
            for y in middle - half_height..middle + half_height + RISE {
                let face = if y < middle + half_height { 0 } else { 1 + usize::from(dx >= 0) };
                let pixel = (y - RISE) as usize * self.width + (left + dx) as usize;
                self.ids[pixel] = (face * SHADES + shade) as u8;
            }
        }
    }
}
