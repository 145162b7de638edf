//! PNG pictures as layers: each pixel is a cell, each colour a zone.

use std::collections::HashMap;
use std::io::Cursor;

use beadwork_grid::{Cell, Region, RegionError, Zones};
use png::{BitDepth, ColorType, Decoder, Encoder, Limits, Transformations};
use thiserror::Error;

/// A layer drawn as a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// The opaque pixels.
    pub region: Region,
    /// Their zones, numbered in the order in which colours appear, row by row.
    pub zones: Zones,
    /// Red, green and blue of each zone.
    pub colours: Vec<[u8; 3]>,
}

/// Why a picture could not be read as a layer.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The file is not a PNG picture.
    #[error("file is not a PNG picture")]
    NotAPng,
    /// The file is damaged or truncated.
    #[error("PNG data are damaged or truncated")]
    Damaged(#[source] png::DecodingError),
    /// The picture has no pixels, more than [`Region::MAX_SIDE`] a side, or only transparent ones.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The picture has more colours than there can be zones.
    #[error(
        "picture has more than {max} colours: draw without anti-aliasing, which adds colours",
        max = Zones::MAX
    )]
    Colours,
}

/// Minimum alpha of a pixel of the region: half, so that the border of the region runs through the
/// centre of anti-aliased edges.
const OPAQUE: u8 = 128;

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Memory that the decoder may use besides the pixels, for palettes and other small chunks.
const EXTRA_BYTES: usize = 1 << 20;

impl Picture {
    /// Reads a PNG picture of any colour type and bit depth.
    ///
    /// Channels are reduced to 8 bits, and of an animation only the first frame is read.
    /// Each distinct colour is a zone.
    /// Pixels whose alpha is at least one half belong to the region.
    /// The size is checked before any pixel is decoded.
    /// Takes time linear in the number of pixels.
    pub fn from_png(bytes: &[u8]) -> Result<Self, PictureError> {
        let (width, height) = size(bytes)?;
        let grid = Region::rectangle(width, height)?;
        let limits = Limits { bytes: 8 * grid.grid_len() + EXTRA_BYTES };
        let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
        // Text and colour profiles may be larger than the pixels, and do not affect the layer.
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        decoder
            .set_transformations(Transformations::normalize_to_color8() | Transformations::ALPHA);
        let mut reader = decoder.read_info().map_err(PictureError::Damaged)?;
        let mut pixels = vec![0; 4 * grid.grid_len()];
        let frame = reader.next_frame(&mut pixels).map_err(PictureError::Damaged)?;
        let channels = frame.color_type.samples();

        let mut zone_of: HashMap<[u8; 3], u8> = HashMap::new();
        let mut colours = Vec::new();
        let mut ids = vec![Zones::OUTSIDE; grid.grid_len()];
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
        let region =
            Region::from_mask(width, height, ids.iter().map(|&id| id != Zones::OUTSIDE).collect())?;
        let zones = Zones::new(&region, ids).expect("each opaque pixel has a zone");
        Ok(Self { region, zones, colours })
    }

    /// Returns the picture as a PNG file with 8 bits per channel, transparent outside the region.
    /// Zones without a colour are black.
    pub fn to_png(&self) -> Vec<u8> {
        let pixel = |cell: Cell| {
            if !self.region.contains(cell) {
                return [0; 4];
            }
            let [red, green, blue] =
                self.colours.get(usize::from(self.zones.id(cell))).copied().unwrap_or_default();
            [red, green, blue, u8::MAX]
        };
        let pixels: Vec<u8> = (0..self.region.grid_len() as Cell).flat_map(pixel).collect();
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, self.region.width(), self.region.height());
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        let mut writer = encoder.write_header().expect("writing to memory cannot fail");
        writer.write_image_data(&pixels).expect("there is one pixel for each cell");
        writer.finish().expect("writing to memory cannot fail");
        bytes
    }
}

