#!/usr/bin/env python3
"""Compares the explicit scheme of the heat equation in numba and in beadwork.

The part is the rectangular one of 120 x 40 x 12 voxels.

    pip install numpy numba
    cargo build --release
    python3 docs/bench/thermal_numba.py target/release/beadwork

Alternates between both three times, each on one thread, and prints the seconds of both and their
ratio.
"""

import json
import subprocess
import sys
import time

import numpy as np
from numba import njit

NX, NY, NZ = 120, 40, 12
K, CP, RHO, H, EMISSIVITY, SIGMA = 0.33, 1470.0, 945.0, 10.0, 0.92, 5.67e-8
DX, DZ, DT = 0.5e-3, 0.25e-3, 0.5 / 30
AIR, PLATE, NOZZLE, KELVIN = 25.0, 80.0, 230.0, 273.15


@njit(cache=False)
def simulate(order, t, new, active):
    """Deposits voxels in order; after each, makes one explicit step of all active voxels."""
    gx = np.float32(K / (RHO * CP) * DT / DX**2)
    gz = np.float32(K / (RHO * CP) * DT / DZ**2)
    side = np.float32(DT / (RHO * CP) / DX)
    cap = np.float32(DT / (RHO * CP) / DZ)
    ta = np.float32(AIR + KELVIN)
    for birth in range(order.shape[0]):
        bz, by, bx = order[birth]
        active[bz, by, bx] = 1
        t[bz, by, bx] = NOZZLE
        for z in range(bz + 1):
            for y in range(NY):
                for x in range(NX):
                    if active[z, y, x] == 0:
                        continue
                    own = t[z, y, x]
                    change = np.float32(0)
                    faces = np.float32(0)
                    if x > 0 and active[z, y, x - 1]:
                        change += gx * (t[z, y, x - 1] - own)
                    else:
                        faces += side
                    if x < NX - 1 and active[z, y, x + 1]:
                        change += gx * (t[z, y, x + 1] - own)
                    else:
                        faces += side
                    if y > 0 and active[z, y - 1, x]:
                        change += gx * (t[z, y - 1, x] - own)
                    else:
                        faces += side
                    if y < NY - 1 and active[z, y + 1, x]:
                        change += gx * (t[z, y + 1, x] - own)
                    else:
                        faces += side
                    if z == 0:
                        change += np.float32(2) * gz * (np.float32(PLATE) - own)
                    elif active[z - 1, y, x]:
                        change += gz * (t[z - 1, y, x] - own)
                    else:
                        faces += cap
                    if z < NZ - 1 and active[z + 1, y, x]:
                        change += gz * (t[z + 1, y, x] - own)
                    else:
                        faces += cap
                    if faces > 0:
                        tk = own + np.float32(KELVIN)
                        radiation = np.float32(EMISSIVITY * SIGMA)
                        h = np.float32(H) + radiation * (tk + ta) * (tk * tk + ta * ta)
                        change -= faces * h * (own - np.float32(AIR))
                    new[z, y, x] = own + change
        new[bz, by, bx] = NOZZLE
        t, new = new, t
    return t


def main():
    order = np.array(
        [
            (z, y, x if y % 2 == 0 else NX - 1 - x)
            for z in range(NZ)
            for y in range(NY)
            for x in range(NX)
        ],
        dtype=np.int64,
    )

    def run(births):
        fields = [np.zeros((NZ, NY, NX), np.float32) for _ in range(2)]
        active = np.zeros((NZ, NY, NX), np.uint8)
        begin = time.perf_counter()
        end = simulate(order[:births], fields[0], fields[1], active)
        return time.perf_counter() - begin, end

    run(10)
    command = [sys.argv[1], "bench", "thermal", "--what", "parts", "--part", "rectangular"]
    command += ["--repeats", "1", "--json"]
    for _ in range(3):
        seconds, end = run(len(order))
        rows = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["parts"]
        ours = next(row["seconds"] for row in rows if row["method"] == "naive")
        print(
            f"numba {seconds:.2f} s, beadwork {ours:.3f} s, ratio {seconds / ours:.2f}; "
            f"mean {end.mean():.3f} C"
        )


if __name__ == "__main__":
    main()
