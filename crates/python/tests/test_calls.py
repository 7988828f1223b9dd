"""Long calls let other threads run, hear Ctrl-C, and tell how far they are."""

import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import vibrochain as vc

# Minutes of work.
LONG = {
    "model": {"sites": 101, "gamma1": 0.2, "asymmetry": 0.4, "amplitude": 0.1, "restitution": 0.9},
    "sweep": {
        "x": {"parameter": "omega", "from": 0.4, "to": 3.0, "points": 400},
        "y": {"parameter": "gamma2", "from": 0.0, "to": 0.3, "points": 300},
    },
    "compute": {"families": ["double-sided"], "stability": True},
}


# What takes minutes and more, each in a process of its own: what does not look at the flag would go on beside other tests.
CALLS = {
    "sweep": "vc.sweep(scene, threads=1)",
    "simulate": """vc.simulate(
        vc.Model(vc.Chain(400, 0.2, 0.1), omega=1.5, asymmetry=0.0),
        displacement=[0.0] * 400, velocity=[0.01 * n - 2.0 for n in range(400)], periods=1e7)""",
    "breathers": """vc.Model(
        vc.Chain(3_000_000, 0.2, 0.1), omega=0.011, asymmetry=0.4, amplitude=0.1, restitution=0.9).breathers("double-sided")""",
    "fate": "vc.fate(scene, periods=10_000_000, threads=1)",
    "locate": """vc.locate(
        vc.Model(vc.Chain(101, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
        .breathers("double-sided").physical(), "neimark-sacker", "omega")""",
    "curve": """vc.curve(
        vc.locate(
            vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.07, asymmetry=0.8, amplitude=0.165, restitution=0.25)
            .breathers("single-sided").physical(), "period-doubling", "amplitude", from_=0.1, to=0.3).points[0],
        "restitution", from_=0.1, to=0.3, and_from=0.2, and_to=0.3, tolerance=1e-12)""",
    "branch": """vc.branch(
        vc.Model(vc.Chain(401, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
        .breathers("double-sided").physical(), "omega")""",
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
@pytest.mark.parametrize("call", CALLS)
def test_ctrl_c_is_heard(call):
    code = f"""
import os, time
import vibrochain as vc
scene = {LONG!r}

def names():
    listed = []
    for task in os.listdir("/proc/self/task"):
        try:
            listed.append(open(f"/proc/self/task/{{task}}/comm").read().strip())
        except OSError:
            pass
    return listed

print("ready", flush=True)
try:
    {CALLS[call]}
except KeyboardInterrupt:
    print("heard", flush=True)
    # Nothing works on, unseen; but for what a single orbit takes.
    until = time.monotonic() + 60
    while {call != "breathers"} and os.path.exists("/proc/self/task") and "vibrochain" in names():
        assert time.monotonic() < until, names()
        time.sleep(0.01)
    print("ended", flush=True)
"""
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.3)
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        # A generous limit, of a machine that has much else to do: all of them would take minutes.
        assert process.stdout.readline() == "heard\n" and time.monotonic() - sent < 10
        assert process.stdout.readline() == "ended\n"
        assert process.wait(timeout=90) == 0


def test_other_threads_run_meanwhile():
    counts = []
    done = threading.Event()

    def count():
        while not done.is_set():
            counts.append(time.monotonic())
            time.sleep(0.001)

    other = threading.Thread(target=count)
    other.start()
    started = time.monotonic()
    scene = {**LONG, "sweep": {**LONG["sweep"], "y": {**LONG["sweep"]["y"], "points": 20}}}
    vc.sweep(scene, threads=1)
    ended = time.monotonic()
    done.set()
    other.join()
    within = [moment for moment in counts if started < moment < ended]
    # Where the lock is held there is none at all.
    assert ended - started > 0.01 and len(within) > 3, (ended - started, len(within))


def test_progress_is_told_and_may_stop_a_sweep():
    told = []

    def progress(done, cells):
        told.append((done, cells))
        if len(told) == 3:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        vc.sweep(LONG, threads=1, progress=progress)
    assert len(told) == 3 and all(done <= cells == 120_000 for done, cells in told)
    assert [done for done, _ in told] == sorted(done for done, _ in told)


def test_progress_is_a_line_on_standard_error(capsys):
    scene = {**LONG, "sweep": {**LONG["sweep"], "y": {**LONG["sweep"]["y"], "points": 20}}}
    vc.sweep(scene, threads=1, progress=True)
    captured = capsys.readouterr()
    assert captured.out == "" and "/8000 cells" in captured.err and captured.err.endswith("\r")


def test_threads_work_at_once():
    """Values are shared between Python threads, which all get the same bits."""
    model = vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)
    orbit = model.breathers("double-sided").physical()
    expected = orbit.stability().multipliers.tobytes(), orbit.displacement(np.linspace(0, 4, 200)).tobytes()
    wrong = []

    def work():
        for _ in range(20):
            got = orbit.stability().multipliers.tobytes(), orbit.displacement(np.linspace(0, 4, 200)).tobytes()
            if got != expected:
                wrong.append(got)

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
