//! Stabilised explicit steps: Runge-Kutta-Chebyshev methods in factored form.
//!
//! # The problem
//!
//! An explicit step of length dt multiplies each mode of the temperature, which decays at the rate
//! λ, by a polynomial P(z) at z = -λ dt; the exact factor is e^z.
//! The step is stable if |P| ≤ 1 for all modes.
//! Euler's and Heun's method are stable for λ dt ≤ 2 only, so the fastest mode of the voxels
//! dictates dt, even where it has long decayed and only slow modes are left.
//!
//! # The method
//!
//! With s stages, P may be any polynomial of degree s.
//! Second order needs P(z) = 1 + z + z² / 2 + O(z³).
//! Of these, a shifted and scaled Chebyshev polynomial is stable nearly as far as possible:
//!
//! ```text
//! P(z) = 1 - b T(w0) + b T(w0 + w1 z),        T = Chebyshev polynomial of degree s
//! w0 = 1 + ε / s²,  w1 = T'(w0) / T''(w0),  b = T''(w0) / T'(w0)²
//! ```
//!
//! It is stable for λ dt up to about 2/3 s², so twice the stages allow a step four times as long
//! (RKC: Sommeijer, Shampine and Verwer, J. Comput. Appl. Math. 88 (1998) 315-326, which is also
//! the source of ε = 2/13).
//! The cost of a step therefore grows with the square root of its length.
//! The price is accuracy for fast modes: where e^z nearly vanishes, P oscillates between 1/3 and
//! 0.95 instead.
//! A fast mode with a large amplitude would take several steps to disappear, which is why shorter
//! steps are taken wherever heat is new (`stepper.rs`).
//!
//! # In factors
//!
//! The usual implementation of RKC is a recurrence over stages, which stores several of them.
//! Here P is split into quadratic factors 1 + a z + b z², one for each conjugate pair of its roots,
//! and each factor is one sweep in place ([`crate::kernel::TwoStageSweep`] with
//! [`crate::kernel::Quadratic`]), for which no earlier stage has to be stored.
//! The DUMKA methods of Lebedev and Medovikov are products of such factors too (Medovikov, BIT 38
//! (1998) 372-390).
//!
//! For the linear part of the equation the product of the factors is P itself.
//! With radiation the equation is not linear, but the order stays two: an autonomous equation has
//! only one condition of second order, the coefficient of z².
//!
//! The limit of this form is **internal stability**: the product of all factors is at most 1, but
//! products of some of them need not be.
//! The factors that have been applied may amplify intermediate temperatures, and the factors that
//! follow may amplify the rounding errors made so far (about 1e-5 K).
//! The order of the factors keeps both small for the degrees that are used here, up to 12; from 16
//! stages on, rounding reaches 0.1 K.

use std::f64::consts::PI;

/// One factor 1 + a z + b z² of a stability polynomial: θ + a f(θ) + b J f(θ) for a step of one
/// second.
///
/// For a step of dt seconds, `a` is multiplied by dt and `b` by dt².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Factor {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

/// A stability polynomial of even degree, as the sequence of its quadratic factors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polynomial {
    /// In the order in which they are applied.
    pub(crate) factors: Vec<Factor>,
    /// Largest λ dt for which no mode grows.
    pub(crate) stable_to: f64,
}

/// ε of the formula above: keeps |P| below about 1 - ε / 3 inside the stable range, where it would
/// otherwise reach 1 at many points.
const EPSILON: f64 = 2.0 / 13.0;

/// Largest stable λ dt of the fitted polynomial.
const FITTED_STABLE_TO: f64 = 73.0;

