"""Pictures, animations, and the program."""

from __future__ import annotations

import subprocess
import sys
import urllib.request
from pathlib import Path

import numpy as np
import pytest

import dualbody as db
from dualbody.view import Pictures


def swinging() -> db.Recording:
    simulator = db.Simulator(db.samples.pendulum(), time_step=0.01)
    return db.Recording.of_simulation(simulator, simulator.rollout([1.0], [0.0], steps=50))


def test_pictures_of_a_recording_equal_those_of_its_states() -> None:
    recording = swinging()
    pictures = Pictures(recording, 80, 60)
    picture = recording.picture(0.0, 80, 60)
    assert picture.shape == (60, 80, 3) and picture.dtype == np.uint8
    np.testing.assert_array_equal(picture, pictures.of([1.0]))
    assert not np.array_equal(picture, pictures.of([0.0]))
    assert pictures.warnings == []


def test_files_are_of_their_kind(tmp_path: Path) -> None:
    recording = swinging()
    recording.save_png(tmp_path / "a" / "end.png", 9.0, 80, 60)
    recording.save_gif(tmp_path / "a" / "motion.gif", 80, 60, rate=10.0, speed=0.5)
    assert (tmp_path / "a" / "end.png").read_bytes()[1:4] == b"PNG"
    gif = (tmp_path / "a" / "motion.gif").read_bytes()
    assert gif == recording.to_gif(80, 60, 10.0, 0.5) and gif[:6] == b"GIF89a"
    with pytest.raises(OSError, match="end.png"):
        recording.save_gif(tmp_path / "a" / "end.png" / "x.gif")


def test_odd_arguments_are_named() -> None:
    recording = swinging()
    with pytest.raises(ValueError, match="pixels"):
        recording.picture(0.0, 0, 10)
    with pytest.raises(ValueError, match="rate"):
        recording.to_gif(8, 8, rate=0.0)
    with pytest.raises(ValueError, match="configurations"):
        Pictures(recording).of()


def test_a_live_simulation_serves_its_page_until_it_is_stopped() -> None:
    live = db.Simulator(db.samples.pendulum(), time_step=0.001).live([0.5])
    with urllib.request.urlopen(live.url) as answer:
        assert b"pivot" in answer.read()
    assert live.url in live._repr_html_()
    assert live.state[0] == pytest.approx([0.5], abs=0.2) and len(live.recording()) >= 1
    live.stop()
    with pytest.raises(OSError):
        urllib.request.urlopen(live.url, timeout=5)
    with pytest.raises(ValueError, match="ended"):
        live.recording()


@pytest.mark.parametrize("arguments, status", [(["--version"], 0), (["info", "no_such.urdf"], 2)])
def test_the_module_is_the_program(arguments: list[str], status: int) -> None:
    done = subprocess.run([sys.executable, "-m", "dualbody", *arguments], capture_output=True, text=True)
    assert done.returncode == status
    assert ("dualbody" in done.stdout) if status == 0 else ("no_such.urdf" in done.stderr)
