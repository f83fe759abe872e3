"""Compiled kernels for rollouts of the body's motion, which all controllers share.

*field* (H, W) float32: at each cell's middle the distance (m) to the nearest obstacle; *frame*: x and y of its lower
left corner (m) and 1 / resolution. Places beyond its edge read as the nearest cell inside. Poses and paths are in the
field's own coordinates. *outline* (P, 2) float64: points of the body's edge, and as many of a line within it (m in
``base_link``), neighbours at most ``SPACING_M`` apart; *radii*: of the largest circle about ``base_link`` that the
body covers, and of the smallest that covers the body. *limits*: least and greatest linear velocity (m/s), greatest
turn (rad/s), linear and angular acceleration (m/s^2, rad/s^2), linear braking (m/s^2), greatest lateral velocity (m/s;
0: the body cannot move sideways, and nothing is computed for it). *state*: x, y, theta, linear, angular and lateral
velocity. *path* (N, 5) float64, evenly ``spacing`` m apart: x, y, heading, length so far (m), greatest
speed there (m/s). Clearances are those of the body's edge.
"""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

import math

import numpy as np

from app.base.compiled import kernel

#: Greatest spacing of neighbouring outline points (m).
SPACING_M = 0.02
#: Cost of a rollout with contact: more than all other costs together.
COLLISION = 1e4

_FIELD = "float32[:,::1], UniTuple(float64, 3)"
_BODY = "float64[:,::1], UniTuple(float64, 2), UniTuple(float64, 7)"
_STATE = "UniTuple(float64, 6)"


@kernel("float64(float32[:,::1], UniTuple(float64, 3), float64, float64)")
def distance_at(field, frame, x, y):
    """Distance (m) from (x, y) to the nearest obstacle, bilinear between the middles of cells."""
    rows, columns = field.shape
    u = min(max((x - frame[0]) * frame[2] - 0.5, 0.0), columns - 1.001)
    v = min(max((y - frame[1]) * frame[2] - 0.5, 0.0), rows - 1.001)
    j, i = int(u), int(v)
    a, b = u - j, v - i
    low = field[i, j] * (1.0 - a) + field[i, j + 1] * a
    high = field[i + 1, j] * (1.0 - a) + field[i + 1, j + 1] * a
    return low * (1.0 - b) + high * b


@kernel(f"float64({_FIELD}, float64[:,::1], UniTuple(float64, 2), float64, float64, float64)")
def clearance_at(field, frame, outline, radii, x, y, theta):
    """Distance (m) from the body's edge to the nearest obstacle; negative where an obstacle reaches deep into it.

    Exact to about a cell near obstacles (a thin one between two outline points reads as half their spacing away); at
    distances beyond the body's size, a lower bound.
    """
    middle = distance_at(field, frame, x, y)
    if middle <= radii[0]:
        return middle - radii[0]
    if middle >= 2.0 * radii[1]:
        return middle - radii[1]
    least = middle - radii[0]
    c, s = math.cos(theta), math.sin(theta)
    ring = len(outline) // 2
    for first in (0, ring):
        k = first
        while k < first + ring:
            px, py = outline[k, 0], outline[k, 1]
            here = distance_at(field, frame, x + c * px - s * py, y + s * px + c * py)
            least = min(least, here)
            # Distance is Lipschitz: neighbours within the difference to the least so far cannot be nearer.
            k += 1 + int((here - least) / SPACING_M)
    return least


@kernel("float64(float64, float64, float64)")
def ramp(value, target, step):
    """``value`` moved towards ``target`` by at most ``step``."""
    return value + min(max(target - value, -step), step)


@kernel("UniTuple(float64, 2)(float64, float64, UniTuple(float64, 7))")
def within(v, u, limits):
    """The linear and lateral velocities (``v``, ``u``), shortened into the ellipse of both limits."""
    if limits[6] <= 0.0:
        return min(max(v, limits[0]), limits[1]), 0.0
    v = max(v, limits[0])
    share = math.hypot(v / limits[1], u / limits[6])
    return (v, u) if share <= 1.0 else (v / share, u / share)


