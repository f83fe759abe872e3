"""The commit-msg hook: a subject of at most 72 characters, an empty line, and a body. Standard library only."""

from __future__ import annotations

import sys
from pathlib import Path

SUBJECT_AT_MOST = 72
#: Below it git shows what `git commit --verbose` adds.
_SCISSORS = "# ------------------------ >8 ------------------------"
#: What git writes itself, to be merged into another commit or as the record of a merge.
_OF_GIT = ("Merge ", "fixup! ", "squash! ", "amend! ")


def fault(message: str) -> str | None:
    """What is wrong with a commit's ``message``, in one sentence; None where nothing is."""
    message = message.partition(_SCISSORS)[0]
    lines = [line.rstrip() for line in message.splitlines() if not line.startswith("#")]
    while lines and not lines[0]:
        del lines[0]
    if not lines:
        return None  # git refuses an empty message itself
    subject, *rest = lines
    if subject.startswith(_OF_GIT):
        return None
    if len(subject) > SUBJECT_AT_MOST:
        return f"the subject has {len(subject)} characters; {SUBJECT_AT_MOST} are allowed, the rest belongs in the body"
    if rest and rest[0]:
        return "the line after the subject must be empty"
    if not any(rest):
        return "the body is missing: after an empty line, say why the change is made"
    return None


def main(file: str) -> int:
    """Check the commit message in ``file``: 0 where it is good, 1 after a sentence on standard error."""
    wrong = fault(Path(file).read_text(encoding="utf-8"))
    if wrong is not None:
        sys.stderr.write(f"Commit message: {wrong}.\n")
    return wrong is not None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
