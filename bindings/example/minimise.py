"""The ground that keeps a loaded beam level."""
import numpy as np
from scipy.optimize import minimize
from beam_on_ground import level

beam = level(cells=16, load=1e-3)
found = minimize(beam.value_and_gradient, beam.start, jac=True, bounds=[(-0.1, 0.1)] * beam.start.size,
                 options={"ftol": 1e-15, "gtol": 1e-10})
direction, t = np.cos(np.arange(found.x.size)), 1e-6
m = beam.start + 1e-3 * direction
slope = (beam.value(m + t * direction) - beam.value(m - t * direction))[0] / (2 * t)
print(f"{beam.value(beam.start)[0]:.3e} -> {found.fun:.3e} in {found.nit} iterations;",
      f"gradient and differences differ by {abs(slope / beam.jvp(m, direction)[0] - 1):.1e}")