@kernel(f"{_STATE}({_STATE}, float64, float64, float64, UniTuple(float64, 7), float64)")
def driven(state, linear, angular, lateral, limits, time_s):
    """The state after ``time_s`` of the command (linear, angular, lateral), with the body's accelerations."""
    x, y, theta, v, w, u = state
    w1 = ramp(w, angular, limits[4] * time_s)
    mean_w = 0.5 * (w + w1)
    middle = theta + 0.5 * mean_w * time_s
    if limits[6] <= 0.0:
        braking = abs(linear) < abs(v) or linear * v < 0.0
        v1 = ramp(v, linear, (limits[5] if braking else limits[3]) * time_s)
        mean_v = 0.5 * (v + v1)
        return (
            x + mean_v * math.cos(middle) * time_s,
            y + mean_v * math.sin(middle) * time_s,
            theta + mean_w * time_s,
            v1,
            w1,
            0.0,
        )
    # Linear and lateral velocity change together, on a straight line.
    braking = math.hypot(linear, lateral) < math.hypot(v, u) or linear * v + lateral * u < 0.0
    most = (limits[5] if braking else limits[3]) * time_s
    change = math.hypot(linear - v, lateral - u)
    part = min(1.0, most / max(change, 1e-12))
    v1, u1 = v + part * (linear - v), u + part * (lateral - u)
    mean_v, mean_u = 0.5 * (v + v1), 0.5 * (u + u1)
    c, d = math.cos(middle) * time_s, math.sin(middle) * time_s
    return (x + mean_v * c - mean_u * d, y + mean_v * d + mean_u * c, theta + mean_w * time_s, v1, w1, u1)


@kernel(f"boolean({_FIELD}, {_BODY}, {_STATE}, UniTuple(float64, 3), float64, float64)")
def can_stop(field, frame, outline, radii, limits, state, command, hold_s, margin):
    """Whether ``command`` (linear, angular, lateral) for ``hold_s`` and then braking keeps the clearance at ``margin``
    (m).

    A body that is nearer already may move as long as the clearance does not fall.
    """
    x, y, theta, v, w, u = state
    margin = min(margin, clearance_at(field, frame, outline, radii, x, y, theta))
    held = 0.0
    # Upper bound of the braking time.
    for _ in range(400):
        if held < hold_s:
            state = driven(state, command[0], command[1], command[2], limits, 0.05)
            held += 0.05
        else:
            # The arc is kept while braking: all velocities fall in proportion.
            v, w, u = state[3], state[4], state[5]
            if abs(v) < 1e-3 and abs(w) < 1e-2 and abs(u) < 1e-3:
                return True
            state = driven(state, 0.0, 0.0, 0.0, limits, 0.05)
        if clearance_at(field, frame, outline, radii, state[0], state[1], state[2]) < margin:
            return False
    return True


@kernel("int64(float64[:,::1], int64, int64, float64, float64)")
def nearest_on(path, first, last, x, y):
    """Index in [first, last] of the path's point nearest to (x, y)."""
    first, last = max(first, 0), min(last, len(path) - 1)
    best, least = first, 1e18
    for k in range(first, last + 1):
        d = (path[k, 0] - x) ** 2 + (path[k, 1] - y) ** 2
        if d < least:
            best, least = k, d
    return best


@kernel(
    f"UniTuple(float64, 4)({_FIELD}, {_BODY}, {_STATE}, float64[:,::1], UniTuple(int64, 2), UniTuple(float64, 4), "
    "float64, float64, float64, float64, boolean)"
)
def dynamic_window(
    field, frame, outline, radii, limits, state, path, samples, weights, period_s, horizon_s, margin, sight_m, strict
):
    """The best of ``samples`` (linear, angular) velocities reachable within ``period_s``: linear, angular, cost,
    clearance.

    Each is rolled out for ``horizon_s``. It is rejected if the body could not stop before an obstacle (``strict``: if
    the rollout has contact at all); the cost is infinite where all are rejected. ``weights``: of the end's distance to
    the path (m), its distance to the path's end (m), 1 / clearance beyond ``margin`` (within ``sight_m``), and unused
    speed (m/s).
    """
    v0, w0 = state[3], state[4]
    v_low, v_high = max(limits[0], v0 - limits[5] * period_s), min(limits[1], v0 + limits[3] * period_s)
    v_high = max(v_high, v_low)
    w_low, w_high = max(-limits[2], w0 - limits[4] * period_s), min(limits[2], w0 + limits[4] * period_s)
    best, best_v, best_w, best_clear = np.inf, 0.0, 0.0, 0.0
    goal_x, goal_y = path[-1, 0], path[-1, 1]
    at = nearest_on(path, 0, len(path) - 1, state[0], state[1])
    for a in range(samples[0]):
        v = v_low + (v_high - v_low) * a / max(samples[0] - 1, 1)
        # One sample is exactly straight, whatever the window's ends.
        for b in range(samples[1] + 1):
            w = w_low + (w_high - w_low) * b / max(samples[1] - 1, 1)
            if b == samples[1]:
                w = min(max(0.0, w_low), w_high)
            if not can_stop(field, frame, outline, radii, limits, state, (v, w, 0.0), period_s, margin):
                continue
            now, clear, touched, time = state, sight_m, False, 0.0
            while time < horizon_s - 1e-9:
                now = driven(now, v, w, 0.0, limits, 0.1)
                time += 0.1
                here = clearance_at(field, frame, outline, radii, now[0], now[1], now[2])
                clear = min(clear, here)
                if here < margin:
                    touched = True
                    break
            if touched and strict:
                continue
            k = nearest_on(path, at, len(path) - 1, now[0], now[1])
            off = math.hypot(path[k, 0] - now[0], path[k, 1] - now[1])
            # Remaining distance: along the path, and back to it.
            remaining = math.hypot(goal_x - now[0], goal_y - now[1])
            cost = weights[0] * off + weights[1] * remaining + weights[3] * (limits[1] - v)
            cost += weights[2] * (1.0 / max(clear - margin + 0.05, 0.02) - 1.0 / (sight_m + 0.05))
            if touched:
                cost += 1.0
            if cost < best:
                best, best_v, best_w, best_clear = cost, v, w, clear
    return (best_v, best_w, best, best_clear)


