"""The wheel as a user has it: gradients compared with differences, SciPy, JAX, and what is said of arrays that do not fit."""
import array
import decimal
import fractions
import pathlib
import sys
import threading
import unittest

import jax
import numpy as np
from scipy.optimize import check_grad, least_squares, minimize

import beam_on_ground

jax.config.update("jax_enable_x64", True)


def for_jax(problem):
    """The problem as a function that JAX differentiates."""
    count = sum(length for _, length in problem.outputs)

    @jax.custom_vjp
    def f(m):
        like_f = jax.ShapeDtypeStruct((count,), float)
        return jax.pure_callback(lambda m: problem.value(np.asarray(m)), like_f, m, vmap_method="sequential")

    def backward(m, w):
        like_m, product = jax.ShapeDtypeStruct(m.shape, float), lambda m, w: problem.vjp(np.asarray(m), np.asarray(w))
        return (jax.pure_callback(product, like_m, m, w, vmap_method="sequential"),)

    f.defvjp(lambda m: (f(m), m), backward)
    return f


def elsewhere(problem):
    """A ground that is not flat."""
    start = problem.start
    return start * (1 + 0.3 * np.sin(1.3 * np.arange(start.size)))


class Row(np.ndarray):
    """A subclass of NumPy's arrays."""


EXAMPLE = pathlib.Path(__file__).resolve().parents[1]
PAGES = [EXAMPLE.parents[1] / "docs/python.md"]


