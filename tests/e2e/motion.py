"""Analysis of a walk from the true states of the simulator. World: z up; body: x forward, y left."""

import bisect
import math

# Gait table: cycle and speed of the body at 40 deg of sweep.
CYCLE_S = {"low": 19.8, "medium": 9.9, "high": 6.6}
SPEED_M_S = {"low": 0.0022, "medium": 0.0053, "high": 0.0101}
# The true motion over whole cycles, of 30 seeds (tests/zebro/chain/gait_speed_test.cpp): low -1.9 to -1.1 % off the table,
# medium -5.2 to -4.4 %, high 2.5 to 3.2 %, backward 2.9 to 4.2 %; turning clockwise 5.84 to 5.90 deg/s, else 6.04 to 6.11.
# The program's walks go on from one order to the next; theirs were -0.5 to 3.9 % off, and 5.86 and 6.19 deg/s.
SHARE = 0.07
TURN_DEG_S, TURN_SHARE = {"clockwise": -5.87, "counter-clockwise": 6.09}, 0.05


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
