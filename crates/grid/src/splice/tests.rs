//! Compares all moves with a slow walk along the links.

use std::collections::HashSet;

use beadwork_base::Control;
use proptest::prelude::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::{Links, PlacedVariant, Region, Start, Variant, cover, verify};

/// Reference implementation: a path as a set of links, changed and checked by definition.
struct Walker {
    width: u32,
    /// Links between neighbours and jumps between pieces, each with the lower cell first.
    links: HashSet<(Cell, Cell)>,
    first: Cell,
    cells: usize,
}

impl Walker {
    fn new(path: &Path) -> Self {
        let link = |step: &[Cell]| (step[0].min(step[1]), step[0].max(step[1]));
        Self {
            width: path.width(),
            links: path.order().windows(2).map(link).collect(),
            first: path.order()[0],
            cells: path.order().len(),
        }
    }

    /// Applies a switch if exactly its two links are present.
    fn switch(&mut self, region: &Region, switch: Switch) -> bool {
        let (x, y) = region.xy(switch.corner());
        if x + 1 >= region.width() || y + 1 >= region.height() {
            return false;
        }
        let a = switch.corner();
        let (b, c, d) = (a + 1, a + self.width, a + self.width + 1);
        let (out, into) = match switch.from() {
            Sides::Horizontal => ([(a, b), (c, d)], [(a, c), (b, d)]),
            Sides::Vertical => ([(a, c), (b, d)], [(a, b), (c, d)]),
        };
        let applies = out.iter().all(|link| self.links.contains(link))
            && into.iter().all(|link| !self.links.contains(link));
        if applies {
            out.iter().for_each(|link| assert!(self.links.remove(link)));
            self.links.extend(into);
        }
        applies
    }

    /// The order of the cells from the first one, if following the links visits every cell.
    fn walk(&self) -> Option<Vec<Cell>> {
        let mut next = std::collections::HashMap::<Cell, Vec<Cell>>::new();
        for &(a, b) in &self.links {
            next.entry(a).or_default().push(b);
            next.entry(b).or_default().push(a);
        }
        let mut order = vec![self.first];
        let (mut before, mut cell) = (Cell::MAX, self.first);
        while let Some(&after) =
            next.get(&cell).and_then(|others| others.iter().find(|&&other| other != before))
        {
            order.push(after);
            (before, cell) = (cell, after);
            assert!(order.len() <= self.cells, "a walk along links can't return to its first cell");
        }
        (order.len() == self.cells).then_some(order)
    }

    /// The order that the switches should lead to; `None` if they should be refused.
    fn expect(path: &Path, region: &Region, switches: &[Switch]) -> Option<Vec<Cell>> {
        let mut walker = Self::new(path);
        switches
            .iter()
            .all(|&switch| walker.switch(region, switch))
            .then(|| walker.walk())
            .flatten()
    }
}

fn random_region(rng: &mut ChaCha8Rng) -> Region {
    let (width, height) = (rng.random_range(1..=12), rng.random_range(1..=12));
    match rng.random_range(0..3) {
        0 => Region::rectangle(width, height).unwrap(),
        1 => {
            // Few missing cells, so that pieces are long.
            let mut inside = vec![true; (width * height) as usize];
            for _ in 0..rng.random_range(0..4) {
                let hole = rng.random_range(0..inside.len());
                inside[hole] = false;
            }
            Region::from_mask(width, height, inside)
                .unwrap_or_else(|_| Region::rectangle(1, 1).unwrap())
        }
        _ => {
            let inside = (0..width * height).map(|_| rng.random_range(0..10) < 7).collect();
            Region::from_mask(width, height, inside)
                .unwrap_or_else(|_| Region::rectangle(1, 1).unwrap())
        }
    }
}

fn random_path(region: &Region, rng: &mut ChaCha8Rng) -> Path {
    let starts = Start::ALL[rng.random_range(0..4)].path(region, &Control::default());
    let mut path = starts.unwrap_or_else(|_| cover(region, &Control::default()).unwrap());
    for _ in 0..rng.random_range(0..200) {
        let pair = random_pair(&path, rng);
        path.apply(&pair);
    }
    path
}

/// Draws two switches, usually near each other, that apply more often than random ones.
fn random_pair(path: &Path, rng: &mut ChaCha8Rng) -> [Switch; 2] {
    let cells = path.width() * path.height();
    let likely =
        (0..20).map(|_| rng.random_range(0..cells)).find(|&corner| path.sides(corner).is_some());
    let first = likely.unwrap_or_else(|| rng.random_range(0..cells));
    let near = |rng: &mut ChaCha8Rng| {
        let steps = [1, path.width(), path.width() + 1, path.width().wrapping_sub(1), 2, 0];
        let step = steps[rng.random_range(0..steps.len())];
        let other = if rng.random() { first.wrapping_add(step) } else { first.wrapping_sub(step) };
        other.min(cells)
    };
    let second = if rng.random_range(0..4) > 0 { near(rng) } else { rng.random_range(0..cells) };
    [first, second].map(|corner| {
        let likely = path.sides(corner.min(cells - 1)).filter(|_| rng.random_range(0..4) > 0);
        Switch::new(
            corner,
            likely.unwrap_or(if rng.random() { Sides::Horizontal } else { Sides::Vertical }),
        )
    })
}

