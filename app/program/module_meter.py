"""Load and counters of modules, as they are published and as REST answers with them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar, get_args

from app.messages import ModuleInput, ModuleOutput, ModuleReport, ModuleRole, SubscriptionCounters
from app.runtime.graph import ModuleSlot
from app.runtime.load import LoadMeter
from app.runtime.module import Module
from app.runtime.subscription import SubscriptionStatistics
from app.runtime.supervisor import Supervisor


class ModuleMeter:
    """Load and counters of every module; CPU per message is taken between two calls of :meth:`sample`."""

    def __init__(self, modules: Mapping[str, ModuleSlot], supervisor: Supervisor, load: LoadMeter) -> None:
        self._modules = modules
        self._supervisor = supervisor
        self._load = load
        self._counted: dict[str, tuple[int, int]] = {}
        self._message_cpu_us: dict[str, float | None] = {}

    def sample(self) -> tuple[ModuleReport, ...]:
        """Measure CPU per message since the last call (or the start), and report."""
        for name, slot in self._modules.items():
            taken = sum(p.subscription.statistics().taken for p in slot.context.inputs.values() if p.connected)
            before_ns, before = self._counted.get(name, (0, 0))
            self._counted[name] = (slot.context.meter.cpu_ns, taken)
            cpu_us = 1e-3 * (slot.context.meter.cpu_ns - before_ns)
            self._message_cpu_us[name] = round(cpu_us / (taken - before), 1) if taken > before else None
        return tuple(self.module(slot) for slot in self._modules.values())

    def module(self, slot: ModuleSlot) -> ModuleReport:
        """One module now."""
        state = self._supervisor.states[slot.name]
        return ModuleReport(
            name=slot.name,
            title=slot.title,
            state=state.status,
            cpu=round(self._load.latest.modules.get(slot.name, 0.0), 2),
            cpu_budget=slot.spec.cpu_budget,
            message_cpu_us=self._message_cpu_us.get(slot.name),
            restarts=state.restarts,
            problem=state.problem or None,
            inputs=tuple(
                _counted(ModuleInput, port.subscription.statistics(), name=port.name, channel=port.channel.name)
                for port in slot.context.inputs.values()
                if port.connected and port.channel is not None
            ),
            role=role_of(slot.module_class),
            outputs=tuple(
                ModuleOutput(
                    port.name,
                    None if port.channel is None else port.channel.name,
                    port.filter.divisor,
                    port.offered,
                )
                for port in slot.context.outputs.values()
            ),
        )


def role_of(module_class: type[Module]) -> ModuleRole:
    """The layer of a module: as its class says, or the first of the packages it is in that is named as one."""
    if module_class.role is not None:
        return module_class.role
    roles: tuple[ModuleRole, ...] = get_args(ModuleRole)
    packages = module_class.__module__.split(".")
    return next((role for package in packages for role in roles if package == role), "other")


def subscription_counters(statistics: SubscriptionStatistics) -> SubscriptionCounters:
    """The counters of one consumer's end of a channel."""
    return _counted(SubscriptionCounters, statistics)


CountersT = TypeVar("CountersT", bound=SubscriptionCounters)


def _counted(record: type[CountersT], statistics: SubscriptionStatistics, **more: str) -> CountersT:
    """``record`` of the counters, and of what it has ``more``."""
    return record(
        divisor=statistics.divisor,
        received=statistics.received,
        passed=statistics.passed,
        decimated=statistics.decimated,
        dropped=statistics.dropped,
        age_ms=None if statistics.age_s is None else round(1e3 * statistics.age_s, 2),
        **more,
    )
