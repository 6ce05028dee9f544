"""Compares figures: Pareto fronts, costs at equal error, exponents, and the rows that are better than another. Pure."""
import math

# The 97.5 % quantiles of Student's t distribution for 1, 2, .. degrees of freedom.
T_975 = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131)
T_975_MANY = 1.96


def pareto(points):
    """The Pareto front of (cost, error) points: their indices, by cost. Equal points are all on the front."""
    front, best = [], math.inf
    for i in sorted(range(len(points)), key=lambda k: points[k]):
        cost, error = points[i]
        if error < best:
            front.append(i)
            best = error
        elif error == best and points[front[-1]] == (cost, error):
            front.append(i)
    return front


def exponent(xs, ys):
    """The least-squares fit of log y over log x: {"exponent", "interval", "factor", "spread", "points"}.

    `interval` is half the width of the exponent's 95 % confidence interval, or None for two points. `spread` is the
    largest ratio between a measured y and the fitted y. Returns None if there are fewer than two different xs.
    """
    pairs = [(math.log(x), math.log(y)) for x, y in zip(xs, ys) if x > 0 and y > 0]
    n = len(pairs)
    if len({x for x, _ in pairs}) < 2:
        return None
    mean_x, mean_y = sum(x for x, _ in pairs) / n, sum(y for _, y in pairs) / n
    across = sum((x - mean_x) ** 2 for x, _ in pairs)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in pairs) / across
    off = [y - (mean_y + slope * (x - mean_x)) for x, y in pairs]
    interval = None
    if n > 2:
        t = T_975[n - 3] if n - 3 < len(T_975) else T_975_MANY
        interval = t * math.sqrt(sum(o * o for o in off) / (n - 2) / across)
    return {"exponent": slope, "interval": interval, "factor": math.exp(mean_y - slope * mean_x),
            "spread": math.exp(max(map(abs, off))), "points": n}


def cost_at(curve, error):
    """The cost at which a curve of (cost, error) points reaches this error: (cost, how).

    Interpolates the logarithm of the cost linearly between the points of the Pareto front. `how` is "between"; or
    "at most" if the error of the cheapest point is smaller; or "never" if no point reaches the error (cost None).
    """
    front = [curve[i] for i in pareto(curve)]
    if not front or front[-1][1] > error:
        return None, "never"
    if front[0][1] <= error:
        return front[0][0], "between" if front[0][1] == error else "at most"
    for (cheap, worse), (dear, better) in zip(front, front[1:]):
        if better <= error <= worse:
            if worse == better:
                return cheap, "between"
            share = (worse - error) / (worse - better)
            if cheap <= 0:  # 0 has no logarithm
                return cheap + share * (dear - cheap), "between"
            return math.exp(math.log(cheap) + share * (math.log(dear) - math.log(cheap))), "between"
    return None, "never"


def better_in_both(rows, own, cost, error):
    """The rows that are at least as good as `own` in `cost` and in `error`, and better in one of them; by error."""
    found = [r for r in comparable(rows, own, cost, error) if r[cost] <= own[cost] and r[error] <= own[error]
             and (r[cost], r[error]) != (own[cost], own[error])]
    return sorted(found, key=lambda r: r[error])


def less_in_both(rows, own, cost, error):
    """The rows that have both less `cost` and less `error` than `own`; by error."""
    found = [r for r in comparable(rows, own, cost, error) if r[cost] < own[cost] and r[error] < own[error]]
    return sorted(found, key=lambda r: r[error])


def comparable(rows, own, *figures):
    """The rows besides `own` that have all these figures. Empty if `own` lacks one."""
    if any(own.get(f) is None for f in figures):
        return []
    return [r for r in rows if r is not own and all(r.get(f) is not None for f in figures)]


def grouped(rows, *keys):
    """Groups rows by the values of keys. The groups are in the order of their first rows."""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[k] for k in keys), []).append(row)
    return groups
