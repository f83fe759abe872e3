"""The command ``hbba``. Every command is a file of ``app/commands``; what is heavy is imported only when it runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from app.base.errors import ConfigError
from app.commands import COMMANDS
from app.commands.parser import build_parser
from app.commands.printable import printable

#: Libraries of linear algebra compute in the calling thread: it would spin while it waits for others of theirs, which
#: on a busy computer costs four times what is computed; and matrices here are small.
_SINGLE = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

#: OpenCV writes its own lines past the log for each picture that it cannot read; the program reports those itself.
_QUIET = "OPENCV_LOG_LEVEL"


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; a person's mistake is one sentence and the code 2."""
    for name in _SINGLE:  # read when the library is loaded, which no command has done yet
        os.environ.setdefault(name, "1")
    os.environ.setdefault(_QUIET, "SILENT")
    args = build_parser().parse_args(argv)
    try:
        code: int = COMMANDS[args.command].run(args)
        sys.stdout.flush()
        return code
    except ConfigError as failure:
        print(printable(f"hbba {args.command}: {failure}"), file=sys.stderr)
        return 2
    except BrokenPipeError:
        # The reader of the output has ended (`hbba solve ... | head`): nothing is printed, not even at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
