"""No call of our own functions and classes has more than five positional arguments: two swapped floats pass mypy.

Libraries' functions are called as they ask for, and so are compiled kernels, whose arguments numba takes by position,
and functions that take any number of arguments (``Module.compute``).
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST = 5
Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


@dataclass
class Names:
    """What names stand for, and calls with many arguments by position. Of a definition it keeps whether it takes
    positions: whole trees of all files would be slow to keep.
    """

    definitions: dict[str, bool] = field(default_factory=dict)
    imports: dict[str, str] = field(default_factory=dict)
    methods: dict[str, list[bool]] = field(default_factory=lambda: defaultdict(list))
    #: By module.
    long_calls: dict[str, list[ast.Call]] = field(default_factory=lambda: defaultdict(list))

    def add(self, module: str, source: str) -> None:
        of_classes: set[ast.AST] = set()
        for node in ast.walk(ast.parse(source)):  # a class before its methods
            if isinstance(node, ast.ClassDef):
                methods = [each for each in node.body if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)]
                of_classes.update(methods)
                for method in methods:
                    self.methods[method.name].append(takes_positions(method))
            if isinstance(node, Definition) and node not in of_classes:
                self.definitions.setdefault(f"{module}.{node.name}", takes_positions(node))
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                for alias in node.names:
                    self.imports[f"{module}.{alias.asname or alias.name}"] = f"{node.module}.{alias.name}"
            elif isinstance(node, ast.Import):
                for alias in node.names:
                    self.imports[f"{module}.{alias.asname or alias.name}"] = alias.name
            elif isinstance(node, ast.Call) and sum(not isinstance(each, ast.Starred) for each in node.args) > MOST:
                self.long_calls[module].append(node)

    def resolved(self, name: str) -> bool | None:
        """Whether what ``module.name`` is in the end takes positions; None where it is not ours."""
        seen: set[str] = set()
        while name not in self.definitions and name in self.imports and name not in seen:
            seen.add(name)
            name = self.imports[name]
        return self.definitions.get(name)

    def called(self, module: str, call: ast.Call) -> list[bool]:
        """Whether what ``call`` in ``module`` may be of ours takes positions; nothing where it is a library's."""
        match call.func:
            case ast.Name(id=name):
                found = self.resolved(f"{module}.{name}")
                return [] if found is None else [found]
            case ast.Attribute(value=ast.Name(id=owner), attr=name) if f"{module}.{owner}" in self.imports:
                target = self.imports[f"{module}.{owner}"]
                found = self.resolved(f"{target}.{name}")
                if found is not None:
                    return [found]
                return self.methods.get(name, []) if target.startswith("app.") else []
            case ast.Attribute(attr=name):
                return self.methods.get(name, [])
        return []

    def refused(self) -> Iterator[tuple[str, ast.Call]]:
        """Calls of ours with more than five arguments by position, each with its module."""
        for module, calls in self.long_calls.items():
            for call in calls:
                called = self.called(module, call)
                if called and not any(called):
                    yield module, call


def takes_positions(definition: Definition) -> bool:
    """Whether it is a compiled kernel, or takes any number of arguments."""
    if isinstance(definition, ast.ClassDef):
        return False
    compiled = any(ast.unparse(decorator).startswith("kernel(") for decorator in definition.decorator_list)
    return compiled or definition.args.vararg is not None


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_many_arguments_are_named() -> None:
    names = Names()
    for path in sorted((ROOT / "app").rglob("*.py")):
        names.add(module_of(path), path.read_text(encoding="utf-8"))
    found = [
        f"{module}:{call.lineno}: {ast.unparse(call.func)} with {len(call.args)} arguments by position"
        for module, call in names.refused()
    ]
    assert not found, "\n".join(found)


def test_a_long_call_is_found_wherever_its_name_comes_from() -> None:
    names = Names()
    names.add("app.a", "class Six:\n    def six(self, a, b, c, d, e, f): ...\n    def any(self, *all): ...")
    names.add("app.b", "from app.a import Six\n@kernel('void()')\ndef sum6(a, b, c, d, e, f): ...\n")
    source = (
        "import cv2\nfrom app.b import Six, sum6\n"
        "Six(1, 2, 3, 4, 5, 6)\nsix.six(1, 2, 3, 4, 5, 6)\n"
        "six.any(1, 2, 3, 4, 5, 6)\nsum6(1, 2, 3, 4, 5, 6)\ncv2.six(1, 2, 3, 4, 5, 6)\nSix(1, 2, 3, 4, 5, f=6)\n"
    )
    names.add("app.c", source)
    assert [(module, call.lineno) for module, call in names.refused()] == [("app.c", 3), ("app.c", 4)]
