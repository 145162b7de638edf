//! Divides the painted facets of a mesh into triangles of one state each.
//!
//! Where a facet is divided and its neighbour is not, or less, the middle of their common side lies
//! inside a side of the neighbour (a T-junction), and the surface is no longer closed.
//! So the neighbour is divided as well, at exactly these points: the middle of a side is one vertex
//! for all facets that share the side, and every triangle whose side has such a vertex is split
//! there.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use super::painting::{MAX_DEPTH, Node, Split, decode};

/// Triangles that are divided no further, and their states.
#[derive(Debug, Default)]
pub(super) struct Divided {
    pub(super) triangles: Vec<[u32; 3]>,
    /// The state of each triangle.
    pub(super) states: Vec<u8>,
    /// For each facet the number of its first triangle, and at the end the number of triangles.
    pub(super) first_of: Vec<u32>,
}

/// The strings of facets that are divided, in the order of the facets.
#[derive(Debug, Default)]
pub(super) struct Trees {
    /// Facets, and the ends of their strings in `text`.
    ends: Vec<(u32, usize)>,
    text: String,
}

impl Trees {
    /// Adds the string of a facet; the facet must be beyond those before.
    pub(super) fn push(&mut self, facet: u32, text: &str) {
        self.text.push_str(text);
        self.ends.push((facet, self.text.len()));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    fn iter(&self) -> impl Iterator<Item = (u32, &str)> {
        let mut start = 0;
        self.ends.iter().map(move |&(facet, end)| {
            let text = &self.text[start..end];
            start = end;
            (facet, text)
        })
    }
}

/// A fast hash of a pair of vertices: sides are looked up several times for each triangle.
#[derive(Default)]
pub(super) struct SideHasher(u64);

impl std::hash::Hasher for SideHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(u64::from(byte)));
    }

    fn write_u64(&mut self, value: u64) {
        // Multiplication mixes upwards, and the rotation brings the mixed bits down again.
        self.0 = (self.0 ^ value).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(26);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

/// Vertices in the middle of sides, by the numbers of the ends, packed with the lower one first.
type Middles = HashMap<u64, u32, BuildHasherDefault<SideHasher>>;

fn side(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

/// Divides facets with trees, and the neighbours that this leaves with vertices on their sides.
///
/// `states` holds the states of facets without trees; missing ones are 0. Adds vertices; facets
/// that refer to vertices which do not exist are left as they are.
/// The error is the maximum number of triangles, if there would be more than `max_triangles`.
pub(super) fn divide(
    vertices: &mut Vec<[f64; 3]>,
    facets: &[[u32; 3]],
    states: &[u8],
    trees: &Trees,
    max_triangles: usize,
) -> Result<Divided, usize> {
    let facets = share_vertices(vertices, facets);
    let mut middles = Middles::default();
    let mut leaves = Vec::new();
    for (facet, text) in trees.iter() {
        let corners = facets[facet as usize];
        if !is_divisible(corners, vertices.len()) {
            continue;
        }
        // The triangles whose nodes are still to come, the next one last.
        let mut open = Vec::with_capacity(4 * MAX_DEPTH);
        open.push(corners);
        let visited = decode(text, |node| {
            let Some(corners) = open.pop() else { return Ok(()) };
            match node {
                Node::Leaf(state) => leaves.push((facet, corners, state as u8)),
                Node::Split(split) => {
                    let middle = |a, b| middle(vertices, &mut middles, a, b);
                    open.extend(split.children(corners, middle).map_err(|()| String::new())?);
                }
            }
            Ok(())
        });
        if visited.is_err() || leaves.len() > max_triangles {
            return Err(max_triangles);
        }
    }
    let mut divided = Divided::default();
    let mut leaves = leaves.into_iter().peekable();
    for (number, &corners) in facets.iter().enumerate() {
        divided.first_of.push(divided.triangles.len() as u32);
        if !is_divisible(corners, vertices.len()) {
            divided.triangles.push(corners);
            divided.states.push(states.get(number).copied().unwrap_or_default());
            continue;
        }
        if leaves.peek().is_none_or(|leaf| leaf.0 as usize != number) {
            let state = states.get(number).copied().unwrap_or_default();
            conform(corners, state, &middles, &mut divided, max_triangles)?;
        }
        while let Some((_, corners, state)) = leaves.next_if(|leaf| leaf.0 as usize == number) {
            conform(corners, state, &middles, &mut divided, max_triangles)?;
        }
    }
    divided.first_of.push(divided.triangles.len() as u32);
    Ok(divided)
}

/// Whether a facet has three different corners that exist.
/// Of a facet whose sides coincide, each split would split several children.
fn is_divisible([a, b, c]: [u32; 3], vertices: usize) -> bool {
    a != b && b != c && c != a && [a, b, c].iter().all(|&corner| (corner as usize) < vertices)
}

/// The facets with one vertex for each position, so that neighbours share the middles of sides.
fn share_vertices(vertices: &[[f64; 3]], facets: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut first_at = HashMap::with_capacity(vertices.len());
    let shared: Vec<u32> = (0_u32..)
        .zip(vertices)
        // Adding 0 turns -0 into 0.
        .map(|(number, point)| {
            *first_at.entry(point.map(|value| (value + 0.0).to_bits())).or_insert(number)
        })
        .collect();
    let share = |&vertex: &u32| shared.get(vertex as usize).copied().unwrap_or(vertex);
    facets.iter().map(|facet| [0, 1, 2].map(|corner| share(&facet[corner]))).collect()
}

/// The vertex in the middle of a side, which is added if it is new.
fn middle(vertices: &mut Vec<[f64; 3]>, middles: &mut Middles, a: u32, b: u32) -> Result<u32, ()> {
    let next = u32::try_from(vertices.len()).map_err(|_| ())?;
    let number = *middles.entry(side(a, b)).or_insert(next);
    if number == next {
        let (a, b) = (vertices[a as usize], vertices[b as usize]);
        vertices.push([0, 1, 2].map(|axis| f64::midpoint(a[axis], b[axis])));
    }
    Ok(number)
}

/// Adds a triangle, split at the vertices that are in the middle of its sides.
///
/// A split adds no vertex, and replaces each corner that it moves by the middle of a side, which is
/// one level deeper than the ends of the side.
/// So the recursion is at most three times as deep as the trees.
fn conform(
    corners: [u32; 3],
    state: u8,
    middles: &Middles,
    divided: &mut Divided,
    max_triangles: usize,
) -> Result<(), usize> {
    let [a, b, c] = corners;
    let has_middle = |from, to| middles.contains_key(&side(from, to));
    // The number of sides with a middle, and the corner that `Split` counts from.
    let split = match [has_middle(a, b), has_middle(b, c), has_middle(c, a)] {
        [false, false, false] => {
            if divided.triangles.len() >= max_triangles {
                return Err(max_triangles);
            }
            divided.triangles.push(corners);
            divided.states.push(state);
            return Ok(());
        }
        [true, true, true] => Split { sides: 3, first: 0 },
        [false, true, false] => Split { sides: 1, first: 0 },
        [false, false, true] => Split { sides: 1, first: 1 },
        [true, false, false] => Split { sides: 1, first: 2 },
        [true, false, true] => Split { sides: 2, first: 0 },
        [true, true, false] => Split { sides: 2, first: 1 },
        [false, true, true] => Split { sides: 2, first: 2 },
    };
    let middle = |from, to| middles.get(&side(from, to)).copied().ok_or(max_triangles);
    for child in split.children(corners, middle)? {
        conform(child, state, middles, divided, max_triangles)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::super::painting::tests::{Tree, area, trees};
    use super::*;
    use crate::solid::Solid;

    const BOX: Solid = Solid::Cuboid { size_mm: [3.0, 5.0, 7.0] };

    /// Whether each side is used once in each direction.
    fn is_closed(triangles: &[[u32; 3]]) -> bool {
        let mut sides = HashMap::new();
        for &[a, b, c] in triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *sides.entry((from, to)).or_insert(0) += 1;
            }
        }
        sides.iter().all(|(&(from, to), &count)| count == 1 && sides.contains_key(&(to, from)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        /// Twin: areas of the trees by recursion.
        #[test]
        fn areas_are_those_of_the_trees_and_the_surface_is_closed(
            painted in prop::collection::vec((0..12_u32, trees(6)), 1..6),
            split_vertices in any::<bool>(),
        ) {
            let mesh = BOX.mesh();
            let (mut vertices, mut facets) = (mesh.vertices().to_vec(), mesh.triangles().to_vec());
            if split_vertices {
                // As in files of programs that do not share vertices.
                vertices = facets.iter().flat_map(|&facet| mesh.corners(facet)).collect();
                facets = (0..12).map(|facet| [3 * facet, 3 * facet + 1, 3 * facet + 2]).collect();
            }
            let painted: BTreeMap<u32, Tree> = painted.into_iter().collect();
            let (mut strings, mut expected) = (Trees::default(), BTreeMap::new());
            for facet in 0..12_u32 {
                let corners = facets[facet as usize].map(|vertex| vertices[vertex as usize]);
                match painted.get(&facet) {
                    None => Tree::Leaf(5).areas(corners, &mut expected),
                    Some(tree) => {
                        strings.push(facet, &tree.encode());
                        tree.areas(corners, &mut expected);
                    }
                }
            }
            let divided = divide(&mut vertices, &facets, &[5; 12], &strings, 1_000_000).unwrap();
            prop_assert!(is_closed(&divided.triangles));
            let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
            for (&triangle, &state) in divided.triangles.iter().zip(&divided.states) {
                let corners = triangle.map(|vertex| vertices[vertex as usize]);
                *areas.entry(u32::from(state)).or_default() += area(corners);
            }
            prop_assert_eq!(areas.len(), expected.len());
            for (state, area) in areas {
                let expected: f64 = expected[&state];
                prop_assert!((area - expected).abs() <= 1e-9 * expected, "{area} {expected}");
            }
            prop_assert_eq!(divided.first_of.len(), 13);
            prop_assert!(divided.first_of.is_sorted());
        }
    }

    #[test]
    fn a_neighbour_that_is_not_painted_is_split_at_the_common_side() {
        let mesh = BOX.mesh();
        let mut vertices = mesh.vertices().to_vec();
        let mut trees = Trees::default();
        trees.push(0, "44443");
        let divided = divide(&mut vertices, mesh.triangles(), &[], &trees, 100).unwrap();
        // Three neighbours are cut in two.
        assert_eq!((vertices.len(), divided.triangles.len()), (11, 18));
        assert!(is_closed(&divided.triangles));
        assert_eq!(divided.states.iter().filter(|state| **state == 1).count(), 4);
        assert_eq!(divide(&mut vertices, mesh.triangles(), &[], &trees, 17).unwrap_err(), 17);
    }
}
