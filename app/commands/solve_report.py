"""The answer of ``hbba solve`` for people: aligned tables and bars."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from app.attention.problem import Selection
from app.attention.problem_file import StatedProblem
from app.attention.strategies import CLOSED

_BAR = 24
_PLAIN = str.maketrans({"Ω": "O", "φ": "f", "∞": "-", "█": "#", "░": ".", "≤": "<"})


def report(
    stated: StatedProblem,
    selection: Selection,
    divisors: Mapping[str, float],
    parameters: Mapping[str, Mapping[str, Any]],
    *,
    plain: bool = False,
) -> str:
    """The whole answer as text of several lines; ``plain`` uses ASCII only."""
    problem = stated.problem
    lines = [_headline(selection)]
    if selection.relaxed:
        lines.append(
            f"Security CANNOT be kept for {', '.join(selection.relaxed)}: what these need does not fit together; "
            "they are treated as ordinary desires."
        )
    chosen = [s for s in problem.strategies if s.name in selection.strategies]
    lines += ["", "Selected strategies"]
    if chosen:
        rows = [
            [
                s.name,
                s.cls,
                f"{s.utility:g}",
                ", ".join(f"{name} φ{_phi(phi)}" for name, phi in s.filters.items()) or "-",
                ", ".join(f"{name} {cost:g}" for name, cost in s.costs.items()) or "-",
                ", ".join(f"{name} {need:g}" for name, need in s.requires.items()) or "-",
            ]
            for s in chosen
        ]
        lines += _table(["strategy", "class", "v", "filters", "costs", "requires"], rows, right={2})
    else:
        lines.append("  none")
    if problem.desires:
        lines += ["", "Desires"]
        rows = [
            [
                d.cls + (" !" if d.security else ""),
                f"{d.intensity:g}",
                f"{d.utility:g}",
                f"{selection.reasons[d.cls].utility:g}",
                selection.reasons[d.cls].state,
                selection.reasons[d.cls].text,
            ]
            for d in problem.desires.values()
        ]
        lines += _table(["class", "i", "u", "gets", "state", "why"], rows, right={1, 2, 3})
        if any(d.security for d in problem.desires.values()):
            lines.append("  ! security: must be fulfilled")
    if problem.capacities:
        lines += ["", "Resources"]
        rows = []
        for name, capacity in problem.capacities.items():
            used = selection.use.get(name, 0.0)
            full = round(_BAR * used / capacity) if capacity else 0
            unit = stated.table.resources[name].unit
            rows.append([name, "█" * full + "░" * (_BAR - full), f"{used:g}", f"of {capacity:g} {unit}".rstrip()])
        lines += _table(None, rows, right={2})
    if divisors:
        lines += ["", "Filters (of φ messages one passes; ∞ is closed)"]
        lines += _table(None, [[name, f"φ {_phi(phi)}"] for name, phi in divisors.items()])
    if parameters:
        lines += ["", "Parameters"]
        lines += _table(
            None, [[module, json.dumps(values, ensure_ascii=False)] for module, values in parameters.items()]
        )
    text = "\n".join(line.rstrip() for line in lines)
    return text.translate(_PLAIN).encode("ascii", "replace").decode() if plain else text


def _headline(selection: Selection) -> str:
    how = "proven optimal" if selection.proven else f"best found in time, Ω of no selection exceeds {selection.bound:g}"
    fulfilled = ", ".join(selection.fulfilled) or "nothing"
    return f"Ω = {selection.omega:g} ({how}, {selection.solve_time_s * 1000:.2f} ms); fulfilled: {fulfilled}"


def _phi(divisor: float) -> str:
    return "∞" if divisor == CLOSED else f"{divisor:g}"


def _table(
    header: Sequence[str] | None, rows: Sequence[Sequence[str]], right: frozenset[int] | set[int] = frozenset()
) -> list[str]:
    """Rows in aligned columns, two spaces between; ``right`` columns are aligned to the right."""
    every = [header, *rows] if header is not None else list(rows)
    widths = [max(len(row[column]) for row in every) for column in range(len(every[0]))]
    return [
        "  "
        + "  ".join(
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in every
    ]
