"""Strategy selection: how long a proven optimum takes, beside the direct formulation in CP-SAT and hbba_lite.

Cases: Tableau 4.4 with all seven desires; K classes of four strategies (φ 1, 2, 4, 8; utility 8/φ; CPU 5–40 % divided
by φ) that all contend for half the CPU they would take at full rate, some for a few single-slot actuators too; the same
with several such resources, 20 problems of each kind, in CPU time. *Reasons* are what `explain` finds for each desire
after the solution, over 20 problems of each kind too (200 strategies with four graded resources: 3; 500 strategies: 8);
*each variant searched for itself* is the same without the compiled search, each changed problem being stated anew.

Two peers run beside it. *Direct* is what one writes first: equations 4.4–4.10 with free products f·a, handed to CP-SAT
as it comes; it finds Ω only. *Tuned* is our own formulation for CP-SAT (one worker, ``linearization_level=2``, f_k tied
to its strategies), which decides every tie as ours does. hbba_lite's times are quoted: CPU time per solve of its
solver, built and run on the same instances on another day (2 cores, g++ 12). It has no dependencies, desired utility,
security or time limit.
"""

from __future__ import annotations

import json
import os
import random
import statistics
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import patch

from app.attention.cached_solver import CachedSolver
from app.attention.cpsat import solve_cpsat
from app.attention.desires import Desire, Source
from app.attention.explaining import EXPLAIN_S
from app.attention.integer_program import build_integer_program
from app.attention.problem import SelectionProblem
from app.attention.reasons import explain
from app.attention.solver import solve
from app.attention.strategies import Strategy
from app.messages import Reason
from benchmarks.report import Row, benchmark_main, row

BENCHMARK = "solver"
DIRECT = "CP-SAT, direct"
TUNED = "CP-SAT, tuned"
EACH = "each variant searched for itself"
PEER_LIMIT_S = 2.0
LIMIT_S = 0.1
"""The time limit of the case of 1000 strategies."""

HBBA_LITE_MS = {
    "thesis_table_4_4": "0.18",
    "S050_K010_A05": "0.22",
    "S050_K010_A07": "1.1",
    "S050_K010_A10": "10",
    "S050_K025_A15": "151",
    "S050_K025_A20": "7500, two of five > 30 s",
    "S050_K025_A25": "8200, two of three > 60 s",
    "synth_K13_per4": "11 to 20,000",
    "S200_K050_A05": "0.80",
    "S200_K050_A07": "2.3",
    "S200_K050_A10": "50",
    "S200_K050_A15": "170, 9760, > 60 s",
    "S200_K020_A10": "186",
    "S200_K020_A15": "544, 32,070, > 60 s",
    "synth_K20_per10": "30 s once, twice > 60 s",
    "synth_K40_per5": "> 60 s, no answer",
    "synth_K50_per4": "> 60 s, no answer",
    "synth_K100_per2": "> 60 s, no answer",
}
"""Medians in ms of CPU, as measured, by family of instances."""


def run(rounds_share: float = 1.0) -> list[Row]:
    """All rows, at this share of the usual rounds. Takes under a minute."""
    rows = []
    table = tableau_4_4()
    rows += compare(
        "13 strategies, Tableau 4.4",
        [table],
        rounds=round(60 * rounds_share),
        peer_rounds=max(1, round(10 * rounds_share)),
    )
    for classes, rounds, peer_rounds in ((7, 24, 6), (13, 24, 3), (50, 12, 1)):
        instances = [contention(classes, seed) for seed in range(6)]
        case = f"{4 * classes} strategies, {classes} classes"
        rows += compare(case, instances, max(2, round(rounds * rounds_share)), peer_rounds)
    rows += limited(contention(250, 1))
    solve(several(7, 4, 0))
    for classes, resources, peer_seeds in ((13, 3, 10), (25, 3, 6), (50, 2, 4), (50, 4, 2)):
        seeds = max(2, round(20 * rounds_share))
        rows += graded(classes, resources, seeds, max(1, min(seeds, round(peer_seeds * rounds_share))))
    rows += explained("13 strategies, Tableau 4.4", [table] * 5, peers=0)
    seeds = max(3, round(20 * rounds_share))
    for classes, peers in ((13, 5), (50, 2), (125, 0)):
        count = min(seeds, 8) if classes == 125 else seeds
        rows += explained(
            f"{4 * classes} strategies, {classes} classes", [contention(classes, seed) for seed in range(count)], peers
        )
    for classes, resources in ((13, 3), (25, 3), (50, 2), (50, 4)):
        case = f"{4 * classes} strategies, {resources} graded resources"
        rows += explained(
            case, [several(classes, resources, seed) for seed in range(3 if resources == 4 else seeds)], peers=0
        )
    return rows