/// Checks that switches are applied as expected and undone, or refused.
fn check(path: &Path, region: &Region, switches: &[Switch], expected: Option<Vec<Cell>>) {
    let mut changed = path.clone();
    let applied = changed.apply(switches);
    assert_eq!(applied, expected.is_some(), "{switches:?} on {:?}", path.order());
    let Some(expected) = expected else {
        assert_eq!(&changed, path, "a refused move changes nothing");
        return;
    };
    assert_eq!(changed.order(), expected);
    assert_eq!(verify(region, changed.order()), Ok(path.pieces()));
    let fresh = Path::in_pieces(region, changed.order().to_vec()).unwrap();
    assert_eq!((&changed.position, &changed.links), (&fresh.position, &fresh.links));
    changed.undo(switches);
    assert_eq!(
        (&changed.order, &changed.position, &changed.links),
        (&path.order, &path.position, &path.links)
    );
}

/// Counts of the cases that a sweep met.
#[derive(Default)]
struct Met {
    /// Pairs that apply, by the distance of the unit cells (apart, touching at a corner, side by
    /// side) and by the result (one path, or a path and a cycle).
    pairs: [[usize; 2]; 3],
    /// Variants that apply, by class.
    variants: [usize; 12],
}

/// Checks `sites` pairs of switches and `sites` variants on a random path in a random region.
fn sweep(seed: u64, sites: usize, met: &mut Met) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let region = random_region(&mut rng);
    let path = random_path(&region, &mut rng);
    for _ in 0..sites {
        let pair = random_pair(&path, &mut rng);
        let expected = Walker::expect(&path, &region, &pair);
        let mut walker = Walker::new(&path);
        if pair.iter().all(|&switch| walker.switch(&region, switch)) {
            let [(ax, ay), (bx, by)] = pair.map(|switch| region.xy(switch.corner()));
            let near = match (ax.abs_diff(bx), ay.abs_diff(by)) {
                (0 | 1, 0) | (0, 1) => 2,
                (1, 1) => 1,
                _ => 0,
            };
            met.pairs[near][usize::from(expected.is_none())] += 1;
        }
        assert_eq!(
            path.allows_pair(pair[0], pair[1]),
            expected.is_some(),
            "{pair:?} on {:?}",
            path.order()
        );
        assert_eq!(path.allows(&pair), expected.is_some());
        check(&path, &region, &pair, expected);

        let (x, y) = (
            rng.random_range(0..region.width()) as u16,
            rng.random_range(0..region.height()) as u16,
        );
        let any = PlacedVariant { variant: Variant::ALL[rng.random_range(0..12)], x, y };
        let matching = Variant::ALL
            .into_iter()
            .map(|variant| PlacedVariant { variant, x, y })
            .find(|&at| path.allows_variant(at));
        let placed = matching.unwrap_or(any);
        met.variants[usize::from(placed.variant.class())] +=
            usize::from(check_variant(&path, &region, placed));
    }
}

/// Checks a variant by the rule of the paper: it applies if the window contains exactly the
/// required links and the result is one path.
/// Returns whether it applies.
fn check_variant(path: &Path, region: &Region, placed: PlacedVariant) -> bool {
    let (columns, rows) = placed.variant.window();
    let (x, y) = (u32::from(placed.x), u32::from(placed.y));
    let fits = x + columns <= region.width() && y + rows <= region.height();
    let expected = fits
        .then(|| {
            let cell = |n: u32| region.cell(x + n % columns, y + n / columns);
            let number = |c: Cell| (0..columns * rows).find(|&n| cell(n) == c);
            let inside = |&(a, b): &(Cell, Cell)| {
                Some((number(a)?, number(b)?)).filter(|_| region.adjacent(a, b))
            };
            let mut walker = Walker::new(path);
            let mut present: Vec<_> = walker.links.iter().filter_map(inside).collect();
            present.sort_unstable();
            let (kept, removed, added) = table(placed.variant);
            let mut required: Vec<_> = kept.iter().chain(&removed).copied().collect();
            required.sort_unstable();
            if present != required {
                return None;
            }
            removed.iter().for_each(|&(a, b)| assert!(walker.links.remove(&(cell(a), cell(b)))));
            walker.links.extend(added.iter().map(|&(a, b)| (cell(a), cell(b))));
            Some(walker.walk().expect("the required links are enough"))
        })
        .flatten();
    let valid = expected.is_some();
    assert_eq!(path.allows_variant(placed), valid, "{placed:?} on {:?}", path.order());
    let mut found = false;
    path.for_each_variant(&[placed.variant.kind()], |other| found |= other == placed);
    assert_eq!(found, valid);
    let mut changed = path.clone();
    assert_eq!(changed.apply_variant(placed), valid);
    let mut links = Links::new(path);
    assert_eq!(links.allows_variant(placed), valid);
    assert_eq!(links.apply_variant(placed), valid);
    assert_eq!(links, Links::new(&changed), "{placed:?}");
    if valid {
        links.undo_variant(placed);
    }
    assert_eq!(links, Links::new(path), "{placed:?}");
    let mut found = false;
    links.for_each_variant_at(placed.x, placed.y, |other| found |= other == placed);
    assert_eq!(found, valid, "{placed:?}");
    assert_eq!(changed.order(), expected.as_deref().unwrap_or(path.order()));
    valid
}

