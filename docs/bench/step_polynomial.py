"""Fits the polynomial of long steps, `FITTED` in crates/thermal/src/fast/chebyshev.rs, and prints it.

A step of s stages multiplies a mode that decays by e^z within it, z < 0, by a polynomial P(z) of degree s. Of those with
P(z) = 1 + z + z^2/2 + ..., this one is nearest to e^z in the sense that counts here: what was born a quarter of a step ago
has decayed by e^(z/4) already, and each error lasts for 1 / (1 - e^z) steps, so |P(z) - e^z| is weighed by
e^(z/4) / (1 - e^z), but at least by a tenth, for the sake of anything sharp that is older. The largest weighed error is made
smallest by Lawson's algorithm: least squares, again and again, with more weight where the error is large.

    python3 docs/bench/step_polynomial.py

needs numpy.
"""

import itertools

import numpy as np
from numpy.polynomial import chebyshev

STAGES, REACH, AGE, FLOOR = 12, 73.0, 0.25, 0.1


def fit():
    """Chebyshev coefficients over [-REACH, 0] and the largest weighed error."""
    x = np.cos(np.linspace(0.0, np.pi, 2000))
    z = (x - 1.0) * REACH / 2.0
    weight = np.maximum(np.exp(AGE * z) / np.maximum(-np.expm1(z), 1e-3), FLOOR)
    basis = chebyshev.chebvander(x, STAGES)
    # P, P' and P'' are 1 at z = 0.
    unit = np.eye(STAGES + 1)
    ends = [[chebyshev.chebval(1.0, chebyshev.chebder(row, d)) * (2.0 / REACH) ** d for row in unit] for d in range(3)]
    ends = np.array(ends)
    start = np.linalg.lstsq(ends, np.ones(3), rcond=None)[0]
    free = np.linalg.svd(ends)[2][3:].T
    lawson, best = np.full(z.size, 1.0 / z.size), (np.inf, None)
    for _ in range(400):
        scale = np.sqrt(lawson) * weight
        more = np.linalg.lstsq(scale[:, None] * (basis @ free), scale * (np.exp(z) - basis @ start), rcond=None)[0]
        numbers = start + free @ more
        error = np.abs(basis @ numbers - np.exp(z)) * weight
        best = min(best, (error.max(), tuple(numbers)))
        lawson = np.maximum(lawson * error / (lawson * error).sum(), 1e-14)
    return np.array(best[1]), best[0]


def factors(numbers):
    """Pairs of stages, 1 + a z + b z^2, one for each pair of roots: conjugate ones, or real neighbours."""
    roots = (chebyshev.chebroots(numbers) - 1.0) * REACH / 2.0
    real = sorted(root.real for root in roots if abs(root.imag) < 1e-9)
    pairs = [(root, root.conjugate()) for root in roots if root.imag > 1e-9] + list(zip(real[::2], real[1::2]))
    assert 2 * len(pairs) == STAGES, "every root has another one"
    return [(-(1 / p + 1 / q).real, (1 / (p * q)).real) for p, q in pairs]


def ordered(pairs):
    """The order in which neither modes nor rounding grow far on the way: the former count fifty times as much."""
    z = np.linspace(-REACH, 0.0, 601)
    values = np.array([1.0 + a * z + b * z * z for a, b in pairs])

    def growth(order):
        return max(np.abs(np.cumprod(values[list(order)], axis=0)).max(axis=1))

    return min(itertools.permutations(range(len(pairs))), key=lambda p: 5.0 * max(growth(p), 1.0) + 0.1 * growth(p[::-1]))


if __name__ == "__main__":
    numbers, error = fit()
    pairs = factors(numbers)
    print(f"// The largest weighed error is {error:.4f}.")
    for i in ordered(pairs):
        print("    Factor {{ a: {:.17}, b: {:.17} }},".format(*pairs[i]))