/// The fitted polynomial: of all second-order polynomials of degree 12 that are stable to 73, the
/// nearest to e^z in a weighted maximum norm.
///
/// The weight of the error at z is e^(z/4) / (1 - e^z), but at least 0.1.
/// Such a step is used where the youngest heat is a quarter of a step old, so a mode has already
/// decayed by e^(z/4) when the step begins.
/// An error persists for about 1 / (1 - e^z) steps.
/// The lower limit covers steep gradients of older heat.
/// `docs/bench/step_polynomial.py` computes the polynomial by Lawson's algorithm and prints these
/// factors.
/// Its weighted error is less than a fifth of that of the shifted Chebyshev polynomial that is
/// stable equally far.
const FITTED: [Factor; 6] = [
    Factor { a: 0.032_481_318_962_853_38, b: 0.000_262_927_252_372_502_5 },
    Factor { a: 0.303_614_845_656_898_8, b: 0.018_614_776_388_940_425 },
    Factor { a: 0.044_895_159_953_261_27, b: 0.000_498_295_108_173_633_1 },
    Factor { a: 0.080_881_276_060_379_29, b: 0.001_577_904_265_142_395_7 },
    Factor { a: 0.028_016_196_781_823_66, b: 0.000_196_164_862_422_008_37 },
    Factor { a: 0.510_111_202_584_772, b: 0.160_246_288_659_860_63 },
];

impl Polynomial {
    /// The shifted Chebyshev polynomial of lowest even degree that is stable up to a λ dt of `z`.
    pub(crate) fn for_stability(z: f64) -> Self {
        let mut stages = 2;
        // 0.65 (s² - 1) is slightly less than the exact limit 2/3 (s² - 1) (1 - 2/15 ε); a test
        // compares the two.
        while stages == 2 && z > 2.0 || stages > 2 && z > 0.65 * (stages * stages - 1) as f64 {
            stages += 2;
        }
        Self::with_stages(stages)
    }

    /// The fitted polynomial of degree 12, which is stable up to a λ dt of 73.
    pub(crate) fn fitted() -> Self {
        Self { factors: FITTED.to_vec(), stable_to: FITTED_STABLE_TO }
    }

    /// Number of stages, which is the degree.
    pub(crate) fn stages(&self) -> usize {
        2 * self.factors.len()
    }

