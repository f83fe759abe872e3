"""Many runs in one replay: what each finds and costs is what it would alone."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.attention.strategies import CLOSED
from app.base import paths
from app.logs.replay.batch_replay import MOST, ExclusiveCpuMeter, batch_program, batches
from app.logs.replay.calibration_runs import Measurement, Run
from app.logs.replay.measure import WARM_UP_S, Bench
from app.program.config import load_configuration
from app.runtime.filter_bank import Pin
from tests.logs.replay.logs import MemoryLog, lab_messages

# Nothing runs on a loop that others wait for: the replay's own loop is virtual.
blocking = pytest.mark.blocking(reason="the virtual loop waits for threads by design")


@blocking
def test_runs_side_by_side_find_what_each_finds_alone_and_decode_the_log_once() -> None:
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    runs = [Run("QRCodeDetector", "images", phi, offset) for phi, offset in ((1, 0), (2, 1), (3, 0), (3, 2))]

    messages = lab_messages(WARM_UP_S + 1.5)

    def measured(*of: Run) -> tuple[list[Measurement], int]:
        log = MemoryLog(messages)
        bench = Bench(log, configuration, log.info.begin, log.info.end, ("QRCodeDetector.images",))
        return bench.measure(of), log.decoded["kinect"]

    together, decoded = measured(*runs)
    alone = [measured(run) for run in runs[1:]]
    assert {once for _, once in alone} == {decoded}
    assert [m.events for m in together[1:]] == [m.events for (m,), _ in alone]
    assert [m.events for m in together] == [15, 7, 5, 5]  # of fifteen pictures with one code each
    cost, cost_alone = (sum(m.cpu_s for m in all_) for all_ in (together[1:], [m for (m,), _ in alone]))
    assert 0.4 * cost_alone < cost < 2.5 * cost_alone


def test_each_instance_has_its_outputs_its_filters_and_its_parameters() -> None:
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    near = Run("FaceDetector", "images", 4, 3, parameters='{"fine": false}')
    fine = Run("FaceDetector", "panorama", 1)
    program = batch_program(
        configuration, [near, fine], {"FaceDetector.images", "FaceDetector.panorama", "Teleop.twist"}
    )
    assert program.names == ("FaceDetector~0", "FaceDetector~1")
    assert program.events == ("faces~0", "faces~1")
    assert program.parameters == {"FaceDetector~0": {"fine": False}, "FaceDetector~1": {}}
    modules = program.configuration.program.modules
    assert set(modules) == set(program.names)
    assert modules["FaceDetector~1"].inputs == configuration.program.modules["FaceDetector"].inputs
    assert program.configuration.channels["faces~1"] == configuration.channels["faces"]
    assert program.pins["FaceDetector~0.panorama"] == program.pins["FaceDetector~1.images"] == Pin(CLOSED)
    assert program.pins["FaceDetector~1.panorama"] == Pin(1)
    assert "FaceDetector~0.odometry" not in program.pins


_RUNS = st.lists(
    st.tuples(st.sampled_from("AB"), st.sampled_from("xy"), st.integers(1, 40), st.integers(0, 1)), unique=True
).map(
    lambda wanted: [
        Run(module, port, phi, offset, repeat)
        for module, port, phi, repeat in sorted(wanted, key=lambda w: (w[3], w))
        for offset in range(phi)
    ]
)


@given(_RUNS, st.integers(1, 40))
def test_batches_hold_all_runs_in_their_order_each_of_one_module(runs: list[Run], most: int) -> None:
    found = batches(runs, most)
    assert [run for batch in found for run in batch] == runs
    for batch in found:
        assert 1 <= len(batch) <= most
        assert len({(run.module, run.repeat) for run in batch}) == 1


def test_offsets_that_share_the_messages_stay_together() -> None:
    runs = [Run("A", "x", phi, offset) for phi in (15, 16, 20) for offset in range(phi)]
    assert [sorted({run.phi for run in batch}) for batch in batches(runs)] == [[15, 16], [20]]
    wide = [replace(run, phi=40) for run in runs[:40]]
    assert [len(batch) for batch in batches(wide)] == [MOST, 8]


def test_meters_that_take_turns_never_compute_at_once_and_do_not_charge_the_wait() -> None:
    lock, inside, most = threading.RLock(), 0, 0
    meters = [ExclusiveCpuMeter(lock) for _ in range(4)]

    def work() -> None:
        nonlocal inside, most
        inside += 1
        most = max(most, inside)
        begin = time.thread_time()
        while time.thread_time() - begin < 0.005:
            pass
        inside -= 1

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda meter: meter.call(work), meters))
    assert most == 1
    for meter in meters:
        assert 5e6 <= meter.cpu_ns < 15e6
