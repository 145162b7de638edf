//! The nearest seed of every cell of a rectangle: an exact Euclidean feature transform.
//!
//! The first pass finds the nearest seed within each column.
//! In the second pass, along each row, column `i` with a seed `g` rows away offers the squared
//! distance `(x - i)² + g²` to every cell `x` of the row: a parabola.
//! The lower envelope of all parabolas, built from left to right with a stack, gives the nearest
//! seeds (Meijster, Roerdink and Hesselink 2000; Felzenszwalb and Huttenlocher 2012).

/// Stands for the row of a seed in a column without one.
const NO_SEED: u32 = u32::MAX;

/// For each cell, row by row, the index of a nearest seed; `None` if there is no seed.
///
/// Linear in the cells.
pub(super) fn nearest_seeds(width: usize, is_seed: &[bool]) -> Option<Vec<u32>> {
    if !is_seed.contains(&true) {
        return None;
    }
    let height = is_seed.len() / width;
    let in_column = nearest_in_columns(width, is_seed);
    let mut nearest = vec![0; is_seed.len()];
    // Columns on the envelope, and the first cell at which each is the lowest.
    let mut envelope: Vec<(i64, i64)> = Vec::with_capacity(width);
    for row in 0..height {
        let seed_row = |column: i64| in_column[row * width + column as usize];
        let squared = |column: i64| (i64::from(seed_row(column)) - row as i64).pow(2);
        envelope.clear();
        for column in (0..width as i64).filter(|&column| seed_row(column) != NO_SEED) {
            let mut from = 0;
            while let Some(&(last, last_from)) = envelope.last() {
                // Where the parabola of this column becomes lower than the last one: its distance
                // is smaller for all x beyond the intersection.
                let numerator = column * column - last * last + squared(column) - squared(last);
                from = numerator.div_euclid(2 * (column - last)) + 1;
                if from > last_from {
                    break;
                }
                envelope.pop();
                from = 0;
            }
            if from < width as i64 {
                envelope.push((column, from));
            }
        }
        let mut cell = width;
        for &(column, from) in envelope.iter().rev() {
            let seed = seed_row(column) as usize * width + column as usize;
            let first = from.max(0) as usize;
            nearest[row * width..][first..cell].fill(seed as u32);
            cell = cell.min(first);
        }
    }
    Some(nearest)
}

/// For each cell the row of the nearest seed in its column, or [`NO_SEED`].
fn nearest_in_columns(width: usize, is_seed: &[bool]) -> Vec<u32> {
    let height = (is_seed.len() / width) as u32;
    let mut nearest = vec![NO_SEED; is_seed.len()];
    for column in 0..width {
        let index = |row: u32| row as usize * width + column;
        let mut last = NO_SEED;
        for row in 0..height {
            if is_seed[index(row)] {
                last = row;
            }
            nearest[index(row)] = last;
        }
        let mut next = NO_SEED;
        for row in (0..height).rev() {
            if is_seed[index(row)] {
                next = row;
            }
            let cell = &mut nearest[index(row)];
            if next != NO_SEED && (*cell == NO_SEED || next - row < row - *cell) {
                *cell = next;
            }
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 2_000,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        /// Compared with the distances to all seeds.
        #[test]
        fn no_seed_is_nearer(
            width in 1_usize..20,
            height in 1_usize..20,
            picks in prop::collection::vec(any::<prop::sample::Index>(), 0..12),
        ) {
            let mut is_seed = vec![false; width * height];
            picks.iter().for_each(|pick| is_seed[pick.index(width * height)] = true);
            let found = nearest_seeds(width, &is_seed);
            prop_assert_eq!(found.is_some(), !picks.is_empty());
            let seeds: Vec<usize> = (0..is_seed.len()).filter(|&cell| is_seed[cell]).collect();
            let squared = |a: usize, b: usize| {
                (a % width).abs_diff(b % width).pow(2) + (a / width).abs_diff(b / width).pow(2)
            };
            for (cell, seed) in found.into_iter().flatten().enumerate() {
                prop_assert!(is_seed[seed as usize]);
                let min = seeds.iter().map(|&seed| squared(cell, seed)).min();
                prop_assert_eq!(Some(squared(cell, seed as usize)), min);
            }
        }
    }
}