def compare(case: str, problems: Sequence[SelectionProblem], rounds: int, peer_rounds: int) -> list[Row]:
    """Cold and cached times over ``problems`` in turn, the peer on the first ``peer_rounds`` of the same."""
    solve(problems[0])
    solve_cpsat(build_integer_program(problems[0]), time.perf_counter() + 30)
    ours, theirs, tuned, cached, proven = [], [], [], [], True
    for number in range(rounds):
        problem = problems[number % len(problems)]
        began = time.perf_counter()
        selection = solve(problem, time_limit_s=30)
        ours.append((time.perf_counter() - began) * 1e3)
        proven = proven and selection.proven
        if number < peer_rounds:
            began = time.perf_counter()
            omega = direct(problem)
            theirs.append((time.perf_counter() - began) * 1e3)
            began = time.perf_counter()
            solve_cpsat(build_integer_program(problem), time.perf_counter() + 30)
            tuned.append((time.perf_counter() - began) * 1e3)
            if omega is not None and abs(omega - selection.omega) > 1e-6:
                raise AssertionError(f"{case}: Ω is {selection.omega} here and {omega} there")
        memory = CachedSolver()
        memory.solve(problem)
        again = SelectionProblem(dict(problem.desires), problem.strategies, dict(problem.capacities))
        began = time.perf_counter()
        memory.solve(again)
        cached.append((time.perf_counter() - began) * 1e3)
    slow = f" (stopped at {PEER_LIMIT_S:g} s)" if max(theirs) > PEER_LIMIT_S * 990 else ""
    return [
        row(BENCHMARK, case, "cold, proven" if proven else "cold, NOT PROVEN", "ms", ours),
        row(BENCHMARK, case, "cold, beside a peer", "ms", ours[: len(theirs)], theirs, DIRECT + slow),
        row(BENCHMARK, case, "cold, beside a peer", "ms", ours[: len(tuned)], tuned, TUNED),
        row(BENCHMARK, case, "cold, 99th percentile", "ms", [percentile(ours, 0.99)]),
        row(BENCHMARK, case, "cached", "ms", cached),
        row(BENCHMARK, case, "cached, 99th percentile", "ms", [percentile(cached, 0.99)]),
    ]


def limited(problem: SelectionProblem) -> list[Row]:
    """1000 strategies: the best within the limit and its bound, and the time to the proof."""
    case = f"{len(problem.strategies)} strategies, {len(problem.desires)} classes"
    within, gaps, whole = [], [], []
    for _ in range(5):
        began = time.perf_counter()
        best = solve(problem, time_limit_s=LIMIT_S)
        within.append((time.perf_counter() - began) * 1e3)
        gaps.append(100 * (best.bound - best.omega) / best.bound)
    for _ in range(3):
        began = time.perf_counter()
        proven = solve(problem, time_limit_s=20)
        whole.append((time.perf_counter() - began) * 1e3)
    ended = "to the proof" if proven.proven else "NOT PROVEN in 20 s"
    return [
        row(BENCHMARK, case, f"limit {LIMIT_S * 1e3:g} ms: time taken", "ms", within),
        row(BENCHMARK, case, f"limit {LIMIT_S * 1e3:g} ms: Ω below its bound", "%", gaps),
        row(BENCHMARK, case, ended, "ms", whole),
    ]


