//! PNG pictures as layers: one pixel a cell, one colour a zone.

use std::collections::HashMap;
use std::io::Cursor;

use beadwork_grid::{Cell, Region, RegionError, Zones};
use png::{BitDepth, ColorType, Decoder, Encoder, Limits, Transformations};
use thiserror::Error;

/// A layer that was drawn as a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// The pixels that are not transparent.
    pub region: Region,
    /// Their zones, numbered by first appearance, row by row.
    pub zones: Zones,
    /// Red, green and blue of each zone.
    pub colours: Vec<[u8; 3]>,
}

/// Why a picture can't be a layer.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PictureError {
    /// It is no PNG file.
    #[error("it is not a PNG picture")]
    NotAPng,
    /// It is a PNG file, but damaged or cut short.
    #[error("its PNG data are damaged: {0}")]
    Damaged(png::DecodingError),
    /// It has zero size, more than [`Region::MAX_SIDE`] pixels a side, or no cells: all pixels are transparent.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// It has more colours than there can be zones.
    #[error("it has more than {max} colours: smooth edges give a colour to every shade", max = Zones::MAX)]
    Colours,
}

/// Pixels of less opacity lie outside the region: half, so that smoothed outlines end in their middle.
const OPAQUE: u8 = 128;

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Bytes that the decoder may take beside the pixels, for palettes, text and colour profiles.
const EXTRA_BYTES: usize = 1 << 20;

impl Picture {
    /// Reads a picture: every kind of PNG, reduced to 8 bits a channel; of an animation the first frame.
    ///
    /// Each distinct colour is a zone; how opaque a pixel is only decides whether it belongs to the region. The size is
    /// checked before any pixel is decoded. Linear in the pixels.
    pub fn from_png(bytes: &[u8]) -> Result<Self, PictureError> {
        let (width, height) = size(bytes)?;
        let plane = Region::rectangle(width, height)?;
        let limits = Limits { bytes: 8 * plane.plane_len() + EXTRA_BYTES };
        let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
        decoder.set_transformations(Transformations::normalize_to_color8() | Transformations::ALPHA);
        let mut reader = decoder.read_info().map_err(PictureError::Damaged)?;
        let mut pixels = vec![0; 4 * plane.plane_len()];
        let frame = reader.next_frame(&mut pixels).map_err(PictureError::Damaged)?;
        let channels = frame.color_type.samples();

        let mut zone_of: HashMap<[u8; 3], u8> = HashMap::new();
        let mut colours = Vec::new();
        let mut ids = vec![Zones::OUTSIDE; plane.plane_len()];
        for (id, pixel) in ids.iter_mut().zip(pixels.chunks_exact(channels)) {
            if pixel[channels - 1] < OPAQUE {
                continue;
            }
            let colour = if channels == 4 { [pixel[0], pixel[1], pixel[2]] } else { [pixel[0]; 3] };
            *id = match zone_of.get(&colour) {
                Some(&zone) => zone,
                None if colours.len() == Zones::MAX as usize => return Err(PictureError::Colours),
                None => {
                    let zone = colours.len() as u8;
                    zone_of.insert(colour, zone);
                    colours.push(colour);
                    zone
                }
            };
        }
        let region = Region::from_mask(width, height, ids.iter().map(|&id| id != Zones::OUTSIDE).collect())?;
        let zones = Zones::new(&region, ids).expect("each opaque pixel has a zone");
        Ok(Self { region, zones, colours })
    }

    /// Writes the picture: 8 bits a channel, transparent outside the region. Zones beyond the colours are black.
    pub fn to_png(&self) -> Vec<u8> {
        let pixel = |cell: Cell| {
            if !self.region.contains(cell) {
                return [0; 4];
            }
            let [red, green, blue] =
                self.colours.get(usize::from(self.zones.id(cell))).copied().unwrap_or_default();
            [red, green, blue, u8::MAX]
        };
        let pixels: Vec<u8> = (0..self.region.plane_len() as Cell).flat_map(pixel).collect();
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, self.region.width(), self.region.height());
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        let mut writer = encoder.write_header().expect("memory takes all bytes");
        writer.write_image_data(&pixels).expect("there is one pixel a cell");
        writer.finish().expect("memory takes all bytes");
        bytes
    }
}

