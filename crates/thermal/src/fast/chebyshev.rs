//! Explicit steps that are longer than explicit steps may be.
//!
//! A step of s stages multiplies each mode of the temperature, which decays at rate λ, by a
//! polynomial P of degree s at z = -λ dt.
//! Of all polynomials with P(z) = 1 + z + z² / 2 + ..., which makes the step second-order accurate,
//! shifted Chebyshev ones stay below 1 farthest: to about 2/3 s² (Sommeijer, Shampine and Verwer
//! 1997, RKC; damping 2/13).
//! They are used in factors here: the roots of P come in conjugate pairs, and each pair is one
//! [`crate::kernel::Pair`], which needs no memory of earlier stages.

use std::f64::consts::PI;

/// Two stages, for a step of one second: θ + a f(θ) + b J f(θ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Factor {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

/// A step of an even number of stages.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polynomial {
    pub(crate) factors: Vec<Factor>,
    /// The largest λ dt for which no mode grows.
    pub(crate) reach: f64,
}

/// How far |P| stays below 1 in the middle of its range.
const DAMPING: f64 = 2.0 / 13.0;

/// The largest λ dt of the fitted step.
const FITTED_REACH: f64 = 73.0;

/// A step of twelve stages that is as near to what modes really do as it can be: see
/// `docs/bench/step_polynomial.py`, which prints these numbers.
/// Its weighed error is less than a fifth of that of the shifted Chebyshev polynomial with the same
/// reach.
const FITTED: [Factor; 6] = [
    Factor { a: 0.032_481_318_962_853_38, b: 0.000_262_927_252_372_502_5 },
    Factor { a: 0.303_614_845_656_898_8, b: 0.018_614_776_388_940_425 },
    Factor { a: 0.044_895_159_953_261_27, b: 0.000_498_295_108_173_633_1 },
    Factor { a: 0.080_881_276_060_379_29, b: 0.001_577_904_265_142_395_7 },
    Factor { a: 0.028_016_196_781_823_66, b: 0.000_196_164_862_422_008_37 },
    Factor { a: 0.510_111_202_584_772, b: 0.160_246_288_659_860_63 },
];

impl Polynomial {
    /// Of as few stages as reach to a λ dt.
    pub(crate) fn reaching(z: f64) -> Self {
        let mut stages = 2;
        // Below what is left after the damping, for any number of stages.
        while stages == 2 && z > 2.0 || stages > 2 && z > 0.65 * (stages * stages - 1) as f64 {
            stages += 2;
        }
        Self::of_stages(stages)
    }

    /// The fitted step, which reaches to a λ dt of 73.
    pub(crate) fn fitted() -> Self {
        Self { factors: FITTED.to_vec(), reach: FITTED_REACH }
    }

    /// How many stages it has.
    pub(crate) fn stages(&self) -> usize {
        2 * self.factors.len()
    }

