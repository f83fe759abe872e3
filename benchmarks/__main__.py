"""Every benchmark, one after the other, each in a process of its own: ``hbba bench [NAME ...]``, ``make bench``."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.document import document
from benchmarks.report import json_text, read_rows, write_json

FOLDER = Path(__file__).resolve().parent


def names() -> list[str]:
    """The benchmarks there are: the files here that can be run."""
    return sorted(
        path.stem
        for path in FOLDER.glob("*.py")
        if path != Path(__file__).resolve() and '__name__ == "__main__"' in path.read_text(encoding="utf-8")
    )


def main() -> int:
    """Run the benchmarks asked for, by default all; the exit code counts those that failed."""
    known = names()
    parser = argparse.ArgumentParser(prog="hbba bench", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"which: {', '.join(known)} (default: all)")
    parser.add_argument("--quick", action="store_true", help="rough figures, in seconds instead of minutes")
    parser.add_argument("--json", action="store_true", help="print all rows as one JSON document instead")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write that JSON document here")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="also write them as a page (docs/benchmarks.md)")
    args = parser.parse_args()
    if unknown := sorted(set(args.names) - set(known)):
        parser.error(f"there is no benchmark {', '.join(unknown)}; there are {', '.join(known)}")
    chosen = args.names or known
    failed, rows = [], []
    progress = sys.stderr if args.json else sys.stdout
    with tempfile.TemporaryDirectory() as folder:
        for number, name in enumerate(chosen, 1):
            print(f"== {name} ({number} of {len(chosen)})", file=progress, flush=True)
            began = time.perf_counter()
            result = Path(folder) / f"{name}.json"
            command = [sys.executable, "-m", f"benchmarks.{name}", "--out", str(result)]
            done = subprocess.run([*command, *(["--quick"] if args.quick else [])], stdout=progress, check=False)
            if done.returncode or not result.is_file():
                failed.append(name)
            else:
                rows += read_rows(json.loads(result.read_text(encoding="utf-8")))
            print(f"   {time.perf_counter() - began:.0f} s\n", file=progress, flush=True)
    if args.json:
        print(json_text(rows))
    if args.out:
        write_json(rows, args.out)
    if args.markdown:
        args.markdown.write_text(document(rows), encoding="utf-8")
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return len(failed)


if __name__ == "__main__":
    sys.exit(main())
