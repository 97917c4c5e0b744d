"""What must hold before a reference is written."""
import numpy as np


def check_tangent(residual, tangent, u, step, tolerance):
    """Every column against central differences, relative to the largest entry."""
    for column in range(len(u)):
        moved = np.zeros(len(u))
        moved[column] = step
        difference = (residual(u + moved) - residual(u - moved)) / (2 * step)
        error = np.abs(difference - np.asarray(tangent @ (moved / step)).ravel()).max()
        assert error < tolerance * abs(tangent).max(), (column, error, abs(tangent).max())


def close(a, b):
    """Equal to 1e-13 of the largest entry."""
    assert abs(a - b).max() < 1e-13 * abs(a).max(), abs(a - b).max() / abs(a).max()


def symmetric(matrix):
    """Equal to its transpose."""
    close(matrix, matrix.T)
