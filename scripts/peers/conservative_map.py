#!/usr/bin/env python3
"""A conservative map the way a careful script computes it, timed beside mapgen on the same grid, one core each.

    python3 scripts/peers/conservative_map.py scenes/conservative-n20.toml [--mapgen target/release/mapgen]

The script has the closed kernels (no truncated series), the even subspace and whole rows at a time in NumPy: orbits and
existence by samples over half a period, multipliers by batched `numpy.linalg.eigvals` of the even monodromy matrices of
the orbits that exist. It prints both times a cell, their ratio, and every class on which the two tables differ.
NumPy is all it needs.
"""

import argparse
import csv
import os
import statistics
import subprocess
import tempfile
import time
import tomllib

# One core each: before NumPy starts its threads.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np  # noqa: E402

# Instants at which existence is looked at, over half a period.
SAMPLES = 64
# How far the largest modulus may be from 1: the defective pair at 1 is taken out, what is left of its blur is not.
GROWTH = 1e-6
# Runs of mapgen, of which the median counts: one takes a fortieth of the time of the script, so that any other load shows in it.
RUNS = 9
UPPER, LOWER = 1.0, -1.0


class Row:
    """All frequencies of a row at once; arrays are (frequency, …)."""

    def __init__(self, sites, gamma1, gamma2, asymmetry, omega):
        modes = np.arange(sites // 2 + 1)
        self.frequencies = np.sqrt(gamma1 + 4 * gamma2 * np.sin(np.pi * modes / sites) ** 2)
        self.weights = np.where((modes == 0) | (2 * modes == sites), 1.0, 2.0) / sites
        # cos(2πkn/M): modes to sites, half the ring.
        self.shapes = np.cos(2 * np.pi * np.outer(modes, modes) / sites)
        self.asymmetry = asymmetry
        self.period = 2 * np.pi / omega
        self.half_phase = 0.5 * self.frequencies * self.period[:, None]
        self.amplitude = self.weights / (2 * self.frequencies * np.sin(self.half_phase))

    def kernel(self, offset):
        """K₀ where cos(Ω(t − T/2)) is `offset`."""
        return np.sum(self.amplitude * offset, axis=-1)

    def orbits(self):
        """Impulses and accelerations of both families at their impacts: the upper barrier at 0, the lower at T/2."""
        at_impact, between = np.cos(self.half_phase), 1.0
        k0, k1 = self.kernel(at_impact), self.kernel(between)
        square = self.frequencies**2
        # Acceleration a unit impulse gives at its own instant (mean of both sides) and half a period away.
        a0, a1 = -self.kernel(square * at_impact), -self.kernel(square * between)
        high, low = self.asymmetry + 1, self.asymmetry - 1
        determinant = (k0 - k1) * (k0 + k1)
        p0, p1 = (high * k0 - low * k1) / determinant, (low * k0 - high * k1) / determinant
        p = low / k0
        return (p0, p1, a0 * p0 + a1 * p1, a1 * p0 + a0 * p1), (p, a0 * p)

    def inside(self, before, after):
        """Whether all masses stay between the barriers: `before` and `after` are the impulses at 0 and T/2."""
        # Orbits are even in time about their impacts. The ends are the impacts themselves.
        instants = np.linspace(0, 0.5, SAMPLES)[1:-1]
        phase = 2 * self.half_phase[:, None, :]
        first = np.cos((instants[:, None] - 0.5) * phase)
        second = np.cos(instants[:, None] * phase)
        modal = self.amplitude[:, None, :] * (before[:, None, None] * first + after[:, None, None] * second)
        motion = modal @ self.shapes
        return np.all(np.abs(motion - self.asymmetry) < 1, axis=(1, 2))

    def flow(self, chosen, phase):
        """Even modes turn by `phase`; coordinates (q, q′/Ω)."""
        cosine, sine = np.cos(phase), np.sin(phase)
        size = self.frequencies.size
        matrix = np.zeros((np.count_nonzero(chosen), 2 * size, 2 * size))
        index = np.arange(size)
        matrix[:, index, index] = matrix[:, index + size, index + size] = cosine
        matrix[:, index, index + size] = sine
        matrix[:, index + size, index] = -sine
        return matrix

    def saltation(self, chosen, impulse, acceleration):
        size, shape = self.frequencies.size, np.sqrt(self.weights)
        kappa = 2 * acceleration[chosen] / (-0.5 * impulse[chosen])
        matrix = np.broadcast_to(np.eye(2 * size), (kappa.size, 2 * size, 2 * size)).copy()
        matrix[:, :size, :size] -= 2 * np.outer(shape, shape)
        matrix[:, size:, size:] -= 2 * np.outer(shape / self.frequencies, shape * self.frequencies)
        matrix[:, size:, :size] += kappa[:, None, None] * np.outer(shape / self.frequencies, shape)
        return matrix

    def growth(self, chosen, impacts):
        """Largest modulus but for the trivial pair, less 1."""
        if not np.any(chosen):
            return np.zeros(0)
        phase = 2 * self.half_phase[chosen] / len(impacts)
        flow = self.flow(chosen, phase)
        monodromy = None
        for impulse, acceleration in impacts:
            step = flow @ self.saltation(chosen, impulse, acceleration)
            monodromy = step if monodromy is None else step @ monodromy
        multipliers = np.linalg.eigvals(monodromy)
        trivial = np.argsort(np.abs(multipliers - 1), axis=1)[:, :2]
        np.put_along_axis(multipliers, trivial, 0, axis=1)
        return np.abs(multipliers).max(axis=1) - 1

    def classes(self):
        (p0, p1, upper, lower), (p, acceleration) = self.orbits()
        double = (p0 < 0) & (p1 > 0)
        double[double] = self.part(double).inside(p0[double], p1[double])
        single = p > 0
        single[single] = self.part(single).inside_single(p[single])
        names = np.full(self.period.size, "none", dtype=object)
        for exists, name, impacts in (
            (single, "single", [(p, acceleration)]),
            (double, "double", [(p0, upper), (p1, lower)]),
        ):
            stable = self.growth(exists, impacts) < GROWTH
            names[exists] = np.where(stable, f"stable-{name}", f"unstable-{name}")
        return names

    def part(self, chosen):
        """The same for some frequencies only."""
        row = object.__new__(Row)
        row.__dict__ = {**self.__dict__, "period": self.period[chosen]}
        row.half_phase, row.amplitude = self.half_phase[chosen], self.amplitude[chosen]
        return row

    def inside_single(self, impulse):
        # From the impact on to half a period after it, where the orbit is even, too.
        instants = np.linspace(0, 0.5, SAMPLES)[1:]
        first = np.cos((instants[:, None] - 0.5) * 2 * self.half_phase[:, None, :])
        motion = (self.amplitude[:, None, :] * impulse[:, None, None] * first) @ self.shapes
        return np.all(np.abs(motion - self.asymmetry) < 1, axis=(1, 2))


def axis(description):
    return np.linspace(description["from"], description["to"], description["points"])


def peer(scene):
    model, sweep = scene["model"], scene["sweep"]
    assert sweep["x"]["parameter"] == "omega" and sweep["y"]["parameter"] == "gamma2", "a map over (omega, gamma2)"
    assert "forcing" not in model and "force" not in model, "a conservative scene"
    omega = axis(sweep["x"])
    rows = []
    with np.errstate(divide="ignore", invalid="ignore"):
        for gamma2 in axis(sweep["y"]):
            rows.append(Row(model["sites"], model["gamma1"], gamma2, model["asymmetry"], omega).classes())
    return np.concatenate(rows)


def ours(mapgen, scene):
    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(folder, "map.csv")
        times = []
        for _ in range(RUNS):
            start = time.perf_counter()
            subprocess.run([mapgen, "sweep", scene, "--threads", "1", "--out", table, "--quiet"], check=True)
            times.append(time.perf_counter() - start)
        seconds = statistics.median(times)
        with open(table, newline="") as file:
            return np.array([record["class"] for record in csv.DictReader(file)], dtype=object), seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scene")
    parser.add_argument("--mapgen", default="target/release/mapgen")
    arguments = parser.parse_args()
    with open(arguments.scene, "rb") as file:
        scene = tomllib.load(file)
    start = time.perf_counter()
    theirs = peer(scene)
    slow = (time.perf_counter() - start) / theirs.size
    table, seconds = ours(arguments.mapgen, arguments.scene)
    fast = seconds / table.size
    print(f"{arguments.scene}: {table.size} cells, one core each, NumPy {np.__version__}")
    print(f"  script {1e6 * slow:8.2f} µs a cell")
    print(f"  mapgen {1e6 * fast:8.2f} µs a cell, from start to end of the program, files included, median of {RUNS} runs")
    print(f"  ratio  {slow / fast:8.1f}")
    differ = theirs != table
    print(f"  classes that differ: {np.count_nonzero(differ)}")
    for pair in sorted({(str(a), str(b)) for a, b in zip(theirs[differ], table[differ])}):
        count = np.count_nonzero((theirs == pair[0]) & (table == pair[1]))
        print(f"    {count:6} script {pair[0]}, mapgen {pair[1]}")


if __name__ == "__main__":
    main()
