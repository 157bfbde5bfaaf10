"""CPU time of a simulation in the browser: `dualbody live` at 1 kHz and 60 frames a second, with a page that only counts its frames.

    cargo build --release --features cli --bin dualbody
    python benches/live.py PROGRAM FILE [SECONDS [WORDS...]]       # needs the package websockets; WORDS go to `dualbody live`

Prints seconds of CPU of the process a second of the clock, frames a second, the largest number of contacts in a frame, and how much of real time was simulated.
"""

import asyncio
import json
import os
import subprocess
import sys
import time

import websockets

WARM_UP = 2.0


def cpu_seconds(process):
    """Of all threads."""
    fields = open(f"/proc/{process.pid}/stat").read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


async def watch(url, process, seconds):
    async with websockets.connect(url.replace("http", "ws") + "socket", max_size=None) as socket:
        begin = time.monotonic()
        while time.monotonic() < begin + WARM_UP:
            first = json.loads(await socket.recv())
        start, used, frames, contacts = time.monotonic(), cpu_seconds(process), 0, 0
        while time.monotonic() < start + seconds:
            last = json.loads(await socket.recv())
            frames, contacts = frames + 1, max(contacts, len(last["contacts"]))
        elapsed = time.monotonic() - start
        print(
            f"{(cpu_seconds(process) - used) / elapsed:.3f} of a core, {frames / elapsed:.1f} frames a second, at most {contacts} contacts, "
            f"{(last['time'] - first['time']) / elapsed:.3f} of real time{', ' + last['trouble'] if last['trouble'] else ''}"
        )


def main():
    program, file, words = sys.argv[1], sys.argv[2], sys.argv[4:]
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 10.0
    process = subprocess.Popen([program, "live", file, "--no-open", "--time-step", "0.001", *words], stdout=subprocess.PIPE, text=True)
    try:
        asyncio.run(watch(process.stdout.readline().strip(), process, seconds))
    finally:
        process.terminate()
        process.wait()


main()