/// Width and height from the header, which must come first in a PNG file.
fn size(bytes: &[u8]) -> Result<(u32, u32), PictureError> {
    let header = bytes.strip_prefix(&SIGNATURE).ok_or(PictureError::NotAPng)?;
    let field = |at: usize| {
        let field = header.get(at..at + 4)?;
        Some(u32::from_be_bytes(field.try_into().expect("it has four bytes")))
    };
    let is_header = header.get(4..8) == Some(b"IHDR");
    match (field(8), field(12)) {
        (Some(width), Some(height)) if is_header => Ok((width, height)),
        _ => Err(PictureError::NotAPng),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn encode(width: u32, height: u32, colour: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, width, height);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == ColorType::Indexed {
            encoder.set_palette(&[9, 8, 7, 1, 2, 3, 250, 0, 0][..]);
            encoder.set_trns(&[255, 255, 0][..]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    fn ids(bytes: &[u8]) -> (Vec<u8>, Vec<[u8; 3]>) {
        let picture = Picture::from_png(bytes).unwrap();
        (picture.zones.ids().to_vec(), picture.colours)
    }

    #[test]
    fn all_colour_types_are_read() {
        let (eight, sixteen) = (BitDepth::Eight, BitDepth::Sixteen);
        let grey = encode(2, 1, ColorType::Grayscale, eight, &[5, 9]);
        assert_eq!(ids(&grey), (vec![0, 1], vec![[5; 3], [9; 3]]));
        let bits = encode(3, 1, ColorType::Grayscale, BitDepth::One, &[0b0100_0000]);
        assert_eq!(ids(&bits), (vec![0, 1, 0], vec![[0; 3], [255; 3]]));
        let grey_alpha = encode(2, 1, ColorType::GrayscaleAlpha, eight, &[5, 255, 9, 127]);
        assert_eq!(ids(&grey_alpha), (vec![0, 255], vec![[5; 3]]));
        let rgb = encode(2, 1, ColorType::Rgb, eight, &[1, 2, 3, 4, 5, 6]);
        assert_eq!(ids(&rgb), (vec![0, 1], vec![[1, 2, 3], [4, 5, 6]]));
        let deep = encode(2, 1, ColorType::Rgb, sixteen, &[1, 99, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0]);
        assert_eq!(ids(&deep), (vec![0, 1], vec![[1, 2, 3], [4, 5, 6]]));
        let rgba = encode(2, 1, ColorType::Rgba, eight, &[1, 2, 3, 0, 4, 5, 6, 128]);
        assert_eq!(ids(&rgba), (vec![255, 0], vec![[4, 5, 6]]));
        let palette = encode(3, 1, ColorType::Indexed, eight, &[1, 2, 0]);
        assert_eq!(ids(&palette), (vec![0, 255, 1], vec![[1, 2, 3], [9, 8, 7]]));
    }

    #[test]
    fn what_is_no_layer_is_refused() {
        let refused = |bytes: &[u8]| Picture::from_png(bytes).unwrap_err();
        assert!(matches!(refused(b""), PictureError::NotAPng));
        assert!(matches!(refused(b"GIF89a and some more bytes"), PictureError::NotAPng));
        assert!(matches!(refused(&SIGNATURE), PictureError::NotAPng));
        let clear = encode(2, 2, ColorType::GrayscaleAlpha, BitDepth::Eight, &[0; 8]);
        assert!(matches!(refused(&clear), PictureError::Region(RegionError::NoCells)));
        let colours: Vec<u8> = (0..=255).flat_map(|shade| [shade, 0, 0]).collect();
        let colours = encode(16, 16, ColorType::Rgb, BitDepth::Eight, &colours);
        assert!(matches!(refused(&colours), PictureError::Colours));
        let good = encode(2, 2, ColorType::Grayscale, BitDepth::Eight, &[0; 4]);
        assert!(matches!(refused(&good[..good.len() - 20]), PictureError::Damaged(_)));
    }

    #[test]
    fn the_size_is_checked_before_the_pixels() {
        let good = encode(2, 2, ColorType::Grayscale, BitDepth::Eight, &[0; 4]);
        for (width, height) in [(0_u32, 2_u32), (2, 0), (4097, 1), (u32::MAX, u32::MAX)] {
            let mut forged = good.clone();
            forged[16..20].copy_from_slice(&width.to_be_bytes());
            forged[20..24].copy_from_slice(&height.to_be_bytes());
            let error = Picture::from_png(&forged).unwrap_err();
            let expected = matches!(
                error,
                PictureError::Region(RegionError::ZeroSize { .. } | RegionError::TooLarge { .. })
            );
            assert!(expected, "{width} x {height}: {error}");
        }
    }

    fn pictures() -> impl Strategy<Value = Vec<u8>> {
        (1_u32..20, 1_u32..20).prop_flat_map(|(width, height)| {
            let pixel = (0_u8..4, prop::bool::weighted(0.9))
                .prop_map(|(shade, opaque)| [shade, 7, 0, u8::from(opaque) * 255]);
            prop::collection::vec(pixel, (width * height) as usize).prop_map(move |pixels| {
                encode(width, height, ColorType::Rgba, BitDepth::Eight, &pixels.concat())
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn writing_and_reading_gives_the_same(bytes in pictures()) {
            if let Ok(picture) = Picture::from_png(&bytes) {
                prop_assert_eq!(Picture::from_png(&picture.to_png()).unwrap(), picture);
            }
        }

        #[test]
        fn damage_is_never_a_panic(
            bytes in pictures(),
            flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
            end: prop::sample::Index,
            cut: bool,
        ) {
            let mut bytes = bytes;
            flips.iter().for_each(|(at, bits)| { let at = at.index(bytes.len()); bytes[at] ^= bits; });
            if cut {
                bytes.truncate(end.index(bytes.len()));
            }
            let _ = Picture::from_png(&bytes);
        }
    }
}
