"""The answer of ``hbba solve`` for people: aligned tables and bars."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from app.attention.problem import Selection
from app.attention.problem_file import StatedProblem
from app.attention.strategies import CLOSED
from app.base.yaml_source import likeliest
from app.commands.output import aligned
from app.commands.printable import one_line

_BAR = 24
_MOST_NAMED = 8
_PLAIN = str.maketrans({"Ω": "O", "φ": "f", "∞": "-", "█": "#", "░": ".", "≤": "<"})


def report_selection(stated: StatedProblem, selection: Selection, *, plain: bool = False) -> str:
    """The answer's first part: the selection, before its reasons are known; ``plain`` uses ASCII only."""
    problem = stated.problem
    served = {s.cls for s in problem.strategies}
    lines = [_headline(selection)]
    if not problem.desires:
        lines.append("Nothing is desired: a problem says under `desires` what its robot shall do (docs/solve.md).")
    unserved = [cls for cls in problem.desires if cls not in served]
    lines += [
        one_line(f"No strategy serves {cls}{f' ({hint.strip()})' if (hint := likeliest(cls, served)) else ''}.")
        for cls in unserved[:_MOST_NAMED]
    ]
    if contending := [cls for cls in selection.relaxed if cls in served]:
        lines.append(
            f"Security CANNOT be kept for {_names(contending)}: what these need cannot be had, or not beside what "
            "is more intense; they are treated as ordinary desires."
        )
    if lost := [cls for cls in selection.relaxed if cls not in served]:
        lines.append(f"Security CANNOT be kept for {_names(lost)}: no strategy serves them.")
    names = frozenset(selection.strategies)
    chosen = [s for s in problem.strategies if s.name in names]
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
    return _text(lines, plain)


def report_consequences(
    stated: StatedProblem,
    selection: Selection,
    divisors: Mapping[str, float],
    parameters: Mapping[str, Mapping[str, Any]],
    *,
    plain: bool = False,
) -> str:
    """The answer's second part: the reasons, and what follows from the selection; ``plain`` uses ASCII only."""
    problem = stated.problem
    lines: list[str] = []
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
        if late := unexplained(selection):
            more = f" and {len(late) - _MOST_NAMED} more" if len(late) > _MOST_NAMED else ""
            lines.append(
                f"  There was no time to find all that would help {_names(late[:_MOST_NAMED])}{more}; "
                "a greater --time-limit gives more."
            )
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
    return _text(lines, plain)


def unexplained(selection: Selection) -> list[str]:
    """The desired classes for which there was no time to look for all that would help."""
    return [cls for cls, reason in selection.reasons.items() if not reason.searched]


def _text(lines: Sequence[str], plain: bool) -> str:
    text = "\n".join(line.rstrip() for line in lines)
    return text.translate(_PLAIN).encode("ascii", "replace").decode() if plain else text


def _names(classes: Sequence[str]) -> str:
    return ", ".join(map(one_line, classes))


def _headline(selection: Selection) -> str:
    how = "proven optimal" if selection.proven else f"best found in time, Ω of no selection exceeds {selection.bound:g}"
    fulfilled = _names(selection.fulfilled) or "nothing"
    return f"Ω = {selection.omega:g} ({how}, {selection.solve_time_s * 1000:.2f} ms); fulfilled: {fulfilled}"


def _phi(divisor: float) -> str:
    return "∞" if divisor == CLOSED else f"{divisor:g}"


def _table(
    header: Sequence[str] | None, rows: Sequence[Sequence[str]], right: frozenset[int] | set[int] = frozenset()
) -> list[str]:
    """Rows in aligned columns, without what steers a terminal; ``right`` columns are aligned to the right."""
    every = [[one_line(cell) for cell in row] for row in ([header, *rows] if header is not None else rows)]
    return [f"  {line}" for line in aligned(every, right)]