type Pairs = Vec<(u32, u32)>;

/// The tables of Aali et al., typed a second time, independently of those under test.
fn table(variant: Variant) -> (Pairs, Pairs, Pairs) {
    let parse = |text: &str| -> Pairs {
        let digit = |byte: u8| u32::from(byte - b'0');
        text.split(' ').map(|pair| (digit(pair.as_bytes()[0]), digit(pair.as_bytes()[1]))).collect()
    };
    let row = match variant {
        Variant::Sr => ["12 25 67", "01 34 45 78", "03 14 47 58"],
        Variant::Nl => ["12 36 67", "01 34 45 78", "03 14 47 58"],
        Variant::Wa => ["12 25 36", "03 14 47 58", "01 34 45 78"],
        Variant::Eb => ["25 36 67", "03 14 47 58", "01 34 45 78"],
        Variant::Sl => ["01 03 78", "12 34 45 67", "14 25 36 47"],
        Variant::Nr => ["01 58 78", "12 34 45 67", "14 25 36 47"],
        Variant::Ea => ["01 03 58", "14 25 36 47", "12 34 45 67"],
        Variant::Wb => ["03 58 78", "14 25 36 47", "12 34 45 67"],
        Variant::W => ["14", "03 12 45", "01 25 34"],
        Variant::E => ["14", "01 25 34", "03 12 45"],
        Variant::N => ["23", "01 24 35", "02 13 45"],
        Variant::S => ["23", "02 13 45", "01 24 35"],
    };
    let [kept, removed, added] = row.map(parse);
    (kept, removed, added)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 10_000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// 10,000 paths with 50 pairs and 50 variants each: a million sites.
    #[test]
    fn moves_agree_with_the_walk(seed: u64) {
        sweep(seed, 50, &mut Met::default());
    }

    #[test]
    fn longer_combinations_agree_with_the_walk(seed: u64, length in 0_usize..8) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let region = random_region(&mut rng);
        let path = random_path(&region, &mut rng);
        let cells = region.grid_len() as Cell;
        // Almost every switch applies after those before it; a few need not apply.
        let mut switches = Vec::new();
        let mut walker = Walker::new(&path);
        while switches.len() < length {
            let corner = rng.random_range(0..cells);
            let likely = [Sides::Horizontal, Sides::Vertical].map(|from| Switch::new(corner, from));
            let applies = likely.into_iter().find(|&switch| walker.switch(&region, switch));
            let any = || (rng.random_range(0..50) == 0).then_some(likely[0]);
            if let Some(switch) = applies.or_else(any) {
                switches.push(switch);
            } else if rng.random_range(0..500) == 0 {
                break;
            }
        }
        let expected = Walker::expect(&path, &region, &switches);
        prop_assert_eq!(path.allows(&switches), expected.is_some());
        check(&path, &region, &switches, expected);
    }
}

#[test]
fn the_sweep_meets_every_case() {
    let mut met = Met::default();
    (0..3000).for_each(|seed| sweep(seed, 50, &mut met));
    assert!(met.pairs.iter().flatten().all(|&count| count > 100), "{:?}", met.pairs);
    assert!(met.variants.iter().all(|&count| count > 50), "{:?}", met.variants);
}

#[test]
fn switches_outside_the_grid_are_refused() {
    let region = Region::rectangle(3, 3).unwrap();
    let path = Start::RowZigzag.path(&region, &Control::default()).unwrap();
    for corner in [2, 5, 6, 8, 9, 1_000_000] {
        let switch = Switch::new(corner, Sides::Horizontal);
        assert!(!path.allows(&[switch]));
        assert!(!path.allows_pair(switch, switch));
    }
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let placed = PlacedVariant { variant: Variant::Sr, x: rng.next_u32() as u16 | 4, y: 0 };
    assert!(!path.allows_variant(placed));
}
