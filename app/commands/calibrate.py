"""``hbba calibrate``: what each perception costs and finds at each φ, on this computer.

With the word ``microphones`` behind it, it is another command (:mod:`app.commands.calibrate_microphones`).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base import paths
from app.base.errors import ConfigError
from app.base.whole_file import write_whole
from app.commands import calibrate_microphones
from app.commands.arguments import add_config, find_log, names, real, whole
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named

if TYPE_CHECKING:
    from app.attention.calibration import CostCalibration
    from app.attention.strategies import StrategyTable
    from app.logs.log import Log, LogInfo
    from app.logs.replay.calibration_runs import CalibrationProgress, Measurement, Run
    from app.program.config import Configuration

#: A recording shorter than this says little.
LEAST_S = 5.0
#: A channel with a smaller share of its nominal rate is reported.
ENOUGH = 0.9
_FROM_0 = real(0, rule="seconds are a number from 0")


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "calibrate",
        help="measure what each perception costs at each φ on this computer; or where microphones are",
        description="Replay a recorded minute through each perception, at each φ that a strategy gives it; write CPU "
        "use and events against φ, with the lines through them, where strategies find them, plot both, and "
        "print the cost of each strategy. After an interruption, the next run continues.",
        epilog="`hbba calibrate microphones` measures where the microphones of an array are, by claps around it: see "
        "`hbba calibrate microphones --help`.",
    )
    parser.words = {"microphones": calibrate_microphones.make_parser()}
    parser.words["microphones"].set_defaults(calibrates="microphones")
    parser.set_defaults(calibrates="costs")
    parser.add_argument("log", nargs="?", metavar="LOG", help="a log or a recording's name (default: the newest one)")
    add_config(parser)
    parser.add_argument("--seconds", type=_FROM_0, default=60.0, metavar="S", help="seconds of it to use (default 60)")
    parser.add_argument("--from", dest="begin", type=_FROM_0, default=0.0, metavar="S", help="begin S seconds into it")
    parser.add_argument("--only", type=names, metavar="A,B", help="these modules alone")
    parser.add_argument(
        "--phi", type=_sweep, action="append", metavar="M.PORT=A-B",
        help="measure this input at every φ from A to B, and no input without such an option",
    )  # fmt: skip
    parser.add_argument(
        "--offsets", action="store_true", help="from every starting offset of each φ, as the thesis did (φ runs each)"
    )
    parser.add_argument(
        "--repeat",
        type=whole(1, 100),
        default=1,
        metavar="N",
        help="repeat everything N times, for a computer with other load",
    )
    parser.add_argument("--fresh", action="store_true", help="also repeat the measurements of an interrupted run")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="write here (default: calibration/<host>.yaml of the program)"
    )
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    if args.calibrates == "microphones":
        return calibrate_microphones.run(args)
    import cv2

    from app.link import LinkFailed
    from app.logs.log import LogError
    from app.logs.open import open_log
    from app.program.config import load_configuration

    cv2.setNumThreads(1)
    configuration = load_configuration(program_named(args.config) or paths.config_dir() / "lab.yaml")
    path = find_log(args.log) if args.log else _newest()
    try:
        log = open_log(path)
        try:
            return _calibrate(args, configuration, log)
        finally:
            log.close()
    except (LogError, LinkFailed) as failure:
        print(f"hbba calibrate: {failure}", file=sys.stderr)
        return 2


def _calibrate(args: argparse.Namespace, configuration: Configuration, log: Log) -> int:
    from app.commands.calibrate_report import relations_table, strategies_document, strategies_table
    from app.logs.replay.calibration_runs import CalibrationProgress, plan

    info = log.info
    if args.seconds < LEAST_S:
        raise ConfigError(f"--seconds {args.seconds:g}: less than {LEAST_S:g} s says little")
    seconds = min(args.seconds, info.duration_s - args.begin)
    if seconds < LEAST_S:
        after = f" after --from {args.begin:g}" if args.begin else ""
        raise ConfigError(
            f"has {max(0.0, seconds):.1f} s to measure on{after}; {LEAST_S:g} s are the least", str(info.path)
        )
    inputs = _inputs(configuration, log, args.only)
    sweep = None if args.phi is None else _checked(dict(args.phi), inputs, configuration)
    runs = plan(_table(configuration), inputs, every_offset=args.offsets, repeats=args.repeat, sweep=sweep)
    if not runs:
        raise ConfigError(
            "no strategy filters an input that this recording could feed; "
            f"it has {', '.join(sorted(info.channels)) or 'nothing'}",
            str(info.path),
        )
    version = paths.version()
    key = {
        "log": [info.path.name, info.bytes, info.begin], "from": args.begin, "seconds": seconds, "version": version,
        "program": configuration.program.model_dump_json(include={"modules"}),
    }  # fmt: skip
    output = args.out or configuration.calibration_file
    progress = CalibrationProgress(output.with_suffix(".partial.json"), key)
    if not args.fresh and (taken_up := progress.load()):
        print(f"{taken_up} runs were made before and are taken up (--fresh measures them again)", file=sys.stderr)
    print(f"{len(runs)} runs of {seconds:.0f} s of {info.path.name}; Ctrl-C keeps what is measured", file=sys.stderr)
    for doubt in _doubts(configuration, info, runs):
        print(f"hbba calibrate: {doubt}", file=sys.stderr)
    for file in (output, output.with_suffix(".png")):
        _check_writable(file)
    before = _before(output)
    try:
        results = _measure(
            log, configuration, runs=runs, progress=progress, begin=info.begin + args.begin, seconds=seconds
        )
        calibration = _calibration(results, version, f"{info.path.name}, {seconds:.0f} s", before)
        _write(calibration, output)
        progress.discard()
    except OSError as failure:
        raise ConfigError(
            f"cannot be written: {failure.strerror or failure}", str(failure.filename or output)
        ) from None
    measured = {run.relation for run in results}
    table, modules = _table(configuration), configuration.program.modules
    if args.json:
        print_json(
            {
                "written": [output, output.with_suffix(".png")],
                "measured": sorted(measured),
                "calibration": calibration.model_dump(mode="json"),
                "strategies": strategies_document(table, calibration, measured, modules),
            }
        )
        return 0
    print(relations_table(calibration, measured))
    print(strategies_table(table, calibration, measured, modules))
    print(f"Written: {output} and {output.with_suffix('.png').name}")
    return 0


def _doubts(configuration: Configuration, info: LogInfo, runs: Sequence[Run]) -> list[str]:
    """Channels that were recorded at less than their rate, as a busy computer does: all on them seems cheap."""
    modules = configuration.program.modules
    doubts = []
    for name in sorted({modules[run.module].inputs[run.port] for run in runs}):
        nominal, count = configuration.channels[name].rate_hz, info.channels[name].count
        rate = count / info.duration_s if info.duration_s > 0 else 0.0
        if nominal is not None and rate < ENOUGH * nominal:
            doubts.append(f"{name} was recorded at {rate:.1f} Hz of {nominal:g}; what is measured on it holds for that")
    return doubts


def _measure(
    log: Log, configuration: Configuration, runs: list[Run], progress: CalibrationProgress, begin: float, seconds: float
) -> dict[Run, Measurement]:
    from app.commands.progress import shown
    from app.logs.replay.batch_replay import batches
    from app.logs.replay.calibration_runs import measure_all
    from app.logs.replay.measure import Bench

    bench = Bench(log, configuration, begin, begin + seconds, _table(configuration).filters)
    # A run takes as long as its module looks at messages.
    work = {run: 1.0 / run.phi for run in runs}
    total = sum(work.values())

    with shown("measuring") as progress_of_all:

        def measure(batch: Sequence[Run]) -> Sequence[Measurement]:
            done = sum(work[run] for run in runs if run in progress.results)
            here = sum(work[run] for run in batch)
            what = f"{_spans(batch)}, {len(batch)} at once"
            return bench.measure(batch, lambda share: progress_of_all(done + share * here, total, what))

        return measure_all(runs, measure, progress, batches)


def _spans(batch: Sequence[Run]) -> str:
    """The measurements of ``batch`` in words: each input with its least and greatest φ."""
    spans: dict[str, list[int]] = {}
    for run in batch:
        spans.setdefault(run.relation, []).append(run.phi)
    return "; ".join(
        f"{name} φ {min(phis)}" + (f"–{max(phis)}" if len(set(phis)) > 1 else "") for name, phis in spans.items()
    )


def _newest() -> Path:
    """The newest finished recording. Raises ConfigError."""
    from app.logs.catalog import Catalog
    from app.logs.library import RecordingLibrary, default_folder

    library = RecordingLibrary(default_folder())
    try:
        found = [recording.name for recording in Catalog(library).recordings() if recording.complete]
    except OSError as failure:
        raise ConfigError(f"cannot be read: {failure.strerror or failure}", str(library.folder)) from None
    if not found:
        raise ConfigError(
            f"there is no finished recording in {library.folder}; record a minute on the console first (hbba "
            "run, Record), or name a log: hbba calibrate FILE"
        )
    return library.path(found[0])


def _table(configuration: Configuration) -> StrategyTable:
    from app.attention.strategy_file import load_strategies
    from app.program.desire_classes import desire_classes

    files = [configuration.path(file) for file in configuration.program.strategies]
    return load_strategies(files, classes=desire_classes(configuration))


def _inputs(configuration: Configuration, log: Log, only: Sequence[str] | None) -> dict[str, list[str]]:
    """The inputs of each module to be measured that the recording can feed. Raises ConfigError."""
    modules = configuration.program.modules
    for name in only or ():
        if name not in modules:
            raise ConfigError(
                f"there is no module {name!r}; there are {', '.join(sorted(modules))}",
                configuration.program_document.file,
            )
    return {
        name: [port for port, channel in spec.inputs.items() if channel in log.info.channels]
        for name, spec in modules.items()
        if only is None or name in only
    }


def _before(output: Path) -> CostCalibration | None:
    """Former measurements that are not repeated now: they are kept. Raises ConfigError for a file that is no
    calibration."""
    from app.attention.calibration import CostCalibration
    from app.base.yaml_source import load_yaml

    return load_yaml(output).validate(CostCalibration) if output.is_file() else None


def _calibration(
    results: dict[Run, Measurement], version: str, log: str, before: CostCalibration | None
) -> CostCalibration:
    from app.attention.calibration import CostCalibration
    from app.logs.replay.calibration_runs import relations

    return CostCalibration(
        host=paths.host_name(),
        made=datetime.now(UTC).isoformat(timespec="seconds"),
        processor=paths.processor(),
        version=version,
        log=log,
        relations={**(before.relations if before is not None else {}), **relations(results)},
    )


def _check_writable(output: Path) -> None:
    """Better before the minutes of measuring than after them."""
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        with output.open("a", encoding="utf-8"):
            pass
        if output.stat().st_size == 0:
            output.unlink()
    except OSError as failure:
        raise ConfigError(f"cannot be written: {failure.strerror}; choose another with --out", str(output)) from None


def _write(calibration: CostCalibration, output: Path) -> None:
    import yaml

    from app.logs.replay.calibration_plot import plot

    head = "# CPU time of modules here, as `hbba calibrate` measured it; `calibrated_or` costs rest on it.\n"
    content = yaml.safe_dump(calibration.model_dump(mode="json"), sort_keys=False, allow_unicode=True)
    write_whole(output, (head + content).encode())
    plot(calibration, output.with_suffix(".png"))


def _sweep(text: str) -> tuple[str, range]:
    """``Module.port=A-B`` or ``Module.port=A``."""
    name, _, span = text.partition("=")
    first, _, last = span.partition("-")
    if "." not in name or not first.isdecimal() or not (last or first).isdecimal():
        raise argparse.ArgumentTypeError(f"give Module.port=A-B, such as QRCodeDetector.images=2-10, not {text!r}")
    low, high = int(first), int(last or first)
    if not 1 <= low <= high <= 1000:
        raise argparse.ArgumentTypeError(f"φ goes from 1 to 1000, the lower first, not {span!r}")
    return name, range(low, high + 1)


def _checked(sweep: dict[str, range], inputs: dict[str, list[str]], configuration: Configuration) -> dict[str, range]:
    """``sweep``, if the recording feeds all its inputs and they may be decimated. Raises ConfigError."""
    fed = sorted(f"{module}.{port}" for module, ports in inputs.items() for port in ports)
    for name in sweep:
        if name not in fed:
            raise ConfigError(
                f"--phi: no input {name!r} is fed by this recording; there are {', '.join(fed)}",
                configuration.program_document.file,
            )
        module, _, port = name.partition(".")
        channel = configuration.program.modules[module].inputs[port]
        if max(sweep[name]) > 1 and not configuration.channels[channel].decimable:
            raise ConfigError(
                f"--phi: {channel}, the channel of {name}, may not be decimated: only {name}=1 can be measured",
                configuration.program_document.file,
            )
    return sweep
