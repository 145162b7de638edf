//! Painted facets: the trees that slicers store for facets which are painted in part.
//!
//! PrusaSlicer (`slic3rpe:mmu_segmentation`), Bambu Studio and Orca Slicer (`paint_color`) give a
//! facet a string of hexadecimal digits, one for each node of a tree, read from its end:
//! - The low two bits are the number of sides that are split, 0 to 3.
//! - A **leaf** (0) has its state in the high two bits; 3 means that the state is in the next
//!   digits: each F adds 15, the first other digit adds its value, and 3 is added to the sum.
//!   State 0 is unpainted, state k is filament k.
//! - Other nodes have one child more than split sides, the last child first.
//!   The high two bits are the corner from which the sides are counted ([`Split::children`]).
//!
//! So "8" is filament 2, "1C" is filament 4, and "480C03" is a facet whose three sides are split,
//! with filaments 1, 2 and 3 at its corners and none in its middle.

/// Maximum depth of a tree.
/// Slicers stop at sides of a fraction of a millimetre; a facet of a metre reaches depth 14.
pub(super) const MAX_DEPTH: usize = 32;

/// A node of the tree of a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Node {
    /// A triangle with a state.
    Leaf(u32),
    /// A triangle whose children follow, the last one first.
    Split(Split),
}

/// How a triangle is split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Split {
    /// Number of sides that are split, 1 to 3.
    pub(super) sides: u8,
    /// The corner that counts as the first, 0 to 2.
    pub(super) first: u8,
}

impl Split {
    /// Number of children.
    pub(super) fn count(self) -> usize {
        usize::from(self.sides) + 1
    }

    /// The children of a triangle; `middle` returns the middle between two corners.
    ///
    /// The first corner is opposite to the split side if one side is split, and between the split
    /// sides if two are.
    /// All children face the way that the triangle faces.
    pub(super) fn children<T: Copy, E>(
        self,
        corners: [T; 3],
        mut middle: impl FnMut(T, T) -> Result<T, E>,
    ) -> Result<Vec<[T; 3]>, E> {
        let [a, b, c] = [0, 1, 2].map(|corner| corners[(usize::from(self.first) + corner) % 3]);
        Ok(match self.sides {
            1 => {
                let bc = middle(b, c)?;
                vec![[a, b, bc], [bc, c, a]]
            }
            2 => {
                let (ab, ca) = (middle(a, b)?, middle(c, a)?);
                vec![[a, ab, ca], [ab, b, ca], [b, c, ca]]
            }
            _ => {
                let (ab, bc, ca) = (middle(a, b)?, middle(b, c)?, middle(c, a)?);
                vec![[a, ab, ca], [ab, b, bc], [bc, c, ca], [ab, bc, ca]]
            }
        })
    }
}

/// Reads the nodes of a string, a parent before its children and the last child first.
struct Nodes<'a> {
    /// The digits that are left, from the end of the string.
    digits: std::iter::Rev<std::slice::Iter<'a, u8>>,
}

impl Nodes<'_> {
    fn digit(&mut self) -> Result<u32, String> {
        match self.digits.next() {
            None => Err("paint of a triangle ends inside a node".into()),
            Some(&byte) => char::from(byte).to_digit(16).ok_or_else(|| {
                let shown = char::from(byte).escape_default();
                format!("paint of a triangle contains '{shown}', expected hexadecimal digits")
            }),
        }
    }

    fn node(&mut self) -> Result<Node, String> {
        let digit = self.digit()?;
        let (sides, high) = (digit & 3, digit >> 2);
        if sides > 0 {
            if high == 3 {
                return Err(format!("paint of a triangle has the node {digit:X}: no such corner"));
            }
            return Ok(Node::Split(Split { sides: sides as u8, first: high as u8 }));
        }
        if high < 3 {
            return Ok(Node::Leaf(high));
        }
        let mut state = 3_u32;
        loop {
            let digit = self.digit()?;
            state = state.saturating_add(digit);
            if digit < 15 {
                return Ok(Node::Leaf(state));
            }
        }
    }
}

