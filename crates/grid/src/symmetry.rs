//! The eight symmetries of a square grid, applied to cells and to variants.
//!
//! Training data can be multiplied by eight with them: the mirror image of a layer with its moves
//! is as good an example as the layer itself.

use crate::rules::{RULES, below, right};
use crate::{PlacedVariant, Variant};

/// A symmetry of the square grid: a rotation by a multiple of 90 degrees, a reflection, or both.
///
/// It consists of a transposition, a flip of x and a flip of y, each done or not, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Symmetry {
    /// Whether x and y are exchanged first.
    transposed: bool,
    /// Whether x then runs in the opposite direction.
    flipped_x: bool,
    /// Whether y then runs in the opposite direction.
    flipped_y: bool,
}

/// Class of a variant's image, indexed by the number of the symmetry and the variant's class.
const CLASSES: [[u8; 12]; 8] = {
    let mut table = [[0; 12]; 8];
    let mut symmetry = 0;
    while symmetry < 8 {
        let mut class = 0;
        while class < 12 {
            table[symmetry][class] = mapped_class(Symmetry::ALL[symmetry], class);
            class += 1;
        }
        symmetry += 1;
    }
    table
};

impl Symmetry {
    /// All eight symmetries, the identity first.
    pub const ALL: [Self; 8] = {
        let mut all = [Self { transposed: false, flipped_x: false, flipped_y: false }; 8];
        let mut number = 0;
        while number < 8 {
            all[number] = Self {
                transposed: number & 4 != 0,
                flipped_x: number & 1 != 0,
                flipped_y: number & 2 != 0,
            };
            number += 1;
        }
        all
    };

    /// Index in [`Symmetry::ALL`].
    const fn number(self) -> usize {
        self.flipped_x as usize | (self.flipped_y as usize) << 1 | (self.transposed as usize) << 2
    }

    /// Width and height of the image of a grid with this width and height.
    pub const fn map_size(self, (width, height): (u32, u32)) -> (u32, u32) {
        if self.transposed { (height, width) } else { (width, height) }
    }

    /// Column and row of the image of cell (x, y) of a grid with this width and height.
    pub const fn map_cell(self, (x, y): (u32, u32), size: (u32, u32)) -> (u32, u32) {
        let (x, y) = if self.transposed { (y, x) } else { (x, y) };
        let (width, height) = self.map_size(size);
        (
            if self.flipped_x { width - 1 - x } else { x },
            if self.flipped_y { height - 1 - y } else { y },
        )
    }

    /// Image of a variant on a grid with this width and height.
    ///
    /// The image applies to the image of a path exactly if the variant applies to the path, and
    /// then its result is the image of the variant's result.
    pub fn map_variant(self, placed: PlacedVariant, size: (u32, u32)) -> PlacedVariant {
        let (x, y) = (u32::from(placed.x), u32::from(placed.y));
        let (columns, rows) = placed.variant.window();
        // Two opposite corners of the window; either may become its top-left one.
        let one = self.map_cell((x, y), size);
        let other = self.map_cell((x + columns - 1, y + rows - 1), size);
        let class = CLASSES[self.number()][usize::from(placed.variant.class())];
        let variant = Variant::from_class(class).expect("the table holds classes");
        PlacedVariant { variant, x: one.0.min(other.0) as u16, y: one.1.min(other.1) as u16 }
    }
}

/// The class whose required and added links are the images of those of `class`.
const fn mapped_class(symmetry: Symmetry, class: usize) -> u8 {
    let rule = &RULES[class];
    let size = (rule.columns, rule.rows);
    let required = mapped_links(symmetry, rule.required, size);
    let added = mapped_links(symmetry, rule.added, size);
    let mut other = 0;
    while other < RULES.len() {
        if RULES[other].required == required && RULES[other].added == added {
            return other as u8;
        }
        other += 1;
    }
    panic!("the variants are closed under the symmetries")
}