def graded(classes: int, resources: int, seeds: int, peer_seeds: int) -> list[Row]:
    """Time to the proof, all ties decided, where all contend for half of each of several resources; beside CP-SAT on
    the first ``peer_seeds`` of the same problems, which must select the same."""
    case = f"{4 * classes} strategies, {resources} graded resources"
    took, peer, unproven = [], [], 0
    for seed in range(seeds):
        problem = several(classes, resources, seed).with_table()
        began = time.thread_time()
        selection = solve(problem, time_limit_s=20)
        took.append((time.thread_time() - began) * 1e3)
        unproven += not selection.proven
        if seed < peer_seeds:
            instance = build_integer_program(problem)
            began = time.thread_time()
            other = solve_cpsat(instance, time.perf_counter() + 20)
            peer.append((time.thread_time() - began) * 1e3)
            if selection.proven and other is not None and other.proven:
                theirs = {problem.strategies[instance.table[s]].name for s in other.chosen}
                if theirs != set(selection.strategies):
                    raise AssertionError(f"{case}, seed {seed}: another selection than CP-SAT's")
    proven = f"proven {seeds - unproven} of {seeds}"
    return [
        row(BENCHMARK, case, f"CPU, {proven}", "ms", took),
        row(BENCHMARK, case, "CPU, slowest", "ms", [max(took)]),
        row(BENCHMARK, case, "CPU, beside a peer", "ms", took[:peer_seeds], peer, TUNED),
    ]


def explained(case: str, problems: Sequence[SelectionProblem], peers: int) -> list[Row]:
    """What reasons take to the end (unless there are over 400 strategies) and within the limit that a program gives
    them, and the share of desires for which that was enough; beside the search of each variant for itself on the first
    ``peers`` of the same problems, which must offer the same desires to do without."""
    whole, peer, limited_s, share = [], [], [], []
    for number, stated in enumerate(problems):
        problem = stated.with_table()
        selection = solve(problem, time_limit_s=20)
        if len(problem.strategies) <= 400:
            began = time.thread_time()
            reasons = explain(problem, selection, time_limit_s=60)
            whole.append((time.thread_time() - began) * 1e3)
            if number < peers:
                with patch("app.attention.variants.Variants._compile", return_value=None):
                    began = time.thread_time()
                    theirs = explain(problem, selection, time_limit_s=60)
                    peer.append((time.thread_time() - began) * 1e3)
                if _absences(theirs) != _absences(reasons):
                    raise AssertionError(f"{case}, problem {number}: other reasons than without the compiled search")
        began = time.perf_counter()
        reasons = explain(problem, selection, time_limit_s=EXPLAIN_S)
        limited_s.append((time.perf_counter() - began) * 1e3)
        share.append(100 * statistics.mean(reason.searched for reason in reasons.values()))
    limit = f"reasons, limit {EXPLAIN_S * 1e3:g} ms"
    rows = [
        row(BENCHMARK, case, f"{limit}: time taken", "ms", limited_s),
        row(BENCHMARK, case, f"{limit}: desires with all that would help", "%", share),
    ]
    if whole:
        rows.append(row(BENCHMARK, case, "reasons to the end, CPU", "ms", whole))
        rows.append(row(BENCHMARK, case, "reasons to the end, CPU, slowest", "ms", [max(whole)]))
    if peer:
        rows.append(row(BENCHMARK, case, "reasons to the end, beside a peer", "ms", whole[: len(peer)], peer, EACH))
    return rows


def _absences(reasons: Mapping[str, Reason]) -> dict[str, set[str]]:
    return {cls: {a.without for a in reason.alternatives} for cls, reason in reasons.items()}


