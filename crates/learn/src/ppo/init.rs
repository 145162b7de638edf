//! Initial parameters, drawn from a portable generator.
//!
//! Weights are orthogonal matrices times a gain and biases are 0, as in the reference
//! implementation ("The 37 Implementation Details of Proximal Policy Optimization", detail 2).

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use tch::nn::{Linear, Path};
use tch::{Kind, Tensor};

/// Gain of layers that a rectifier or a hyperbolic tangent follows: the root of 2.
pub(super) const HIDDEN: f64 = std::f64::consts::SQRT_2;

/// Gain of the actor's last layer, so that the first policy is nearly uniform.
pub(super) const ACTOR: f64 = 0.01;

/// Gain of the critic's last layer.
pub(super) const CRITIC: f64 = 1.0;

/// A variable `weight` of this shape, output axis first: an orthogonal matrix times the gain.
pub(super) fn weight(vs: &Path<'_>, rng: &mut ChaCha8Rng, shape: &[i64], gain: f64) -> Tensor {
    let rows = shape[0] as usize;
    let columns = shape[1..].iter().product::<i64>() as usize;
    let values: Vec<f32> =
        orthogonal(rng, rows, columns).iter().map(|value| (gain * value) as f32).collect();
    vs.var_copy("weight", &Tensor::from_slice(&values).view(shape))
}

/// A variable of this name filled with a number.
pub(super) fn constant(vs: &Path<'_>, name: &str, count: i64, value: f64) -> Tensor {
    vs.var_copy(name, &Tensor::full([count], value, (Kind::Float, tch::Device::Cpu)))
}

/// A linear layer.
pub(super) fn linear(vs: &Path<'_>, rng: &mut ChaCha8Rng, from: i64, to: i64, gain: f64) -> Linear {
    Linear { ws: weight(vs, rng, &[to, from], gain), bs: Some(constant(vs, "bias", to, 0.0)) }
}

/// A random matrix, row by row, whose rows are orthonormal if there are at most as many rows as
/// columns; otherwise its columns are.
///
/// Rows of normal random numbers are made orthonormal one after the other (Gram and Schmidt),
/// subtracting twice, against rounding.
/// The time is cubic in the matrix's size.
fn orthogonal(rng: &mut ChaCha8Rng, rows: usize, columns: usize) -> Vec<f64> {
    let (count, length) = (rows.min(columns), rows.max(columns));
    let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(count);
    while vectors.len() < count {
        let mut vector: Vec<f64> = (0..length).map(|_| normal(rng)).collect();
        for _ in 0..2 {
            for other in &vectors {
                let product: f64 = vector.iter().zip(other).map(|(a, b)| a * b).sum();
                vector.iter_mut().zip(other).for_each(|(a, b)| *a -= product * b);
            }
        }
        let norm = vector.iter().map(|a| a * a).sum::<f64>().sqrt();
        // Random vectors are nearly never so close to the span of the others.
        if norm > 1e-6 {
            vector.iter_mut().for_each(|a| *a /= norm);
            vectors.push(vector);
        }
    }
    let at = |row: usize, column: usize| {
        if rows <= columns { vectors[row][column] } else { vectors[column][row] }
    };
    (0..rows * columns).map(|index| at(index / columns, index % columns)).collect()
}

/// A normally distributed random number (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (radius, angle): (f64, f64) = (rng.random(), rng.random());
    // 1 - radius is above 0, so its logarithm is finite.
    (-2.0 * libm::log(1.0 - radius)).sqrt() * libm::cos(std::f64::consts::TAU * angle)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn matrices_are_orthogonal() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for (rows, columns) in [(1, 1), (1, 7), (7, 1), (4, 4), (3, 20), (20, 3)] {
            let matrix = orthogonal(&mut rng, rows, columns);
            let of = |vector: usize, index: usize| {
                let (row, column) = if rows <= columns { (vector, index) } else { (index, vector) };
                matrix[row * columns + column]
            };
            for a in 0..rows.min(columns) {
                for b in 0..rows.min(columns) {
                    let product: f64 =
                        (0..rows.max(columns)).map(|index| of(a, index) * of(b, index)).sum();
                    assert!((product - f64::from(u8::from(a == b))).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn normal_numbers_have_the_moments_of_the_distribution() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let numbers: Vec<f64> = (0..100_000).map(|_| normal(&mut rng)).collect();
        let moment = |power| {
            numbers.iter().map(|number: &f64| number.powi(power)).sum::<f64>()
                / numbers.len() as f64
        };
        for (power, expected, tolerance) in [(1, 0.0, 0.01), (2, 1.0, 0.02), (4, 3.0, 0.1)] {
            assert!((moment(power) - expected).abs() < tolerance, "{power}: {}", moment(power));
        }
    }
}
