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
    """What names stand for: definitions and imports by ``module.name``, methods by their name alone."""

    definitions: dict[str, Definition] = field(default_factory=dict)
    imports: dict[str, str] = field(default_factory=dict)
    methods: dict[str, list[Definition]] = field(default_factory=lambda: defaultdict(list))

    def add(self, module: str, tree: ast.Module) -> None:
        of_classes: set[ast.AST] = set()
        for node in ast.walk(tree):  # a class before its methods
            if isinstance(node, ast.ClassDef):
                methods = [each for each in node.body if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)]
                of_classes.update(methods)
                for method in methods:
                    self.methods[method.name].append(method)
            if isinstance(node, Definition) and node not in of_classes:
                self.definitions.setdefault(f"{module}.{node.name}", node)
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                for alias in node.names:
                    self.imports[f"{module}.{alias.asname or alias.name}"] = f"{node.module}.{alias.name}"
            elif isinstance(node, ast.Import):
                for alias in node.names:
                    self.imports[f"{module}.{alias.asname or alias.name}"] = alias.name

    def resolved(self, name: str) -> Definition | None:
        """What ``module.name`` is in the end, where it is ours."""
        seen: set[str] = set()
        while name not in self.definitions and name in self.imports and name not in seen:
            seen.add(name)
            name = self.imports[name]
        return self.definitions.get(name)

    def called(self, module: str, call: ast.Call) -> list[Definition]:
        """What ``call`` in ``module`` may be of ours; nothing where it is a library's."""
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


def takes_positions(definition: Definition) -> bool:
    """Whether it is a compiled kernel, or takes any number of arguments."""
    if isinstance(definition, ast.ClassDef):
        return False
    compiled = any(ast.unparse(decorator).startswith("kernel(") for decorator in definition.decorator_list)
    return compiled or definition.args.vararg is not None


def names_of(package: Path) -> Names:
    names = Names()
    for path in sorted(package.rglob("*.py")):
        names.add(module_of(path), ast.parse(path.read_text(encoding="utf-8")))
    return names


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def long_calls(source: str, module: str, names: Names) -> Iterator[ast.Call]:
    """Calls of ours in ``source`` with more than five arguments by position."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and sum(not isinstance(each, ast.Starred) for each in node.args) > MOST:
            called = names.called(module, node)
            if called and not any(takes_positions(definition) for definition in called):
                yield node


def test_many_arguments_are_named() -> None:
    names = names_of(ROOT / "app")
    found = [
        f"{path.relative_to(ROOT)}:{call.lineno}: {ast.unparse(call.func)} with {len(call.args)} arguments by position"
        for path in sorted((ROOT / "app").rglob("*.py"))
        for call in long_calls(path.read_text(encoding="utf-8"), module_of(path), names)
    ]
    assert not found, "\n".join(found)


def test_a_long_call_is_found_wherever_its_name_comes_from() -> None:
    names = Names()
    names.add("app.a", ast.parse("class Six:\n    def six(self, a, b, c, d, e, f): ...\n    def any(self, *all): ..."))
    names.add("app.b", ast.parse("from app.a import Six\n@kernel('void()')\ndef sum6(a, b, c, d, e, f): ...\n"))
    source = (
        "import cv2\nfrom app.b import Six, sum6\n"
        "Six(1, 2, 3, 4, 5, 6)\nsix.six(1, 2, 3, 4, 5, 6)\n"
        "six.any(1, 2, 3, 4, 5, 6)\nsum6(1, 2, 3, 4, 5, 6)\ncv2.six(1, 2, 3, 4, 5, 6)\nSix(1, 2, 3, 4, 5, f=6)\n"
    )
    names.add("app.c", ast.parse(source))
    assert [call.lineno for call in long_calls(source, "app.c", names)] == [3, 4]
