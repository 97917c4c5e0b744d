"""Newton's method for forms of NGSolve."""

from math import inf

import ngsolve as ng


def newton(form, state, free, tolerance=1e-10, most=60):
    """Undamped steps until the change is this part of the state; their number. Prescribed values are in the state."""
    residual = state.vec.CreateVector()
    for iteration in range(1, most + 1):
        form.Apply(state.vec, residual)
        form.AssembleLinearization(state.vec)
        change = (form.mat.Inverse(free, inverse="umfpack") * residual).Evaluate()
        state.vec.data -= change
        if not change.Norm() < inf:
            raise ArithmeticError("overflow")
        if change.Norm() <= tolerance * state.vec.Norm():
            return iteration
    raise ArithmeticError(f"no convergence in {most} steps")


def negative_part(value):
    return ng.IfPos(value, 0, -value)