@kernel(
    f"float64({_FIELD}, {_BODY}, {_STATE}, float64[:,::1], float64, float64[:,::1], float64, float64, "
    "UniTuple(float64, 9))"
)
def cost_of(field, frame, outline, radii, limits, state, path, spacing, controls, time_s, margin, weights):
    """Cost (s) of ``controls`` (T, 2; T, 3 with a lateral velocity), each for ``time_s``: time lost, plus risk in
    seconds.

    ``weights``: of the squared offset from the path (1/m^2), of low clearance, its range (m), the allowed speed (m/s)
    at zero clearance and its increase with it (1/s), of excess speed, of heading away from the path, of angular
    accelerations, of driving backward.
    """
    w_path, w_near, reach, v_near, v_grow, w_fast, w_heading, w_smooth, w_back = weights
    cost, on_the_way, last = 0.0, 0.0, len(path) - 1
    at = nearest_on(path, 0, last, state[0], state[1])
    begin = path[at, 3]
    window = int(max(limits[1], limits[6]) * time_s / spacing) + 3
    start_clear = clearance_at(field, frame, outline, radii, state[0], state[1], state[2])
    margin = min(margin, start_clear)
    before_v, before_w, before_u = state[3], state[4], state[5]
    sideways = limits[6] > 0.0
    for t in range(len(controls)):
        v, u = within(controls[t, 0], controls[t, 2] if sideways else 0.0, limits)
        w = min(max(controls[t, 1], -limits[2]), limits[2])
        state = driven(state, v, w, u, limits, time_s)
        clear = clearance_at(field, frame, outline, radii, state[0], state[1], state[2])
        if clear < margin:
            # Later risk counts less: the controller can still change its plan.
            return cost + COLLISION * (1.0 + (len(controls) - t) / len(controls))
        at = nearest_on(path, at - 2, at + window, state[0], state[1])
        dx, dy = state[0] - path[at, 0], state[1] - path[at, 1]
        off = min(dx * dx + dy * dy, 1.0)
        speed = math.hypot(state[3], state[5]) if sideways else abs(state[3])
        step = w_path * off + w_near * math.exp(-max(clear, 0.0) / reach) * speed / limits[1]
        excess = speed - min(path[at, 4], limits[1] * (v_near + v_grow * max(clear, 0.0)))
        if excess > 0.0:
            step += w_fast * (excess / limits[1]) ** 2
        if state[3] < 0.0:
            step -= w_back * state[3]
        step += w_heading * (1.0 - math.cos(state[2] - path[at, 2]))
        cost += step * time_s
        cost += w_smooth * (((v - before_v) / limits[1]) ** 2 + ((w - before_w) / limits[2]) ** 2)
        if sideways:
            cost += w_smooth * ((u - before_u) / limits[1]) ** 2
        before_v, before_w, before_u = v, w, u
        on_the_way += path[at, 3] - begin
    off = math.hypot(state[0] - path[at, 0], state[1] - path[at, 1])
    # Progress at the end and over the horizon: an early arrival counts where the path ends within it.
    return cost - (path[at, 3] - begin - off + on_the_way / len(controls)) / limits[1]


