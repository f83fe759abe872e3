"""Configuration of the whole program: the models of ``config/*.yaml``, read with file and line in every error."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, RootModel

from app.attention.calibration import CostCalibration, calibration_file, load_cost_calibration
from app.base import paths
from app.base.errors import ConfigError
from app.base.extensions import package_file, split_package_file
from app.base.yaml_source import Document, load_yaml
from app.remote.settings import NodesSettings
from app.runtime.channel_table import ChannelSpec
from app.runtime.graph import ModuleSpec

log = logging.getLogger("hbba.config")


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class PowerConfig(_Model):
    """How much power strategies may draw, by the charge of the battery, and what power left over is worth."""

    resource: str = Field("power", min_length=1, description="the resource of the strategies' costs, in W")
    full_w: float = Field(ge=0, le=1e6, description="while the battery charges, or has more than from_charge")
    empty_w: float = Field(ge=0, le=1e6, description="with an empty battery; in between it falls linearly")
    from_charge: float = Field(0.5, gt=0, le=1, description="share of the charge below which it falls")
    weight: float = Field(0.0, ge=0, le=8, multiple_of=0.001, description="of each W left over in Ω; 0: none")

    def capacity_w(self, charge: float, *, charging: bool) -> float:
        """The power (W) that strategies may draw at ``charge`` (0 to 1)."""
        share = 1.0 if charging else min(1.0, charge / self.from_charge)
        return self.empty_w + share * (self.full_w - self.empty_w)


class WeightsConfig(_Model):
    """What Ω is made of; 1 and 1 are the thesis's."""

    intensity: float = Field(1.0, ge=0, le=8, multiple_of=0.001, description="of intensities of what is fulfilled")
    utility: float = Field(1.0, ge=0, le=8, multiple_of=0.001, description="of the utilities that strategies produce")


class ClosedLoopConfig(_Model):
    """How attention follows what is measured."""

    costs: bool = Field(True, description="costs of the CPU follow the CPU that modules take")
    most: float = Field(5.0, ge=1, le=100, description="an estimate is at most so many times what is declared; ...")
    pressure: bool = Field(True, description="the budget of the CPU follows the pressure on the computer")
    least_share: float = Field(0.5, gt=0, le=1, description="of the budget that pressure leaves in any case")
    confidence: bool = Field(True, description="utilities follow how well perceptions say that they work")
    least_confidence: float = Field(0.25, gt=0, le=1, description="of a utility that is left in any case")


def _on_or_off(value: Any) -> Any:
    return {} if value in ("on", True) else None if value in ("off", False) else value


class AttentionConfig(_Model):
    """Settings of attention: how intentions are chosen."""

    safe_strategies: tuple[str, ...] = Field(
        (), description="strategies kept while the solver has not answered yet, or cannot"
    )
    solve_time_limit_s: float = Field(0.5, gt=0, le=10, description="the solver keeps the best it has found by then")
    history: int = Field(20_000, ge=100, description="events the timeline remembers")
    hysteresis_gain: float = Field(0.0, ge=0, description="a switch must gain more than this in Ω ...")
    hysteresis_dwell_s: float = Field(0.0, ge=0, description="... or last for longer than this; 0 and 0: at once")
    weights: WeightsConfig = WeightsConfig()
    closed_loop: Annotated[ClosedLoopConfig | None, BeforeValidator(_on_or_off)] = Field(
        None, description="on, off, or what of it is on: whether costs, budget and utilities follow what is measured"
    )
    idle_after_s: float = Field(10.0, gt=0, description="intended so long without being exploited is noted")
    power: PowerConfig | None = Field(None, description="power as a resource, where the body has a battery")


class ConsoleConfig(_Model):
    """The address of the console."""

    name: str = Field("", max_length=40, description="this robot's name among others; empty: that of its body")
    host: str = "127.0.0.1"
    port: int = Field(8080, ge=0, le=65535, description="0: any free port")
    scene_port: int | None = Field(
        None, ge=0, le=65535, description="port of the 3D view alone; null: the next one, or any that is free"
    )
    # Its token is no part of this: a configuration is attached to every recording.
    host_names: tuple[str, ...] = Field((), description="names it is reached by beside the computer's own")
    command_validity_s: float = Field(
        0.4, ge=0.1, le=2, description="a drive command that is older when it comes moves nothing"
    )
    full_speed_within_s: float = Field(
        0.3, ge=0.05, le=2, description="... that is older than this drives slower; command_validity_s: never"
    )


def _one_or_more(value: Any) -> Any:
    return [value] if isinstance(value, str | Path) else value