def tableau_4_4() -> SelectionProblem:
    """The thesis's strategies, all seven classes desired (i 8, u 1)."""
    rows: list[tuple[str, int, float, float]] = [
        *(("FindQRCodes", phi, v, cpu) for phi, v, cpu in ((1, 8, 80), (2, 4, 40), (4, 2, 20), (8, 1, 10))),
        *(("LocateFaces", phi, v, cpu) for phi, v, cpu in ((1, 8, 60), (2, 4, 30), (4, 2, 15), (8, 1, 8))),
        ("DetectNoises", 1, 8, 0),
        ("LocateVoices", 1, 8, 60),
        ("SLAM", 40, 8, 20),
        ("Teleoperation", 1, 8, 0),
        ("GoTo", 1, 8, 30),
    ]
    table = tuple(
        Strategy(
            f"{cls}-{phi}",
            cls,
            v,
            requires={"SLAM": 1} if cls == "GoTo" else {},
            filters={f"{cls}.input": phi},
            costs={"cpu": cpu} if cpu else {},
        )
        for cls, phi, v, cpu in rows
    )
    desires = {s.cls: _desire(s.cls, 8, security=s.cls == "Teleoperation") for s in table}
    return SelectionProblem(desires, table, {"cpu": 100.0})


def contention(classes: int, seed: int) -> SelectionProblem:
    """``classes`` classes of four strategies contending for half the CPU they want, and for actuators."""
    chance = random.Random(seed)
    slots = max(1, classes // 12)
    table: list[Strategy] = []
    full = 0
    for number in range(classes):
        cpu = chance.randint(5, 40)
        full += cpu
        actuator = {f"actuator{chance.randrange(slots)}": 1.0} if chance.random() < 0.3 else {}
        for phi in (1, 2, 4, 8):
            costs = {"cpu": float(max(1, cpu // phi)), **actuator}
            cls = f"K{number}"
            table.append(Strategy(f"{cls}-{phi}", cls, 8 / phi, filters={f"{cls}.input": phi}, costs=costs))
    capacities = {"cpu": full / 2, **{f"actuator{slot}": 1.0 for slot in range(slots)}}
    desires = {f"K{number}": _desire(f"K{number}", chance.randint(1, 8)) for number in range(classes)}
    return SelectionProblem(desires, tuple(table), capacities)


def several(classes: int, resources: int, seed: int) -> SelectionProblem:
    """``classes`` classes of four strategies contending for half of what they want of each of ``resources``."""
    chance = random.Random(seed)
    full = dict.fromkeys((f"r{number}" for number in range(resources)), 0.0)
    table: list[Strategy] = []
    for number in range(classes):
        wanted = {name: chance.uniform(5, 40) for name in full}
        for name, amount in wanted.items():
            full[name] += amount
        for phi in (1, 2, 4, 8):
            costs = {name: round(amount / phi, 3) for name, amount in wanted.items()}
            cls = f"K{number}"
            table.append(Strategy(f"{cls}-{phi}", cls, 8 / phi, filters={f"{cls}.input": phi}, costs=costs))
    desires = {f"K{number}": _desire(f"K{number}", chance.randint(1, 8)) for number in range(classes)}
    return SelectionProblem(desires, tuple(table), {name: round(amount / 2, 3) for name, amount in full.items()})


def direct(problem: SelectionProblem) -> float | None:
    """Ω by CP-SAT with its defaults on the equations as printed; None if it has no proof in the limit."""
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    a = {s.name: model.new_bool_var("") for s in problem.strategies}
    f = {cls: model.new_bool_var("") for cls in problem.desires}
    classes = {s.cls for s in problem.strategies} | set(problem.desires)
    products = []
    for cls in classes:
        cover = sum(
            (round(1000 * s.utility) if s.cls == cls else 0) * a[s.name]
            - round(1000 * s.requires.get(cls, 0)) * a[s.name]
            for s in problem.strategies
        )
        desire = problem.desires.get(cls)
        model.add(cover >= (round(1000 * desire.utility) * f[cls] if desire else 0))
        if desire is not None and desire.security:
            model.add(f[cls] == 1)
        mine = [s for s in problem.strategies if s.cls == cls]
        model.add_at_most_one(a[s.name] for s in mine)
        for s in mine if desire is not None else ():
            both = model.new_bool_var("")
            model.add_multiplication_equality(both, [f[cls], a[s.name]])
            products.append(round(1000 * s.utility) * both)
    for resource, capacity in problem.capacities.items():
        use = sum(round(1000 * s.costs.get(resource, 0)) * a[s.name] for s in problem.strategies)
        model.add(use <= round(1000 * capacity))
    model.maximize(sum(round(1000 * d.intensity) * f[cls] for cls, d in problem.desires.items()) + sum(products))
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = PEER_LIMIT_S
    status = solver.solve(model)
    return solver.objective_value / 1000 if status == cp_model.OPTIMAL else None


def beside_hbba_lite(path: Path) -> None:
    """Print our CPU times on the instances that hbba_lite was measured on, by family."""
    families: dict[str, list[float]] = {}
    unproven: dict[str, int] = {}
    for instance in json.loads(path.read_text())["instances"]:
        family = instance["name"].split("_seed")[0]
        if family not in HBBA_LITE_MS:
            continue
        problem = _published(instance)
        solve(problem, time_limit_s=5)
        began = time.thread_time()
        selection = solve(problem, time_limit_s=5)
        families.setdefault(family, []).append((time.thread_time() - began) * 1e3)
        unproven[family] = unproven.get(family, 0) + (not selection.proven)
    print("\nOn hbba_lite's instances, ms of CPU a solve (ours: median [least – most])")
    print(f"{'family':20s}  {'ours':>24s}  hbba_lite")
    for family, quoted in HBBA_LITE_MS.items():
        times = families.get(family)
        if times:
            ours = f"{statistics.median(times):.2f} [{min(times):.2f} – {max(times):.2f}]"
            note = f"  ({unproven[family]} not proven in 5 s)" if unproven[family] else ""
            print(f"{family:20s}  {ours:>24s}  {quoted}{note}")


def percentile(samples: Sequence[float], share: float) -> float:
    """The smallest sample that ``share`` of them do not exceed."""
    return sorted(samples)[min(len(samples) - 1, int(share * len(samples)))]


def _desire(cls: str, intensity: float, *, utility: float = 1.0, security: bool = False) -> Desire:
    return Desire(f"d-{cls}", cls, intensity, utility, security, {}, Source("operator", "benchmark"), 0.0)


def _published(instance: Mapping[str, Any]) -> SelectionProblem:
    table = tuple(
        Strategy(
            f"{entry['cls']}-{number}",
            entry["cls"],
            entry["utility"],
            filters={f"{name}.input": phi for name, phi in entry["filters"].items()},
            costs={name: cost for name, cost in entry["resources"].items() if cost},
        )
        for number, entry in enumerate(instance["strategies"])
    )
    active = instance["desires"][: instance.get("active", len(instance["desires"]))]
    desires = {
        d["cls"]: _desire(d["cls"], d["intensity"], utility=d["utility"], security=d["security"]) for d in active
    }
    return SelectionProblem(desires, table, instance["capacity"])


def measure(quick: bool) -> list[Row]:
    """All rows, and the published instances beside hbba_lite's quoted times where they are at hand."""
    rows = run(rounds_share=0.2 if quick else 1.0)
    folder = os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data"
    reference = Path(folder) / "solver_instances.json"
    if not reference.is_file():
        print(f"hbba_lite's instances are not compared: there is no {reference.name} in HBBA_REFERENCE_DATA.\n")
    elif not quick:
        beside_hbba_lite(reference)
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