@kernel(
    f"void(UniTuple(float64, 7), {_STATE}, float64[:,::1], float64, float64, float64, boolean, float64[:,::1], float64)"
)
def pursue(limits, state, path, spacing, ahead_m, share, strafing, controls, time_s):
    """Write the controls (T, 2 or 3) of pure pursuit into ``controls``: toward the path's point ``ahead_m`` ahead, at
    ``share`` of its speeds. ``strafing``: straight toward it, while the body turns along the path; else along an arc.
    """
    last = len(path) - 1
    at = nearest_on(path, 0, last, state[0], state[1])
    window = int(max(limits[1], limits[6]) * time_s / spacing) + 3
    for t in range(len(controls)):
        at = nearest_on(path, at - 2, at + window, state[0], state[1])
        aim = min(at + max(1, int(ahead_m / spacing)), last)
        dx, dy = path[aim, 0] - state[0], path[aim, 1] - state[1]
        distance = math.hypot(dx, dy)
        bearing = math.atan2(dy, dx) - state[2]
        bearing = math.atan2(math.sin(bearing), math.cos(bearing))
        speed = share * min(limits[1], path[at, 4])
        u = 0.0
        if distance < spacing:
            v, w = 0.0, 0.0
        elif strafing:
            v, u = within(1e3 * math.cos(bearing), 1e3 * math.sin(bearing), limits)
            slower = min(1.0, speed / max(math.hypot(v, u), 1e-6))
            v, u = slower * v, slower * u
            off = path[aim, 2] - state[2]
            w = min(max(2.0 * math.atan2(math.sin(off), math.cos(off)), -limits[2]), limits[2])
        elif abs(bearing) > 1.2:
            # A turn on the spot, at a rate from which it can stop in time.
            v, w = 0.0, math.copysign(min(limits[2], math.sqrt(limits[4] * abs(bearing))), bearing)
        else:
            curvature = 2.0 * math.sin(bearing) / distance
            v = min(speed, 0.8 * limits[2] / max(abs(curvature), 1e-6))
            w = curvature * v
        controls[t, 0], controls[t, 1] = v, w
        if limits[6] > 0.0:
            controls[t, 2] = u
        state = driven(state, v, w, u, limits, time_s)


@kernel("void(float64[:,::1], float64[:,::1], UniTuple(float64, 7))")
def clamp(controls, into, limits):
    """Write ``controls`` (T, C), clamped to the body's speeds, into ``into``."""
    for t in range(len(controls)):
        v, u = within(controls[t, 0], controls[t, 2] if limits[6] > 0.0 else 0.0, limits)
        into[t, 0], into[t, 1] = v, min(max(controls[t, 1], -limits[2]), limits[2])
        if limits[6] > 0.0:
            into[t, 2] = u


@kernel(
    f"float64({_FIELD}, {_BODY}, {_STATE}, float64[:,::1], float64, float64[:,::1], float64[:,:,::1], "
    "UniTuple(float64, 3), float64, float64, UniTuple(float64, 9), float64)"
)
def improve(
    field,
    frame,
    outline,
    radii,
    limits,
    state,
    path,
    spacing,
    controls,
    noise,
    sigma,
    time_s,
    margin,
    weights,
    temperature,
):
    """Improve ``controls`` (T, C) in place by one step of MPPI (Williams et al., 2017); returns their cost.

    C is 2, and 3 for a body that moves sideways. ``noise`` (K, knots, C) float64, standard normal: interpolated
    linearly between knots, scaled by ``sigma`` (m/s, rad/s, m/s). The mean of all, weighted by exp(-cost /
    ``temperature``), replaces the controls if it costs less.
    """
    steps, knots = len(controls), noise.shape[1]
    count = len(noise)
    costs = np.empty(count + 1)
    columns = controls.shape[1]
    tried = np.empty((count + 1, steps, columns))
    for k in range(count + 1):
        for t in range(steps):
            v, w = controls[t, 0], controls[t, 1]
            place = t * (knots - 1) / max(steps - 1, 1)
            i = min(int(place), knots - 2)
            a = place - i
            if k < count:
                v += sigma[0] * (noise[k, i, 0] * (1.0 - a) + noise[k, i + 1, 0] * a)
                w += sigma[1] * (noise[k, i, 1] * (1.0 - a) + noise[k, i + 1, 1] * a)
            # Samples may exceed the limits: clipped noise would bias the mean below the greatest speed.
            tried[k, t, 0], tried[k, t, 1] = v, w
            if columns == 3:
                u = controls[t, 2]
                if k < count:
                    u += sigma[2] * (noise[k, i, 2] * (1.0 - a) + noise[k, i + 1, 2] * a)
                tried[k, t, 2] = u
        costs[k] = cost_of(
            field, frame, outline, radii, limits, state, path, spacing, tried[k], time_s, margin, weights
        )
    best = np.argmin(costs)
    total = 0.0
    mean = np.zeros((steps, columns))
    for k in range(count + 1):
        weight = math.exp(-(costs[k] - costs[best]) / temperature)
        if weight > 1e-6:
            total += weight
            for t in range(steps):
                for j in range(columns):
                    mean[t, j] += weight * tried[k, t, j]
    for t in range(steps):
        for j in range(columns):
            mean[t, j] /= total
    clamp(mean, mean, limits)
    cost = cost_of(field, frame, outline, radii, limits, state, path, spacing, mean, time_s, margin, weights)
    # A single sample is as rough as its noise: used only where no other is free of contact.
    if cost < costs[count] - 1e-3:
        for t in range(steps):
            for j in range(columns):
                controls[t, j] = mean[t, j]
        return cost
    if costs[count] >= COLLISION and costs[best] < COLLISION:
        clamp(tried[best], controls, limits)
        return costs[best]
    return costs[count]