    /// The shifted Chebyshev polynomial of a degree.
    ///
    /// # Panics
    /// If the degree is odd or 0.
    pub(crate) fn with_stages(stages: usize) -> Self {
        assert!(stages > 0 && stages.is_multiple_of(2), "stages come in pairs");
        if stages == 2 {
            // There is only one second-order polynomial of degree two: Heun's method.
            return Self { factors: vec![Factor { a: 1.0, b: 0.5 }], stable_to: 2.0 };
        }
        let s = stages as f64;
        let w0 = 1.0 + EPSILON / (s * s);
        // For w > 1, T(w) = cosh(s u) with w = cosh u.
        // Its derivatives follow: T'(w) = s sinh(s u) / sinh u, and T''(w) by differentiating once
        // more.
        let u = libm::acosh(w0);
        let (sinh_u, cosh_u) = (libm::sinh(u), libm::cosh(u));
        let value = libm::cosh(s * u);
        let first = s * libm::sinh(s * u) / sinh_u;
        let second = (s * s * value - first * cosh_u) / (sinh_u * sinh_u);
        let (w1, b) = (first / second, second / (first * first));
        // The roots.
        // P(z) = 0 where T(w) = T(w0) - 1 / b = -c, with w = w0 + w1 z.
        // Since c > 1, these w are complex: w = cosh(A + iB) with s A = acosh(c) and s B an odd
        // multiple of π, for then T(w) = cosh(s A + i s B) = -cosh(s A) = -c.
        let c = 1.0 / b - value;
        let a_part = libm::acosh(c) / s;
        let mut factors: Vec<Factor> = (0..stages / 2)
            .map(|j| {
                let b_part = PI * (2.0 * j as f64 + 1.0) / s;
                // z = (w - w0) / w1, with cosh(A + iB) = cosh A cos B + i sinh A sin B.
                let re = (libm::cosh(a_part) * libm::cos(b_part) - w0) / w1;
                let im = libm::sinh(a_part) * libm::sin(b_part) / w1;
                // (1 - z / r) (1 - z / r*) = 1 - 2 Re(r) / |r|² z + z² / |r|².
                let square = re * re + im * im;
                Factor { a: -2.0 * re / square, b: 1.0 / square }
            })
            .collect();
        // Choose the order of the factors.
        // At this point they are sorted by their roots.
        // The roots of the first factor are nearest to 0: it damps slow modes and amplifies fast
        // ones more than any other factor.
        // The roots of the last factor are at the far end of the stable range: it damps the fastest
        // modes.
        // Factors from the far end alternate with those from the near end, so that a factor damps
        // the modes that its neighbours amplify.
        // The first factor is applied last, when little is left of the modes that it amplifies.
        // With it earlier, intermediate temperatures would be so high that radiation, a cubic
        // polynomial, diverges.
        let last = factors.remove(0);
        let fast = factors.split_off(factors.len().div_ceil(2));
        let mut mixed = Vec::with_capacity(stages / 2);
        let mut fast = fast.into_iter().rev();
        for slow in factors {
            mixed.extend(fast.next());
            mixed.push(slow);
        }
        mixed.push(last);
        // The stable range ends where w = -1.
        Self { factors: mixed, stable_to: (w0 + 1.0) / w1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P(z).
    fn value(polynomial: &Polynomial, z: f64) -> f64 {
        polynomial.factors.iter().map(|f| 1.0 + f.a * z + f.b * z * z).product()
    }

    #[test]
    fn fitted_polynomial_is_near_the_exponential() {
        let (fitted, other) = (Polynomial::fitted(), Polynomial::for_stability(FITTED_STABLE_TO));
        assert_eq!(fitted.stages(), other.stages());
        let errors = [&fitted, &other].map(|p| {
            let error = |i: i32| {
                let z = -FITTED_STABLE_TO * f64::from(i) / 10_000.0;
                let weight = (z / 4.0).exp() / (1.0 - z.exp()).max(1e-3);
                (value(p, z) - z.exp()).abs() * weight.max(0.1)
            };
            (0..=10_000).map(error).fold(0.0, f64::max)
        });
        assert!(errors[0] < 0.046 && errors[1] > 5.0 * errors[0], "{errors:?}");
    }

    #[test]
    fn partial_products_stay_small() {
        let [four, ten] = [4, 10].map(Polynomial::with_stages);
        let steps = [
            (four, 0.9, 1.0, 25.0),
            (ten, 0.75, 1.0, 700.0),
            (Polynomial::fitted(), 1.0, 3.2, 850.0),
        ];
        for (p, fill, growth, rounding) in steps {
            let stages = p.stages();
            for i in 0..=1000 {
                let z = -fill * p.stable_to * f64::from(i) / 1000.0;
                let each: Vec<f64> =
                    p.factors.iter().map(|f| 1.0 + f.a * z + f.b * z * z).collect();
                for split in 0..=each.len() {
                    let (before, after): (f64, f64) =
                        (each[..split].iter().product(), each[split..].iter().product());
                    assert!(before.abs() <= growth + 1e-9, "{stages} stages at {z}: {before}");
                    // Factor by which rounding errors, of about 1e-5 K, are amplified.
                    assert!(after.abs() < rounding, "{stages} stages at {z}: {after}");
                }
            }
        }
    }

    #[test]
    fn polynomials_are_second_order_and_stable() {
        let shifted = (2..=64).step_by(2).map(Polynomial::with_stages);
        for (i, p) in shifted.chain([Polynomial::fitted()]).enumerate() {
            let stages = if i < 32 { 2 * (i + 1) } else { 12 };
            assert_eq!(p.factors.len() * 2, stages);
            let sum: f64 = p.factors.iter().map(|f| f.a).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{stages}: {sum}");
            // P = exp(Σ ln(1 + a z + b z²)), so the coefficient of z² is Σ (b - a² / 2) + (Σ a)²
            // / 2.
            let squares: f64 = p.factors.iter().map(|f| f.b - f.a * f.a / 2.0).sum();
            assert!((squares + 0.5 * sum * sum - 0.5).abs() < 1e-9, "{stages}");
            for i in 0..=10_000 {
                let z = -p.stable_to * f64::from(i) / 10_000.0;
                assert!(
                    value(&p, z).abs() <= 1.0 + 1e-9,
                    "{stages} stages at {z}: {}",
                    value(&p, z)
                );
            }
            let s = stages as f64;
            assert!(
                stages == 2 || i == 32 || p.stable_to > 0.65 * (s * s - 1.0),
                "{stages}: {}",
                p.stable_to
            );
        }
    }
}
