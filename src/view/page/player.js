// Time: which moment is shown, and the poses at it.

class Player {
  constructor(times, robots, changed) {
    Object.assign(this, { times, robots, changed, time: times[0], playing: false, speed: 1, loop: true });
  }

  get start() { return this.times[0]; }
  get end() { return this.times[this.times.length - 1]; }

  play(playing) {
    if (playing && this.time >= this.end) this.time = this.start;
    this.playing = playing && this.end > this.start;
    this.changed();
  }

  seek(time) {
    this.time = Math.max(this.start, Math.min(this.end, time));
    this.changed();
  }

  /** To the next moment that is kept, or the one before. */
  step(direction) {
    this.playing = false;
    const { index, fraction } = this.place(this.time);
    const to = direction > 0 ? index + 1 : fraction > 1e-6 ? index : index - 1;
    this.seek(this.times[Math.max(0, Math.min(this.times.length - 1, to))]);
  }

  /** Lets so many seconds of the viewer's time pass. */
  advance(seconds) {
    if (!this.playing) return;
    let time = this.time + seconds * this.speed;
    if (time >= this.end) {
      if (this.loop) time = this.start + ((time - this.start) % (this.end - this.start));
      else this.playing = false;
    }
    this.seek(time);
  }

  /** The moment at or before a time, and how far the time is on the way to the next one. */
  place(time) {
    const { times } = this;
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle;
    }
    if (high > low && time >= times[high]) low = high;
    const width = low + 1 < times.length ? times[low + 1] - times[low] : 1;
    return { index: low, fraction: Math.max(0, Math.min(1, (time - times[low]) / width)) };
  }

  /** The pose of a body of a robot at the k-th moment. */
  poseAt(robot, body, k) {
    const { positions, rotations } = this.robots[robot];
    const i = k * (positions.length / 3 / this.times.length) + body;
    return [...positions.subarray(3 * i, 3 * i + 3), ...rotations.subarray(4 * i, 4 * i + 4)];
  }

  /** The poses of all bodies of a robot now. */
  poses(robot) {
    const { index, fraction } = this.place(this.time);
    const next = Math.min(index + 1, this.times.length - 1);
    const bodies = this.robots[robot].positions.length / 3 / this.times.length;
    return Array.from({ length: bodies }, (_, body) =>
      interpolate(this.poseAt(robot, body, index), this.poseAt(robot, body, next), fraction));
  }

  /** The points of contact now, as [position, force]: those of the moment before. */
  contacts(robot) {
    const found = this.robots[robot].contacts;
    if (!found) return [];
    const { starts, values } = found, { index } = this.place(this.time), points = [];
    for (let k = starts[index]; k < starts[index + 1]; k++)
      points.push([[...values.subarray(6 * k, 6 * k + 3)], [...values.subarray(6 * k + 3, 6 * k + 6)]]);
    return points;
  }

  /** The force that acts now: that of the moment before, as it is held. */
  force(robot, k) {
    const { values } = this.robots[robot].forces[k], { index } = this.place(this.time);
    return [...values.subarray(3 * index, 3 * index + 3)];
  }
}
