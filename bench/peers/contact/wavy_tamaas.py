"""A wavy surface on a flat half-space in tamaas: boundary elements in the Fourier domain, conjugate gradients by Polonsky and Keer."""

import time
from math import pi

import numpy as np
import tamaas

from rows import row

POISSON, WAVE = 0.3, 1e-3
FULL = pi * WAVE / (1 - POISSON**2)

tamaas.set_log_level(tamaas.LogLevel.error)
for part in (0.05, 0.2, 0.5, 0.8, 1.2):
    for points in (256, 1024, 4096):
        start = time.perf_counter()
        model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_1d, [1.0], [points])
        model.E, model.nu = 1.0, POISSON
        x = np.arange(points) / points
        solver = tamaas.PolonskyKeerRey(model, WAVE * np.cos(2 * pi * x), 1e-12)
        solver.max_iter = 10000
        solver.solve(part * FULL)
        pressure = np.ravel(model.traction)
        numbers = {"mean pressure/p*": pressure.mean() / FULL, "largest pressure/p*": pressure.max() / FULL}
        name = "wavy" if part == 0.5 else f"wavy_{part}"
        row(name, f"tamaas, half-space, {points} points", 0, None, points, time.perf_counter() - start, numbers)