class ProgramConfig(_Model):
    """One robot program, as its file declares it.

    Paths are relative to the file; ``package:NAME/PATH`` is a file of an installed package.
    """

    robot: Path
    channels: Annotated[tuple[Path, ...], BeforeValidator(_one_or_more)] = Field(
        min_length=1, description="a table of channels, or several that have no channel in common"
    )
    strategies: tuple[Path, ...] = Field(min_length=1)
    rules: tuple[Path, ...] = Field((), description="files of rules, which a module of class Rules goes by")
    calibration: Path = Field(Path("calibration"), description="folder of what modules cost, a file for each computer")
    attention: AttentionConfig = AttentionConfig()
    console: ConsoleConfig = ConsoleConfig()
    nodes: NodesSettings | None = Field(None, description="other computers that may run modules of this program")
    modules: dict[str, ModuleSpec] = Field(min_length=1)


class ChannelTableFile(RootModel[dict[str, ChannelSpec]]):
    """The file of the channel table."""


@dataclass(frozen=True, slots=True)
class Configuration:
    """A program's configuration with the documents it came from, so that later errors can still name their line."""

    program: ProgramConfig
    channels: dict[str, ChannelSpec]
    program_document: Document
    #: The document that holds the row of each channel.
    channel_documents: Mapping[str, Document]
    #: Measured costs of modules on this computer; None without a calibration.
    calibration: CostCalibration | None = None

    @property
    def folder(self) -> Path:
        """The folder that the program's paths are relative to."""
        return Path(self.program_document.file).resolve().parent

    @property
    def calibration_file(self) -> Path:
        """Path of this computer's calibration, which need not exist."""
        return calibration_file(self.path(self.program.calibration), paths.host_name())

    def path(self, relative: Path) -> Path:
        """A path of the configuration as an absolute one. Raises ConfigError for a package that is not installed."""
        return package_file(relative, self.folder)

    def where(self, *key: str) -> str:
        """File and line of ``key`` of the program."""
        return f"{self.program_document.file}:{self.program_document.line(key)}"

    def wiring_error(self, message: str, key: tuple[str, ...]) -> ConfigError:
        """The ConfigError for a mistake in the graph, with the line of ``key`` in its file."""
        if key[0] == "channels":
            return self.channel_documents[key[1]].error(f"{'.'.join(key[1:])}: {message}", key[1:])
        return self.program_document.error(f"{'.'.join(key)}: {message}", key)


def load_configuration(path: Path, *, host: str | None = None) -> Configuration:
    """Read a program's configuration, its table of channels and the calibration of ``host`` (None: this computer).

    Raises ConfigError for anything that cannot be.
    """
    document = load_yaml(path)
    program = document.validate(ProgramConfig)
    folder = Path(path).resolve().parent
    _file(document, ("robot",), program.robot, folder)
    tables = [
        load_yaml(_file(document, ("channels", number), file, folder)) for number, file in enumerate(program.channels)
    ]
    for number, file in enumerate(program.strategies):
        _file(document, ("strategies", number), file, folder)
    for number, file in enumerate(program.rules):
        _file(document, ("rules", number), file, folder)
    channels, channel_documents = _channels(tables)
    host = host or paths.host_name()
    calibration = load_cost_calibration(folder / program.calibration, host)
    if calibration is not None:
        measured = ", ".join(sorted(calibration.relations))
        log.info("costs as calibrated", extra={"host": host, "made": calibration.made, "filters": measured})
    return Configuration(program, channels, document, channel_documents, calibration)


def _file(document: Document, key: tuple[str | int, ...], named: Path, folder: Path) -> Path:
    """The file that ``document`` names under ``key``. Raises ConfigError where there is none."""
    try:
        found = package_file(named, folder)
    except ConfigError as failure:
        raise document.error(f"{named}: {failure.message}", key) from None
    if not found.is_file():
        beside = "" if split_package_file(named) else f" beside {document.file}"
        raise document.error(f"there is no file {named}{beside}", key)
    return found


def _channels(tables: Iterable[Document]) -> tuple[dict[str, ChannelSpec], dict[str, Document]]:
    """The rows of all ``tables``, and the document of each. Raises ConfigError for a channel that two of them have."""
    rows: dict[str, ChannelSpec] = {}
    documents: dict[str, Document] = {}
    for table in tables:
        for name, row in table.validate(ChannelTableFile).root.items():
            if name in rows:
                raise table.error(f"channel {name!r} is already in {documents[name].file}", (name,))
            rows[name], documents[name] = row, table
    return rows, documents
