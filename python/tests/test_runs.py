"""Runs in this process: callbacks, interruption, bits, and the other threads of Python."""

import os
import signal
import subprocess
import threading
import time

import numpy
import pytest

import firn


def frames_of(file):
    results = firn.Results(file)
    return [(f.time, f.position.tobytes(), f.orientation.tobytes(), f.velocity.tobytes())
            for f in map(results.frame, range(len(results)))]


def test_run_gives_responses_and_the_bits_of_the_program(case_file, case, tmp_path):
    run = firn.run(case, tmp_path / "here.h5", threads=2)
    assert run.status == "finished" and run.simulated == pytest.approx(0.3, abs=1e-4) and run.steps > 1000
    assert run["present_count"].value == 2 and run["present_mass"].unit == "kg"
    with pytest.raises(KeyError):
        run["weather"]
    assert firn._core.current_response_name("low_fifo_index") == "low_order_index"
    subprocess.run([firn.program(), "run", case_file, "-o", tmp_path / "there.h5", "-q"],
                   check=True, stdout=subprocess.DEVNULL)
    assert frames_of(tmp_path / "here.h5") == frames_of(tmp_path / "there.h5")


def test_each_frame_is_seen_as_it_is_recorded(case, tmp_path):
    seen, last, borne = [], [], []

    def on_frame(frame):
        seen.append((frame.time, frame.position.tobytes(), frame.orientation.tobytes(),
                     frame.velocity.tobytes()))
        contacts = frame.contacts()
        assert set(map(len, contacts.values())) == {len(contacts["a"])}
        # The boxes rest on the floor, body 2.
        if frame.time > 0.2:
            borne.append(contacts["force"][contacts["b"] == 2, 2].sum())
        last[:] = [frame, contacts, frame.position]

    firn.run(case, tmp_path / "run.h5", on_frame=on_frame)
    assert seen == frames_of(tmp_path / "run.h5") and len(seen) == 32  # every 10 ms, and the end
    frame, _, position = last
    assert numpy.mean(borne) == pytest.approx(2 * 916.7 * 8e-6 * 9.81, rel=0.1)
    assert numpy.isfinite(position).all()  # belongs to the caller
    with pytest.raises(RuntimeError, match="frame is over"):
        frame.position


def test_a_callback_stops_the_run_and_resume_continues_it(case, tmp_path):
    whole, part = tmp_path / "whole.h5", tmp_path / "part.h5"
    firn.run(case, whole)
    run = firn.run(case, part, on_frame=lambda frame: frame.time < 0.1)
    assert run.status == "interrupted" and 0.1 <= run.simulated < 0.11 and not run.responses
    assert firn.Results(part).status == "interrupted"
    seen = []
    assert firn.resume(part, threads=2, on_frame=lambda f: seen.append(f.time)).status == "finished"
    assert frames_of(part) == frames_of(whole)
    assert seen[0] > 0.1 and len(seen) == 20


def test_an_exception_of_a_callback_is_raised(case, tmp_path):
    def on_frame(frame):
        if frame.time > 0.05:
            raise LookupError("seen enough")

    with pytest.raises(LookupError, match="seen enough"):
        firn.run(case, tmp_path / "run.h5", on_frame=on_frame)
    assert firn.Results(tmp_path / "run.h5").status == "interrupted"
    assert firn.resume(tmp_path / "run.h5").status == "finished"


def test_ctrl_c_saves_the_state(case, tmp_path):
    long = case.edit({"case.duration": "1000 s"})
    threading.Timer(1, os.kill, (os.getpid(), signal.SIGINT)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        firn.run(long, tmp_path / "run.h5")
    assert time.monotonic() - start < 20
    results = firn.Results(tmp_path / "run.h5")
    assert results.status == "interrupted"
    reached = results.times[-1]
    del results  # a file that is open for reading cannot be written
    again = firn.resume(tmp_path / "run.h5", on_frame=lambda frame: frame.time < reached + 0.1)
    assert again.status == "interrupted" and again.simulated > reached


def test_other_threads_go_on_during_a_run(case, tmp_path):
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    run = firn.run(case.edit({"case.duration": "2 s"}), tmp_path / "run.h5")
    done.set()
    thread.join()
    assert run.status == "finished"
    assert counted[0] > 100 * run.wall  # held, the lock would leave none


def test_what_cannot_run_is_refused(case, tmp_path):
    with pytest.raises(firn.InputError, match="threads"):
        firn.run(case, tmp_path / "run.h5", threads=0)
    with pytest.raises(firn.InputError, match="no results file"):
        firn.run(case, "")
    with pytest.raises(firn.InputError, match="no such file"):
        firn.resume(tmp_path / "none.h5")
    # Too little room for so many boxes.
    with pytest.raises(firn.InputError):
        firn.run(case.edit({"fills.0.count": 2000}), tmp_path / "full.h5")
