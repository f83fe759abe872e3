"""``hbba check`` of what attention proved: certificates, and recordings with the selections in them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from app.base.errors import ConfigError
from app.base.plain_file import open_plain

PROOF_S: Final = 10.0
"""Seconds that the proof of one selection in a recording may take."""
MOST_BYTES: Final = 64_000_000
"""Of a certificate."""
_LOGS: Final = (".mcap", ".bag", ".db3")
_NAMED: Final = 5


@dataclass(frozen=True, slots=True)
class Findings:
    """What was found in a file: its ``kind``, ``result`` in words, ``cautions`` in sentences."""

    kind: str
    result: str
    cautions: tuple[str, ...] = ()


def check_proofs(path: Path) -> Findings | None:
    """Check ``path`` if it is a certificate or a recording; None if it is neither. Raises ConfigError."""
    if path.suffix in _LOGS:
        return _recording(path)
    from app.attention.proof.certificate import HEAD

    try:
        with open_plain(path) as file:
            if file.read(len(HEAD)) != HEAD.encode():
                return None
            text = HEAD + file.read(MOST_BYTES).decode()
    except (OSError, UnicodeDecodeError):
        return None  # what reads it as configuration says why
    return _certificate(path, text)


def _certificate(path: Path, text: str) -> Findings:
    from app.attention.proof.checker import check
    from app.attention.proof.equations import Refused

    if len(text) > MOST_BYTES:
        raise ConfigError(f"{path}: is longer than {MOST_BYTES // 1_000_000} MB, the most of a certificate")
    try:
        omega = check(text)
    except Refused as failure:
        raise ConfigError(f"{path}: this certificate proves nothing: {failure}") from None
    return Findings("certificate", f"its selection is the best there is, Ω = {omega / 1e6:g}")


def _recording(path: Path) -> Findings:
    """Check every proven selection of a recording. Raises ConfigError if one of them is not the best."""
    from app.attention.proof.recorded import verdicts
    from app.attention.proof.statement import TABLE_FILE
    from app.logs.log import LogError
    from app.logs.open import open_log

    try:
        log = open_log(path)
        try:
            table = next((file.data for file in log.manifest.files if file.name == TABLE_FILE), None)
            if table is None:
                missing = f"{path}: selections are not checked: it carries no table of strategies ({TABLE_FILE})"
                return Findings("recording", "readable", (missing,))
            reports = (logged.message for logged in log.messages(channels={"intention"}))
            found = list(verdicts(table, reports, PROOF_S))
        finally:
            log.close()
    except LogError as failure:
        raise ConfigError(str(failure)) from None
    wrong = [verdict for verdict in found if verdict.state == "wrong"]
    if wrong:
        named = "; ".join(f"that of {verdict.stamp:.3f} s: {verdict.why}" for verdict in wrong[:_NAMED])
        raise ConfigError(f"{path}: {len(wrong)} of {len(found)} proven selections are not the best: {named}")
    counts = Counter(verdict.why for verdict in found if verdict.state == "open")
    cautions = tuple(f"{path}: {count} proven selections are not checked: {why}" for why, count in counts.items())
    checked = sum(verdict.state == "checked" for verdict in found)
    return Findings("recording", f"{checked} of {len(found)} proven selections are certified and checked", cautions)