/// Reads a string that paints a facet.
/// Calls `visit` for every node: a parent before its children, the last child first.
pub(super) fn decode(
    text: &str,
    mut visit: impl FnMut(Node) -> Result<(), String>,
) -> Result<(), String> {
    let mut nodes = Nodes { digits: text.as_bytes().iter().rev() };
    // Number of children that are still to come, for each node on the way to the current one.
    let mut open = vec![1];
    while let Some(remaining) = open.last_mut() {
        if *remaining == 0 {
            open.pop();
            continue;
        }
        *remaining -= 1;
        let node = nodes.node()?;
        visit(node)?;
        if let Node::Split(split) = node {
            if open.len() > MAX_DEPTH {
                return Err(format!(
                    "paint of a triangle is divided more than {MAX_DEPTH} levels deep"
                ));
            }
            open.push(split.count());
        }
    }
    // Digits in front of the tree; zeros are padding.
    if nodes.digits.any(|&byte| byte != b'0') {
        return Err("paint of a triangle has digits that belong to no node".into());
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A tree, for tests.
    #[derive(Clone, Debug, PartialEq)]
    pub(in crate::read::threemf) enum Tree {
        Leaf(u32),
        Split(Split, Vec<Self>),
    }

    impl Tree {
        /// The string of a tree.
        pub(in crate::read::threemf) fn encode(&self) -> String {
            match self {
                Self::Leaf(state @ ..3) => format!("{:X}", state << 2),
                Self::Leaf(state) => {
                    let escapes = (state - 3) / 15;
                    format!("{:X}{}C", (state - 3) % 15, "F".repeat(escapes as usize))
                }
                Self::Split(split, children) => {
                    let digit = u32::from(split.first) << 2 | u32::from(split.sides);
                    children.iter().map(Self::encode).collect::<String>() + &format!("{digit:X}")
                }
            }
        }

        /// Adds the area of each state inside a triangle, by recursion.
        pub(in crate::read::threemf) fn areas(
            &self,
            corners: [[f64; 3]; 3],
            areas: &mut std::collections::BTreeMap<u32, f64>,
        ) {
            match self {
                Self::Leaf(state) => *areas.entry(*state).or_default() += area(corners),
                Self::Split(split, children) => {
                    let middle = |a: [f64; 3], b: [f64; 3]| {
                        Ok::<_, ()>([0, 1, 2].map(|axis| f64::midpoint(a[axis], b[axis])))
                    };
                    let parts = split.children(corners, middle).unwrap();
                    children.iter().zip(parts).for_each(|(child, part)| child.areas(part, areas));
                }
            }
        }

        fn decode(text: &str) -> Result<Self, String> {
            let mut nodes = Vec::new();
            decode(text, |node| {
                nodes.push(node);
                Ok(())
            })?;
            Ok(Self::from_nodes(&mut nodes.into_iter()))
        }

        fn from_nodes(nodes: &mut impl Iterator<Item = Node>) -> Self {
            match nodes.next().unwrap() {
                Node::Leaf(state) => Self::Leaf(state),
                Node::Split(split) => {
                    let mut children: Vec<_> =
                        (0..split.count()).map(|_| Self::from_nodes(nodes)).collect();
                    children.reverse();
                    Self::Split(split, children)
                }
            }
        }
    }

    pub(in crate::read::threemf) fn area(corners: [[f64; 3]; 3]) -> f64 {
        let [a, b, c] = corners;
        let minus = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|axis| p[axis] - q[axis]);
        let ([ux, uy, uz], [vx, vy, vz]) = (minus(b, a), minus(c, a));
        let normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
        normal.iter().map(|value| value * value).sum::<f64>().sqrt() / 2.0
    }

    /// Trees up to a depth, with states 0 to 40.
    pub(in crate::read::threemf) fn trees(depth: u32) -> impl Strategy<Value = Tree> {
        (0..41_u32).prop_map(Tree::Leaf).prop_recursive(depth, 200, 4, |inner| {
            (1..4_u8, 0..3_u8, prop::collection::vec(inner, 4)).prop_map(
                |(sides, first, mut children)| {
                    children.truncate(usize::from(sides) + 1);
                    Tree::Split(Split { sides, first }, children)
                },
            )
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn strings_are_those_of_their_trees(tree in trees(6)) {
            let text = tree.encode();
            prop_assert_eq!(Tree::decode(&text), Ok(tree.clone()));
            prop_assert_eq!(Tree::decode(&text.to_lowercase()), Ok(tree));
        }

        #[test]
        fn any_string_has_a_tree_or_an_error(text in "[0-9A-Fa-f ]{0,40}|.{0,10}") {
            if let Ok(tree) = Tree::decode(&text) {
                let canonical = tree.encode();
                let text = text.to_uppercase();
                let given = text.trim().trim_start_matches('0');
                prop_assert_eq!(given, canonical.trim_start_matches('0'));
            }
        }
    }

    // prusa3d/PrusaSlicer#13900, bambulab/BambuStudio: states of whole facets
    #[test]
    fn known_strings_have_known_states() {
        for (text, state) in
            [("0", 0), ("4", 1), ("8", 2), ("0C", 3), ("1C", 4), ("2C", 5), ("EC", 17)]
        {
            assert_eq!(Tree::decode(text), Ok(Tree::Leaf(state)), "{text}");
        }
        assert_eq!(Tree::decode("0FC"), Ok(Tree::Leaf(18)));
        let split = Split { sides: 3, first: 0 };
        let leaves = [1, 2, 3, 0].map(Tree::Leaf).to_vec();
        assert_eq!(Tree::decode("480C03"), Ok(Tree::Split(split, leaves)));
    }

    #[test]
    fn malformed_strings_are_refused() {
        for (text, message) in [
            ("", "ends inside a node"),
            ("C", "ends inside a node"),
            ("FC", "ends inside a node"),
            ("443", "ends inside a node"),
            ("44D", "has the node D: no such corner"),
            ("4G", "contains 'G', expected hexadecimal digits"),
            ("é", "expected hexadecimal digits"),
            ("44", "digits that belong to no node"),
        ] {
            let error = Tree::decode(text).unwrap_err();
            assert!(error.contains(message), "{text}: {error}");
        }
        let deep = "4".repeat(40) + &"1".repeat(40);
        assert!(Tree::decode(&deep).unwrap_err().contains("more than 32 levels"));
    }
}
