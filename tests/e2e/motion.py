"""Analysis of a walk from the true states of the simulator. World: z up; body: x forward, y left."""

import bisect
import math

# Gait table: cycle and speed of the body at 40 deg of sweep.
CYCLE_S = {"low": 19.8, "medium": 9.9, "high": 6.6}
SPEED_M_S = {"low": 0.0022, "medium": 0.0053, "high": 0.0101}


def yaw(state):
    w, x, y, z = state["attitude_wxyz"]
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def at(truth, time_ns):
    """The state seen last at that time."""
    index = bisect.bisect_right(truth.samples, time_ns, key=lambda sample: sample[0])
    return truth.samples[max(0, index - 1)][1]


def between(truth, begin_ns, end_ns):
    return [state for time_ns, state in truth.samples if begin_ns <= time_ns <= end_ns]


def moved(begin, end):
    """(forward_m, left_m, turned_rad) in the body frame of the beginning; turned counter-clockwise positive."""
    dx, dy = (end["position_m"][i] - begin["position_m"][i] for i in (0, 1))
    c, s = math.cos(yaw(begin)), math.sin(yaw(begin))
    turned = (yaw(end) - yaw(begin) + math.pi) % (2 * math.pi) - math.pi
    return c * dx + s * dy, c * dy - s * dx, turned


def whole_cycles(truth, span, speed, cycles):
    """First and last state of the last whole gait cycles of a walk, and the simulated time between them."""
    end_ns = span[1]
    begin_ns = end_ns - int(cycles * CYCLE_S[speed] * 1e9)
    if begin_ns < span[0]:
        raise AssertionError(f"the walk has no {cycles} cycles: {(span[1] - span[0]) / 1e9:.1f} s")
    first, last = at(truth, begin_ns), at(truth, end_ns)
    simulated_s = last["t_s"] - first["t_s"]
    if abs(simulated_s - cycles * CYCLE_S[speed]) > 0.05 * cycles * CYCLE_S[speed] + 0.2:
        raise AssertionError(f"the simulator lost time: {simulated_s:.2f} s in {cycles * CYCLE_S[speed]:.2f} s")
    return first, last, simulated_s
