//! States of the dynamic program.

/// The byte of an end that has a link, and of a slot without an end.
pub(super) const CLOSED: u8 = 255;
/// The byte of an end without a link, whose fragment cannot be closed to a cycle: its other end was
/// given up, or is not known.
pub(super) const FREE: u8 = 254;
/// The byte of a flag that forbids a link.
pub(super) const FORBIDDEN: u8 = 253;

/// The byte of an end that some of the states that a state stands for can still link, and others
/// cannot: giving it up costs nothing.
pub(super) const OPTIONAL: u8 = 252;

/// Number of no node: that of a state before the first link.
pub(super) const ROOT: u32 = u32::MAX;
/// Number of no node: that of a state that stands for several.
pub(super) const MERGED: u32 = u32::MAX - 1;

/// Whether a byte is that of an end that may be linked.
#[inline]
pub(super) fn is_free(byte: u8) -> bool {
    byte != CLOSED && byte != FORBIDDEN
}

/// A set of states after a step, one byte for each slot.
///
/// The byte of an end without a link is the slot of the other end of its *fragment*, the sequence
/// of lines and links that it ends.
#[derive(Default)]
pub(super) struct States {
    stride: usize,
    bytes: Vec<u8>,
    pub(super) labels: Vec<Label>,
    /// Open addressing: indices of states plus 1, and 0 for a vacancy.
    table: Vec<u32>,
}

/// What is known of a state besides its bytes.
#[derive(Clone, Copy)]
pub(super) struct Label {
    /// Ends given up so far: they remain ends of beads.
    pub(super) given_up: u32,
    /// Number of ends without a link in the frontier.
    pub(super) free: u32,
    /// Last link of the state, as a node of [`History`].
    pub(super) node: u32,
}

impl States {
    /// No states of a number of slots.
    pub(super) fn reset(&mut self, slots: usize) {
        self.stride = slots.next_multiple_of(8).max(8);
        self.clear();
    }

    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        self.labels.clear();
        self.table.fill(0);
    }

    pub(super) fn len(&self) -> usize {
        self.labels.len()
    }

    pub(super) fn stride(&self) -> usize {
        self.stride
    }

    #[inline]
    pub(super) fn bytes(&self, index: usize) -> &[u8] {
        &self.bytes[index * self.stride..(index + 1) * self.stride]
    }

    #[inline]
    pub(super) fn bytes_mut(&mut self, index: usize) -> &mut [u8] {
        &mut self.bytes[index * self.stride..(index + 1) * self.stride]
    }

    /// Inserts a state; of two with the same bytes the one that gave up fewer ends stays.
    pub(super) fn insert(&mut self, bytes: &[u8], label: Label) {
        if self.labels.len() * 2 >= self.table.len() {
            self.grow();
        }
        let mask = self.table.len() - 1;
        let mut at = hash(bytes) as usize & mask;
        loop {
            match self.table[at] as usize {
                0 => break,
                index if self.bytes(index - 1) == bytes => {
                    let known = &mut self.labels[index - 1];
                    if label.given_up < known.given_up {
                        *known = label;
                    }
                    return;
                }
                _ => at = (at + 1) & mask,
            }
        }
        self.bytes.extend_from_slice(bytes);
        self.labels.push(label);
        self.table[at] = self.labels.len() as u32;
    }

    fn grow(&mut self) {
        let size = (self.table.len() * 2).max(64);
        self.table.clear();
        self.table.resize(size, 0);
        for index in 0..self.labels.len() {
            let mut at = hash(self.bytes(index)) as usize & (size - 1);
            while self.table[at] != 0 {
                at = (at + 1) & (size - 1);
            }
            self.table[at] = index as u32 + 1;
        }
    }

    /// Whether state `b` and its best completion give up at most `limit` ends more than state `a`
    /// and its best completion, apart from those that they gave up before.
    /// May return false if that is so.
    ///
    /// From the links that complete a, drop those at ends that b cannot link, one of those at each
    /// pair of ends of a fragment of b that a does not have, and those that b forbids.
    /// The rest completes b: a cycle would consist of fragments that a has too.
    /// Each dropped link leaves its ends without a link, and so are ends that only b has to link.
    pub(super) fn is_within(a: &[u8], b: &[u8], limit: u32) -> bool {
        let mut cost = 0;
        let words = a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0);
        for (word, (in_a, in_b)) in words.enumerate() {
            if in_a == in_b {
                continue;
            }
            for (at, (&in_a, &in_b)) in in_a.iter().zip(in_b).enumerate() {
                if in_a == in_b {
                    continue;
                }
                cost += match (is_free(in_a), is_free(in_b)) {
                    (true, false) => 1,
                    (false, true) => u32::from(in_b != OPTIONAL),
                    (true, true) if in_a == OPTIONAL => 1,
                    _ => 0,
                };
                let is_joined = in_b < OPTIONAL
                    && is_free(in_a)
                    && 8 * word + at < in_b as usize
                    && is_free(a[in_b as usize]);
                cost += 2 * u32::from(in_b == FORBIDDEN || is_joined);
            }
            if cost > limit {
                return false;
            }
        }
        true
    }
}

/// A hash of bytes whose number is a multiple of 8.
fn hash(bytes: &[u8]) -> u64 {
    let mut hash = 0_u64;
    for &word in bytes.as_chunks::<8>().0 {
        hash = (hash.rotate_left(5) ^ u64::from_le_bytes(word)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        hash ^= hash >> 32;
    }
    hash
}

/// The links of states, as trees whose nodes know their parents.
#[derive(Default)]
pub(super) struct History {
    /// Parent and link of each node.
    nodes: Vec<[u32; 2]>,
    /// Number of nodes at which unused nodes are removed.
    limit: usize,
}

impl History {
    pub(super) fn clear(&mut self) {
        self.nodes.clear();
        self.limit = 1 << 16;
    }

    /// The node of a state that adds a link to another.
    #[inline]
    pub(super) fn push(&mut self, parent: u32, link: u32) -> u32 {
        if parent == MERGED {
            return MERGED;
        }
        self.nodes.push([parent, link]);
        self.nodes.len() as u32 - 1
    }

    /// The links of a state, the last one first.
    pub(super) fn links(&self, mut node: u32) -> Vec<u32> {
        let mut links = Vec::new();
        while let Some(&[parent, link]) = self.nodes.get(node as usize) {
            links.push(link);
            node = parent;
        }
        links
    }

    /// Removes nodes that no state needs, if there are many nodes.
    pub(super) fn compact(&mut self, states: &mut States) {
        if self.nodes.len() < self.limit {
            return;
        }
        let mut is_needed = vec![false; self.nodes.len()];
        for label in &states.labels {
            let mut node = label.node;
            while let Some(needed) = is_needed.get_mut(node as usize)
                && !std::mem::replace(needed, true)
            {
                node = self.nodes[node as usize][0];
            }
        }
        // Parents come before their children.
        let mut numbers = vec![0; self.nodes.len()];
        let mut count = 0;
        let renumbered =
            |numbers: &[u32], node: u32| numbers.get(node as usize).copied().unwrap_or(node);
        for node in 0..self.nodes.len() {
            if is_needed[node] {
                let [parent, link] = self.nodes[node];
                self.nodes[count] = [renumbered(&numbers, parent), link];
                numbers[node] = count as u32;
                count += 1;
            }
        }
        self.nodes.truncate(count);
        for label in &mut states.labels {
            label.node = renumbered(&numbers, label.node);
        }
        self.limit = (2 * count).max(1 << 16);
    }
}