/// Width and height from the `IHDR` chunk, which must be the first in a PNG file.
fn size(bytes: &[u8]) -> Result<(u32, u32), PictureError> {
    let header = bytes.strip_prefix(&SIGNATURE).ok_or(PictureError::NotAPng)?;
    let field = |at: usize| {
        let field = header.get(at..at + 4)?;
        Some(u32::from_be_bytes(field.try_into().expect("the slice has four bytes")))
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
    use png::Filter;
    use proptest::prelude::*;
    use std::error::Error as _;

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

    /// Three frames of one pixel, shades 10, 20 and 30.
    fn animated() -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, 1, 1);
        encoder.set_color(ColorType::Grayscale);
        encoder.set_animated(3, 0).unwrap();
        let mut writer = encoder.write_header().unwrap();
        for shade in [10, 20, 30] {
            writer.write_image_data(&[shade]).unwrap();
        }
        writer.finish().unwrap();
        bytes
    }

    fn crc(bytes: &[u8]) -> u32 {
        let shift = |rest: u32| if rest & 1 == 1 { rest >> 1 ^ 0xedb8_8320 } else { rest >> 1 };
        !bytes
            .iter()
            .fold(!0, |rest, &byte| (0..8).fold(rest ^ u32::from(byte), |rest, _| shift(rest)))
    }

    /// Corrects the checksums of all complete chunks, so that damage is not refused because of
    /// them.
    fn fix_checksums(bytes: &mut [u8]) {
        let mut at = SIGNATURE.len();
        while let Some(length) = bytes.get(at..at + 4) {
            let length = u32::from_be_bytes(length.try_into().unwrap()) as usize;
            let Some(chunk) = bytes.get(at + 4..at + 8 + length) else { break };
            let sum = crc(chunk).to_be_bytes();
            let Some(stored) = bytes.get_mut(at + 8 + length..at + 12 + length) else { break };
            stored.copy_from_slice(&sum);
            at += 12 + length;
        }
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

        let grey = encode(2, 1, ColorType::Grayscale, sixteen, &[5, 99, 9, 0]);
        assert_eq!(ids(&grey), (vec![0, 1], vec![[5; 3], [9; 3]]));
        let alpha =
            encode(2, 1, ColorType::GrayscaleAlpha, sixteen, &[5, 0, 128, 0, 9, 0, 127, 255]);
        assert_eq!(ids(&alpha), (vec![0, 255], vec![[5; 3]]));
        let alpha = encode(1, 1, ColorType::Rgba, sixteen, &[1, 9, 2, 9, 3, 9, 255, 255]);
        assert_eq!(ids(&alpha), (vec![0], vec![[1, 2, 3]]));
        for (depth, packed, white) in [
            (BitDepth::One, vec![0b1000_0000], vec![[255; 3], [0; 3]]),
            (BitDepth::Two, vec![0b1001_0000], vec![[170; 3], [85; 3]]),
            (BitDepth::Four, vec![0x21], vec![[34; 3], [17; 3]]),
        ] {
            assert_eq!(
                ids(&encode(2, 1, ColorType::Grayscale, depth, &packed)),
                (vec![0, 1], white)
            );
            let palette = ids(&encode(2, 1, ColorType::Indexed, depth, &packed));
            let clear = depth != BitDepth::One;
            assert_eq!(palette.0, if clear { [255, 0] } else { [0, 1] }, "{depth:?}");
        }
    }

    #[test]
    fn one_colour_can_be_declared_transparent() {
        let with_clear = |colour: ColorType, depth: BitDepth, clear: &'static [u8], data: &[u8]| {
            let mut bytes = Vec::new();
            let mut encoder = Encoder::new(&mut bytes, 2, 1);
            encoder.set_color(colour);
            encoder.set_depth(depth);
            encoder.set_trns(clear);
            encoder.write_header().unwrap().write_image_data(data).unwrap();
            ids(&bytes)
        };
        let (eight, sixteen) = (BitDepth::Eight, BitDepth::Sixteen);
        assert_eq!(with_clear(ColorType::Grayscale, eight, &[0, 5], &[5, 6]).0, [255, 0]);
        assert_eq!(
            with_clear(ColorType::Grayscale, BitDepth::One, &[0, 1], &[0b1000_0000]).0,
            [255, 0]
        );
        assert_eq!(
            with_clear(ColorType::Rgb, eight, &[0, 1, 0, 2, 0, 3], &[1, 2, 4, 1, 2, 3]).0,
            [0, 255]
        );
        // All 16 bits count: both pixels have the same colour in 8 bits.
        assert_eq!(with_clear(ColorType::Grayscale, sixteen, &[5, 1], &[5, 0, 5, 1]).0, [0, 255]);
    }

    #[test]
    fn interlaced_pixels_are_put_in_order() {
        // Two interlaced pixels in a row are two passes of one pixel each: the same data as a
        // column of two pixels.
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, 1, 2);
        encoder.set_filter(Filter::NoFilter);
        encoder.write_header().unwrap().write_image_data(&[7, 8]).unwrap();
        bytes[16..24].copy_from_slice(&[0, 0, 0, 2, 0, 0, 0, 1]);
        bytes[28] = 1;
        fix_checksums(&mut bytes);
        let picture = Picture::from_png(&bytes).unwrap();
        assert_eq!((picture.region.width(), picture.colours), (2, vec![[7; 3], [8; 3]]));
    }

    #[test]
    fn an_animation_gives_its_first_frame() {
        assert_eq!(ids(&animated()), (vec![0], vec![[10; 3]]));
    }

    #[test]
    fn comments_and_profiles_are_ignored() {
        let good = encode(1, 1, ColorType::Grayscale, BitDepth::Eight, &[3]);
        for name in [b"tEXt", b"iCCP"] {
            let length = EXTRA_BYTES + 100;
            let mut bytes = good[..33].to_vec();
            bytes.extend((length as u32).to_be_bytes());
            bytes.extend(name);
            bytes.extend(vec![b'x'; length + 4]);
            bytes.extend(&good[33..]);
            fix_checksums(&mut bytes);
            assert_eq!(ids(&bytes), (vec![0], vec![[3; 3]]));
        }
    }

    #[test]
    fn a_header_with_a_wrong_size_is_damage() {
        let mut bytes = encode(1, 1, ColorType::Rgba, BitDepth::Sixteen, &[0; 8]);
        bytes[16..24].copy_from_slice(&[0, 0, 16, 0, 0, 0, 16, 0]);
        fix_checksums(&mut bytes);
        let error = Picture::from_png(&bytes).unwrap_err();
        assert!(matches!(error, PictureError::Damaged(_)) && error.source().is_some(), "{error}");
    }

    #[test]
    fn invalid_pictures_are_refused() {
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

    /// Pictures of various PNG formats, which reach different parts of the decoder.
    fn formats() -> impl Strategy<Value = Vec<u8>> {
        let fixed = [
            encode(3, 3, ColorType::Indexed, BitDepth::Eight, &[0, 1, 2, 2, 1, 0, 0, 1, 2]),
            encode(3, 2, ColorType::Indexed, BitDepth::Two, &[0b0001_1000, 0b1001_0000]),
            encode(3, 2, ColorType::Grayscale, BitDepth::One, &[0b1010_0000, 0b0100_0000]),
            encode(2, 2, ColorType::Rgb, BitDepth::Sixteen, &[1; 24]),
            animated(),
        ];
        prop_oneof![pictures(), prop::sample::select(fixed.to_vec())]
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 4_000,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn a_written_picture_reads_back_equal(bytes in pictures()) {
            if let Ok(picture) = Picture::from_png(&bytes) {
                prop_assert_eq!(Picture::from_png(&picture.to_png()).unwrap(), picture);
            }
        }

        #[test]
        fn damage_is_never_a_panic(
            bytes in formats(),
            flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
            end: prop::sample::Index,
            cut: bool,
            has_valid_checksums: bool,
        ) {
            let mut bytes = bytes;
            flips.iter().for_each(|(at, bits)| {
                let at = at.index(bytes.len());
                bytes[at] ^= bits;
            });
            if cut {
                bytes.truncate(end.index(bytes.len()));
            }
            if has_valid_checksums {
                fix_checksums(&mut bytes);
            }
            let _ = Picture::from_png(&bytes);
        }
    }
}
