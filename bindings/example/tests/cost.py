"""Microseconds of a value with its gradient through Python, for comparison with `examples/cost.rs`."""
import time

from beam_on_ground import level


def microseconds(call):
    """Of a call: the least of some."""
    least = float("inf")
    for _ in range(200):
        begun = time.perf_counter()
        call()
        least = min(least, time.perf_counter() - begun)
    return 1e6 * least


beam = level()
m = beam.start


def moved():
    m[1] += 1e-9
    beam.value_and_gradient(m)


solved = microseconds(moved)
print(f"value and gradient: {solved:.1f} µs; of the last controls {microseconds(lambda: beam.value_and_gradient(m)):.2f} µs")