class Criterion(unittest.TestCase):
    def setUp(self):
        self.beam = beam_on_ground.level(cells=8)

    def test_shape(self):
        self.assertEqual(self.beam.inputs, [("gap", 9)])
        self.assertEqual(self.beam.outputs, [("criterion", 1)])
        self.assertEqual(repr(self.beam), "<Problem: gap (9) -> criterion (1)>")

    def test_gradient_beside_central_differences(self):
        m, t = elsewhere(self.beam), 1e-6
        value, gradient = self.beam.value_and_gradient(m)
        self.assertEqual(value, self.beam.value(m)[0])
        differences = [(self.beam.value(m + t * e) - self.beam.value(m - t * e))[0] / (2 * t) for e in np.eye(m.size)]
        self.assertLess(np.abs(differences - gradient).max(), 1e-7 * np.abs(gradient).max())
        np.testing.assert_allclose(self.beam.vjp(m, np.array([3.0])), 3 * gradient, rtol=1e-14)
        direction = np.arange(m.size, dtype=float)
        np.testing.assert_allclose(self.beam.jvp(m, direction), [gradient @ direction], rtol=1e-14)

    def test_minimisation(self):
        bounds = [(-0.1, 0.1)] * self.beam.start.size
        found = minimize(self.beam.value_and_gradient, self.beam.start, jac=True, bounds=bounds,
                         options={"ftol": 1e-15, "gtol": 1e-10})
        self.assertTrue(found.success, found)
        self.assertLess(found.fun, 1e-2 * self.beam.value(self.beam.start)[0])
        # First order: between its bounds no control would go on.
        value, gradient = self.beam.value_and_gradient(found.x)
        self.assertAlmostEqual(value / found.fun, 1, places=12)
        there = np.abs(np.clip(found.x - gradient, -0.1, 0.1) - found.x).max()
        self.assertLess(there, 1e-4 * np.abs(self.beam.value_and_gradient(self.beam.start)[1]).max())

    def test_several_threads(self):
        m = [elsewhere(self.beam) * (1 + k / 10) for k in range(4)]
        expected, found = [self.beam.value(one) for one in m], [None] * 4

        def ask(k):
            found[k] = self.beam.value(m[k])

        threads = [threading.Thread(target=ask, args=(k,)) for k in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        # Solvers remember: the order of calls shows in the last digits.
        np.testing.assert_allclose(found, expected, rtol=1e-12)


class Readings(unittest.TestCase):
    def setUp(self):
        self.beam = beam_on_ground.deflection(cells=8, points=3)

    def test_products_with_the_jacobian(self):
        m, t = elsewhere(self.beam), 1e-6
        self.assertEqual(self.beam.inputs, [("gap", 9), ("load", 1)])
        jacobian = self.beam.jacobian(m)
        steps = [t * max(abs(one), 1e-2) for one in m]
        columns = [(self.beam.value(m + h * e) - self.beam.value(m - h * e)) / (2 * h) for h, e in zip(steps, np.eye(m.size))]
        # Displacements by gaps have the size one, also where a gap is not felt.
        for computed, expected in zip(jacobian.T, columns):
            self.assertLess(np.abs(computed - expected).max(), 1e-6 * max(1, np.abs(expected).max()))
        direction, w = np.cos(np.arange(m.size)), np.arange(1.0, 7.0)
        np.testing.assert_allclose(self.beam.jvp(m, direction), jacobian @ direction, rtol=1e-12)
        np.testing.assert_allclose(self.beam.vjp(m, w), jacobian.T @ w, rtol=1e-10, atol=1e-12 * np.abs(jacobian).max())

    def test_a_load_is_found_from_displacements(self):
        truth = elsewhere(self.beam)
        truth[-1] = 1.7e-3
        measured = self.beam.value(truth)

        def with_load(load):
            return np.append(truth[:-1], load * 1e-3)

        found = least_squares(lambda load: self.beam.value(with_load(load)) - measured, [1.0],
                              jac=lambda load: self.beam.jacobian(with_load(load))[:, -1:] * 1e-3, xtol=1e-12)
        self.assertAlmostEqual(found.x[0], 1.7, places=6)

    def test_jax(self):
        f, m = for_jax(self.beam), elsewhere(self.beam)
        np.testing.assert_array_equal(f(m), self.beam.value(m))
        np.testing.assert_allclose(jax.jacrev(f)(m), self.beam.jacobian(m), rtol=1e-12, atol=1e-15)
        # A chain of what is written in JAX and what is not.
        chain = jax.jit(jax.value_and_grad(lambda scale: jax.numpy.sum(f(scale * m) ** 2)))
        error = check_grad(lambda s: float(chain(s[0])[0]), lambda s: np.array([float(chain(s[0])[1])]), [1.1], epsilon=1e-6)
        self.assertLess(error, 1e-4 * abs(float(chain(1.1)[1])))


class Mistakes(unittest.TestCase):
    def setUp(self):
        self.beam = beam_on_ground.level(cells=8)

    def said(self, kind, call, *arguments, **named):
        with self.assertRaises(kind) as caught:
            call(*arguments, **named)
        return str(caught.exception)

    def test_arrays(self):
        start, value = self.beam.start, self.beam.value
        self.assertEqual(self.said(ValueError, value, start[:-1]),
                         "the vector of controls has 8 values; the map has 9: `gap` (9)")
        self.assertIn("not contiguous", self.said(ValueError, value, np.zeros(18)[::2]))
        self.assertIn("shape [3, 3]", self.said(ValueError, value, np.zeros((3, 3))))
        self.assertIn("no array of float64 but a ndarray", self.said(TypeError, value, np.zeros(9, dtype=np.float32)))
        self.assertIn("no array of float64 but a list", self.said(TypeError, value, [0.0] * 9))
        start[2] = np.nan
        self.assertEqual(self.said(ValueError, value, start),
                         "the value NaN of `gap` in the vector of controls is not finite (its number 2)")
        self.assertIn("the cotangent has 2 values", self.said(ValueError, self.beam.vjp, self.beam.start, np.ones(2)))
        self.assertIn("the direction has 1 values", self.said(ValueError, self.beam.jvp, self.beam.start, np.ones(1)))
        readings = beam_on_ground.deflection(cells=8)
        self.assertIn("8 outputs", self.said(TypeError, readings.value_and_gradient, readings.start))

    def test_parameters(self):
        self.assertEqual(self.said(ValueError, beam_on_ground.level, cels=8),
                         "there is no parameter `cels`; there are `cells` (16), `load` (0.001)")
        self.assertIn("`cells` is 2.5", self.said(ValueError, beam_on_ground.level, cells=2.5))
        self.assertIn("`load` is no number", self.said(TypeError, beam_on_ground.level, load="much"))
        self.assertIn("by name", self.said(TypeError, beam_on_ground.level, 8))

    def test_arrays_of_other_kinds(self):
        start, value = self.beam.start, self.beam.value
        expected = value(start)
        # Bytes in the other order: read as they are these would be numbers of another size.
        swapped = start.astype(start.dtype.newbyteorder("S"))
        for call in (value, self.beam.jacobian, self.beam.value_and_gradient):
            self.assertIn("not in this machine's order", self.said(TypeError, call, swapped))
        other = ">f8" if sys.byteorder == "little" else "<f8"
        self.assertIn("the bytes of the cotangent", self.said(TypeError, self.beam.vjp, start, np.ones(1, other)))
        self.assertIn("the bytes of the direction", self.said(TypeError, self.beam.jvp, start, swapped))
        for dtype in (np.float16, np.float32, np.longdouble, np.int64, np.uint8, np.bool_, np.complex128, object):
            message = self.said(TypeError, value, np.zeros(9, dtype=dtype))
            self.assertIn(f"no array of float64 but a ndarray of {np.dtype(dtype)}", message)
        self.assertIn("a single number and no row", self.said(ValueError, value, np.array(0.1)))
        self.assertIn("shape [1, 9]", self.said(ValueError, value, np.matrix(start)))
        for strided in (np.zeros((9, 2))[:, 0], start[::-1], np.broadcast_to(0.1, 9)):
            self.assertIn("not contiguous", self.said(ValueError, value, strided))
        unaligned = np.frombuffer(b"-" + start.tobytes(), dtype=float, offset=1)
        self.assertIn("not aligned", self.said(ValueError, value, unaligned))
        masked = np.ma.masked_array(start, mask=np.arange(9) == 3)
        self.assertIn("masked values", self.said(ValueError, value, masked))
        # What has the same numbers is the same: read-only, of a subclass, of another package, of a native format with a prefix.
        frozen = start.copy()
        frozen.flags.writeable = False
        same = (frozen, start.view(Row), np.ma.masked_array(start), array.array("d", start), memoryview(start),
                np.zeros((9, 1)).reshape(9) + start, start.astype("=f8"))
        for one in same:
            np.testing.assert_array_equal(value(one), expected)
        for number in (np.inf, -np.inf, np.nan):
            start[0] = number
            self.assertIn("is not finite", self.said(ValueError, value, start))

    def test_parameters_of_other_kinds(self):
        level = beam_on_ground.level
        for cells in (True, np.True_, np.array(True), 8j, np.complex64(8), np.complex128(8), "8", np.str_("8"), None,
                      np.timedelta64(8, "s"), np.array([8]), np.array([[8.0]]), [8]):
            self.assertIn("`cells` is no number", self.said(TypeError, level, cells=cells))
        self.assertIn("beyond the range", self.said(ValueError, level, load=10**400))
        for load in (np.nan, np.inf, np.float32("nan")):
            self.assertIn("not finite", self.said(ValueError, level, load=load))
        for cells in (8, 8.0, np.int64(8), np.uint8(8), np.float32(8), np.float64(8), np.array(8), np.longdouble(8),
                      fractions.Fraction(8), decimal.Decimal(8)):
            self.assertEqual(level(cells=cells).inputs, [("gap", 9)])

    def test_equations_without_a_solution(self):
        # Linear elasticity bears any load and any gap, as long as their squares are numbers.
        self.assertTrue(self.said(RuntimeError, self.beam.value, np.full(9, -1e300)))
        self.assertTrue(np.isfinite(self.beam.value(self.beam.start)[0]))


class Pages(unittest.TestCase):
    @unittest.skipUnless(all(page.exists() for page in PAGES), "a copy outside of the project")
    def test_the_script_is_the_one_that_runs(self):
        script = (EXAMPLE / "minimise.py").read_text()
        for page in PAGES:
            self.assertIn(f"```python\n{script}```", page.read_text(), page)


if __name__ == "__main__":
    unittest.main()
