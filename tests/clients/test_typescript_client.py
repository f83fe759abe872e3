"""The TypeScript client, compiled, against the real console."""

from __future__ import annotations

import asyncio
import os
import re
import shutil
from pathlib import Path

import pytest

from app.program.system import System
from tests.clients.test_python_client import console

ROOT = Path(__file__).parents[2]
COMPILER = ROOT / "web" / "node_modules" / ".bin" / "tsc"
EXAMPLES = re.findall(r"```typescript\n(.*?)```", (ROOT / "docs" / "clients.md").read_text("utf-8"), re.S)
NODE = shutil.which("node")

pytestmark = pytest.mark.skipif(NODE is None or not COMPILER.exists(), reason="Node or the page's packages are missing")

#: What the types of Node say of it, in so far as it is used.
NODES = "declare const process: { env: Record<string, string | undefined>; exit(code: number): never };\n"
HELD = """
import { Robot, Problem, Unreachable } from "hbba-client";
const robot = new Robot(process.env.HBBA_ADDRESS);
const held = await robot.desire("Listen", { ttl: 0.3, intensity: 6 });
let renewed = false;
for await (const message of robot.live()) {
  if (message.type !== "desires") continue;
  const now = message.desires.find((each) => each.id === held.desire.id);
  renewed = (now?.expires ?? 0) > (held.desire.expires ?? 0);
  if (renewed || !now) break;
}
await held.close();
await held.close();
const gone = await robot.getDesire(held.desire.id);
const tour = (await robot.listTours()).tours[0]!;
await robot.getTour(tour.id);
const conflict = await robot.changeTour(tour.id, {}, { ifMatch: '"another"' }).catch((error) => error);
const nobody = await new Robot("http://127.0.0.1:9").getHealth().catch((error) => error);
console.log(JSON.stringify({
  outcome: gone.outcome, etag: robot.etags.has(`/tours/${tour.id}`), conflict: conflict.status,
  problem: conflict instanceof Problem, unreachable: nobody instanceof Unreachable,
  posters: (await robot.getTourPosters(tour.id, { paper: "letter" })).byteLength > 1000,
}));
process.exit(0);
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the client, built, among its packages."""
    folder = tmp_path_factory.mktemp("typescript")
    made = folder / "node_modules" / "hbba-client"
    shutil.copytree(ROOT / "clients" / "typescript", made, ignore=shutil.ignore_patterns("node_modules", "dist"))
    return folder


async def run(package: Path, url: str, source: str) -> str:
    """What the TypeScript program ``source`` prints, checked and compiled as its users do."""
    (package / "package.json").write_text('{"type": "module"}')
    (package / "program.ts").write_text(NODES + source)
    client = package / "node_modules" / "hbba-client"
    options = ["--target", "es2022", "--module", "nodenext", "--strict", "--types", "", "--noUncheckedIndexedAccess"]
    library = ["--lib", "es2022,esnext.disposable,dom"]
    commands = [
        [str(COMPILER), *options, *library, "program.ts"],
        [str(NODE), "--experimental-websocket", "program.js"],
    ]
    if not (client / "dist").exists():
        commands.insert(0, [str(COMPILER), "-p", str(client)])
    output = b""
    for command in commands:
        process = await asyncio.create_subprocess_exec(
            *command,
            cwd=package,
            env={**os.environ, "HBBA_ADDRESS": console(url).rstrip("/"), "NODE_NO_WARNINGS": "1"},
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
        )
        output, _ = await process.communicate()
        assert process.returncode == 0, output.decode()
    return output.decode()


async def test_a_held_desire_is_renewed_and_removed(url: str, system: System, package: Path) -> None:
    said = await run(package, url, HELD)
    assert '"outcome":"withdrawn"' in said or '"outcome":"expired"' in said
    for member in ("etag", "problem", "unreachable", "posters"):
        assert f'"{member}":true' in said
    assert '"conflict":412' in said


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
async def test_the_examples_of_the_documentation_run(url: str, system: System, package: Path, number: int) -> None:
    assert len(EXAMPLES[number].splitlines()) <= 20
    said = await run(package, url, EXAMPLES[number] + "\nprocess.exit(0);\n")
    assert "Ω" in said
    assert "422" in said
