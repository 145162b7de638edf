"""Fits the stability polynomial of long steps and prints it.

The result is `FITTED` in crates/thermal/src/fast/chebyshev.rs.

A step of s stages multiplies a mode that decays by e^z within the step, z < 0, by a polynomial P(z)
of degree s. Second order requires P(z) = 1 + z + z^2/2 + ...; of these polynomials, the fitted one
minimises the maximum weighted error |P(z) - e^z|.

The weight is e^(z/4) / (1 - e^z), but at least 0.1:
- Heat that was deposited a quarter of a step ago has already decayed by e^(z/4).
- Each error persists for 1 / (1 - e^z) steps.
- The lower limit covers older steep gradients.

The minimax problem is solved by Lawson's algorithm: repeated least squares, in which the weights
grow where the error is large.

    pip install numpy
    python3 docs/bench/step_polynomial.py
"""

import itertools

import numpy as np
from numpy.polynomial import chebyshev

STAGES, REACH, AGE, FLOOR = 12, 73.0, 0.25, 0.1


def fit():
    """Returns the Chebyshev coefficients over [-REACH, 0] and the maximum weighted error."""
    x = np.cos(np.linspace(0.0, np.pi, 2000))
    z = (x - 1.0) * REACH / 2.0
    weight = np.maximum(np.exp(AGE * z) / np.maximum(-np.expm1(z), 1e-3), FLOOR)
    basis = chebyshev.chebvander(x, STAGES)
    # Constraints of second order: P, P' and P'' are 1 at z = 0.
    # `start` satisfies them, and the columns of `free` span their null space.
    unit = np.eye(STAGES + 1)

    def at_zero(row, d):
        return chebyshev.chebval(1.0, chebyshev.chebder(row, d)) * (2.0 / REACH) ** d

    ends = np.array([[at_zero(row, d) for row in unit] for d in range(3)])
    start = np.linalg.lstsq(ends, np.ones(3), rcond=None)[0]
    free = np.linalg.svd(ends)[2][3:].T
    lawson, best = np.full(z.size, 1.0 / z.size), (np.inf, None)
    for _ in range(400):
        scale = np.sqrt(lawson) * weight
        left, right = scale[:, None] * (basis @ free), scale * (np.exp(z) - basis @ start)
        more = np.linalg.lstsq(left, right, rcond=None)[0]
        numbers = start + free @ more
        error = np.abs(basis @ numbers - np.exp(z)) * weight
        best = min(best, (error.max(), tuple(numbers)))
        lawson = np.maximum(lawson * error / (lawson * error).sum(), 1e-14)
    return np.array(best[1]), best[0]


def factors(numbers):
    """Factors P into pairs of stages, 1 + a z + b z^2.

    Each pair has two roots: complex conjugates, or adjacent real roots.
    """
    roots = (chebyshev.chebroots(numbers) - 1.0) * REACH / 2.0
    real = sorted(root.real for root in roots if abs(root.imag) < 1e-9)
    pairs = [(root, root.conjugate()) for root in roots if root.imag > 1e-9]
    pairs += list(zip(real[::2], real[1::2]))
    assert 2 * len(pairs) == STAGES, "every root belongs to a pair"
    return [(-(1 / p + 1 / q).real, (1 / (p * q)).real) for p, q in pairs]


def ordered(pairs):
    """Orders the pairs so that neither modes nor rounding errors grow much between the stages.

    Growth of modes counts fifty times as much as growth of rounding errors.
    """
    z = np.linspace(-REACH, 0.0, 601)
    values = np.array([1.0 + a * z + b * z * z for a, b in pairs])

    def growth(order):
        return max(np.abs(np.cumprod(values[list(order)], axis=0)).max(axis=1))

    def penalty(order):
        return 5.0 * max(growth(order), 1.0) + 0.1 * growth(order[::-1])

    return min(itertools.permutations(range(len(pairs))), key=penalty)


if __name__ == "__main__":
    numbers, error = fit()
    pairs = factors(numbers)
    print(f"// The maximum weighted error is {error:.4f}.")
    for i in ordered(pairs):
        print("    Factor {{ a: {:.17}, b: {:.17} }},".format(*pairs[i]))
