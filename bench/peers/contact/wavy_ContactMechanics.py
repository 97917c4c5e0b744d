"""A wavy surface on a flat half-space in ContactMechanics: boundary elements in the Fourier domain, constrained conjugate gradients."""

import time
from math import pi

import numpy as np
from ContactMechanics import PeriodicFFTElasticHalfSpace, make_system
from SurfaceTopography import UniformLineScan

from rows import row

POISSON, WAVE = 0.3, 1e-3
MODULUS = 1 / (1 - POISSON**2)
FULL = pi * WAVE * MODULUS

for part in (0.05, 0.2, 0.5, 0.8, 1.2):
    for points in (256, 1024):
        start = time.perf_counter()
        surface = UniformLineScan(WAVE * np.cos(2 * pi * np.arange(points) / points), 1.0, periodic=True)
        system = make_system(substrate=PeriodicFFTElasticHalfSpace((points,), MODULUS, (1.0,)), surface=surface)
        found = system.minimize_proxy(external_force=part * FULL, pentol=1e-12, maxiter=10000)
        if not found.success:
            print(f"q = {part}, {points} points: {found.message}")
            continue
        pressure = points * np.abs(system.substrate.force)
        numbers = {"mean pressure/p*": pressure.mean() / FULL, "largest pressure/p*": pressure.max() / FULL}
        name = "wavy" if part == 0.5 else f"wavy_{part}"
        row(name, f"ContactMechanics, half-space, {points} points", 0, None, points, time.perf_counter() - start, numbers)
