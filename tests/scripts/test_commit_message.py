"""The commit-msg hook: which messages it lets through, and that git asks it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]

GOOD = [
    "Add a thing\n\nIt was missing.\n",
    "\n# a comment\nAdd a thing\n\nIt was missing.\n",
    "x" * 72 + "\n\nBody.\n",
    "Merge branch 'words'\n",
    "fixup! Add a thing\n",
]
BAD = {
    "x" * 73 + "\n\nBody.\n": "73 characters",
    "Add a thing\n": "body is missing",
    "Add a thing\n\n# only a comment\n": "body is missing",
    "Add a thing\nand more\n\nBody.\n": "must be empty",
    "Add\n\n# ------------------------ >8 ------------------------\n+ a line of the difference\n": "body is missing",
}


@pytest.mark.parametrize("message", GOOD)
def test_a_subject_and_a_body_pass(commit_message: ModuleType, message: str) -> None:
    assert commit_message.fault(message) is None


@pytest.mark.parametrize("message", BAD)
def test_a_fault_is_named(commit_message: ModuleType, message: str) -> None:
    assert BAD[message] in commit_message.fault(message)


def test_pre_commit_runs_the_script_on_the_message() -> None:
    [repository] = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    [hook] = [hook for hook in repository["hooks"] if hook.get("stages") == ["commit-msg"]]
    assert hook["entry"].split()[-1] == "scripts/commit_message.py"
    assert (ROOT / "scripts" / "commit_message.py").is_file()


@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
def test_git_refuses_a_commit_without_a_body(tmp_path: Path) -> None:
    environment = {**os.environ, "GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull}
    environment |= {f"GIT_{who}_{what}": "hbba" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}

    def git(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = ["git", *arguments]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)

    assert git("init", "--quiet").returncode == 0
    hook = tmp_path / ".git" / "hooks" / "commit-msg"
    hook.parent.mkdir(exist_ok=True)
    hook.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{ROOT / "scripts" / "commit_message.py"}" "$1"\n')
    hook.chmod(0o755)
    refused = git("commit", "--allow-empty", "-m", "Add a thing")
    assert refused.returncode == 1
    assert "Commit message: the body is missing" in refused.stderr
    assert git("commit", "--allow-empty", "-m", "Add a thing", "-m", "It was missing.").returncode == 0