/// Image of a mask of links in a window of `size` (width, height).
const fn mapped_links(symmetry: Symmetry, links: u16, size: (u32, u32)) -> u16 {
    let mut mapped = 0;
    let mut cell = 0;
    while cell < 9 {
        let (x, y) = (cell % 3, cell / 3);
        if x + 1 < size.0 && y < size.1 && links >> right(x, y) & 1 != 0 {
            mapped |= 1
                << link_between(
                    symmetry.map_cell((x, y), size),
                    symmetry.map_cell((x + 1, y), size),
                );
        }
        if x < size.0 && y + 1 < size.1 && links >> below(x, y) & 1 != 0 {
            mapped |= 1
                << link_between(
                    symmetry.map_cell((x, y), size),
                    symmetry.map_cell((x, y + 1), size),
                );
        }
        cell += 1;
    }
    mapped
}

/// Number of the link between two neighbouring cells (x, y) of a window.
const fn link_between(a: (u32, u32), b: (u32, u32)) -> u32 {
    let (x, y) = (if a.0 < b.0 { a.0 } else { b.0 }, if a.1 < b.1 { a.1 } else { b.1 });
    if a.1 == b.1 { right(x, y) } else { below(x, y) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

    use std::collections::HashSet;

    use beadwork_base::Control;
    use proptest::prelude::*;

    use super::*;
    use crate::{Path, Region, Start, VariantKind};

    fn image_of(symmetry: Symmetry, path: &Path) -> Path {
        let size = (path.width(), path.height());
        let (width, height) = symmetry.map_size(size);
        let region = Region::rectangle(width, height).unwrap();
        let order = path.order().iter().map(|cell| {
            let (x, y) = symmetry.map_cell((cell % size.0, cell / size.0), size);
            y * width + x
        });
        Path::hamiltonian(&region, order.collect()).unwrap()
    }

    #[test]
    fn eight_symmetries_map_cells_one_to_one() {
        let images = Symmetry::ALL.map(|symmetry| {
            let cells = (0..3 * 5).map(|cell| symmetry.map_cell((cell % 3, cell / 3), (3, 5)));
            cells.collect::<Vec<_>>()
        });
        assert_eq!(images.iter().collect::<HashSet<_>>().len(), 8);
        for (symmetry, cells) in Symmetry::ALL.into_iter().zip(&images) {
            let (width, height) = symmetry.map_size((3, 5));
            assert!(cells.iter().all(|&(x, y)| x < width && y < height));
            assert_eq!(cells.iter().collect::<HashSet<_>>().len(), 15);
        }
        assert_eq!(images[0][7], (1, 2));
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 500,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        /// Moving a path and mapping the result is the same as mapping it and making the mapped
        /// move, for all moves that apply; and no others apply to the image.
        #[test]
        fn moves_are_mapped_with_their_paths(
            width in 2_u32..9,
            height in 2_u32..9,
            choices in prop::collection::vec(any::<usize>(), 0..30),
        ) {
            let region = Region::rectangle(width, height).unwrap();
            let mut path = Start::RowZigzag.path(&region, &Control::default()).unwrap();
            for choice in choices {
                let mut all = Vec::new();
                path.for_each_variant(&VariantKind::ALL, |placed| all.push(placed));
                for symmetry in Symmetry::ALL {
                    let image = image_of(symmetry, &path);
                    let mut theirs = HashSet::new();
                    image.for_each_variant(&VariantKind::ALL, |placed| {
                        theirs.insert(placed);
                    });
                    let size = (width, height);
                    let ours = all.iter().map(|&placed| symmetry.map_variant(placed, size));
                    let ours: HashSet<_> = ours.collect();
                    prop_assert_eq!(ours, theirs);
                }
                let Some(&placed) = all.get(choice.checked_rem(all.len()).unwrap_or(0)) else {
                    break;
                };
                let mut moved = path.clone();
                prop_assert!(moved.apply_variant(placed));
                for symmetry in Symmetry::ALL {
                    let mut image = image_of(symmetry, &path);
                    let mapped = symmetry.map_variant(placed, (width, height));
                    prop_assert!(image.apply_variant(mapped));
                    let after = image_of(symmetry, &moved);
                    for cell in 0..width * height {
                        prop_assert_eq!(image.linked_right(cell), after.linked_right(cell));
                        prop_assert_eq!(image.linked_below(cell), after.linked_below(cell));
                    }
                }
                path = moved;
            }
        }
    }
}