    /// Of so many stages.
    ///
    /// # Panics
    /// If the number is odd or 0.
    pub(crate) fn of_stages(stages: usize) -> Self {
        assert!(stages > 0 && stages.is_multiple_of(2), "stages come in pairs");
        if stages == 2 {
            return Self { factors: vec![Factor { a: 1.0, b: 0.5 }], reach: 2.0 };
        }
        let s = stages as f64;
        let w0 = 1.0 + DAMPING / (s * s);
        let u = libm::acosh(w0);
        // T(w0) and its derivatives, T = cosh(s acosh(w)).
        let (sinh_u, cosh_u) = (libm::sinh(u), libm::cosh(u));
        let value = libm::cosh(s * u);
        let first = s * libm::sinh(s * u) / sinh_u;
        let second = (s * s * value - first * cosh_u) / (sinh_u * sinh_u);
        let (w1, b) = (first / second, second / (first * first));
        // P(z) = 1 - b T(w0) + b T(w0 + w1 z) is 0 where T = -c, c > 1: at w = cosh(A + iB).
        let c = 1.0 / b - value;
        let a_part = libm::acosh(c) / s;
        let mut factors: Vec<Factor> = (0..stages / 2)
            .map(|j| {
                let b_part = PI * (2.0 * j as f64 + 1.0) / s;
                let re = (libm::cosh(a_part) * libm::cos(b_part) - w0) / w1;
                let im = libm::sinh(a_part) * libm::sin(b_part) / w1;
                let square = re * re + im * im;
                Factor { a: -2.0 * re / square, b: 1.0 / square }
            })
            .collect();
        // Each factor alone lets some modes grow: those that damp the fastest modes go between the
        // others.
        // What grew on the way would be so hot that radiation runs away with it, so the one that
        // lets modes grow most comes last.
        let last = factors.remove(0);
        let fast = factors.split_off(factors.len().div_ceil(2));
        let mut mixed = Vec::with_capacity(stages / 2);
        let mut fast = fast.into_iter().rev();
        for slow in factors {
            mixed.extend(fast.next());
            mixed.push(slow);
        }
        mixed.push(last);
        Self { factors: mixed, reach: (w0 + 1.0) / w1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(polynomial: &Polynomial, z: f64) -> f64 {
        polynomial.factors.iter().map(|f| 1.0 + f.a * z + f.b * z * z).product()
    }

    #[test]
    fn the_fitted_step_is_near_to_the_exponential() {
        let (fitted, other) = (Polynomial::fitted(), Polynomial::reaching(FITTED_REACH));
        assert_eq!(fitted.stages(), other.stages());
        let errors = [&fitted, &other].map(|p| {
            let error = |i: i32| {
                let z = -FITTED_REACH * f64::from(i) / 10_000.0;
                let weight = (z / 4.0).exp() / (1.0 - z.exp()).max(1e-3);
                (value(p, z) - z.exp()).abs() * weight.max(0.1)
            };
            (0..=10_000).map(error).fold(0.0, f64::max)
        });
        assert!(errors[0] < 0.046 && errors[1] > 5.0 * errors[0], "{errors:?}");
    }

    #[test]
    fn nothing_grows_far_within_a_step() {
        let [four, ten] = [4, 10].map(Polynomial::of_stages);
        let steps = [
            (four, 0.9, 1.0, 25.0),
            (ten, 0.75, 1.0, 700.0),
            (Polynomial::fitted(), 1.0, 3.2, 850.0),
        ];
        for (p, fill, growth, rounding) in steps {
            let stages = p.stages();
            for i in 0..=1000 {
                let z = -fill * p.reach * f64::from(i) / 1000.0;
                let each: Vec<f64> =
                    p.factors.iter().map(|f| 1.0 + f.a * z + f.b * z * z).collect();
                for split in 0..=each.len() {
                    let (before, after): (f64, f64) =
                        (each[..split].iter().product(), each[split..].iter().product());
                    assert!(before.abs() <= growth + 1e-9, "{stages} stages at {z}: {before}");
                    // So much more than rounding is what comes out of rounding, of about 1e-5 K.
                    assert!(after.abs() < rounding, "{stages} stages at {z}: {after}");
                }
            }
        }
    }

    #[test]
    fn steps_are_second_order_and_stable_to_their_reach() {
        let shifted = (2..=64).step_by(2).map(Polynomial::of_stages);
        for (i, p) in shifted.chain([Polynomial::fitted()]).enumerate() {
            let stages = if i < 32 { 2 * (i + 1) } else { 12 };
            assert_eq!(p.factors.len() * 2, stages);
            let sum: f64 = p.factors.iter().map(|f| f.a).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{stages}: {sum}");
            // The coefficient of z² from the factors' own.
            let squares: f64 = p.factors.iter().map(|f| f.b - f.a * f.a / 2.0).sum();
            assert!((squares + 0.5 * sum * sum - 0.5).abs() < 1e-9, "{stages}");
            for i in 0..=10_000 {
                let z = -p.reach * f64::from(i) / 10_000.0;
                assert!(
                    value(&p, z).abs() <= 1.0 + 1e-9,
                    "{stages} stages at {z}: {}",
                    value(&p, z)
                );
            }
            let s = stages as f64;
            assert!(
                stages == 2 || i == 32 || p.reach > 0.65 * (s * s - 1.0),
                "{stages}: {}",
                p.reach
            );
        }
    }
}
