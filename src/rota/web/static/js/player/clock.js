/** The time that is shown: it stands, runs at a speed, or follows the clock on the wall. */

export const SPEEDS = [1, 2, 5, 10, 20, 50, 100];

export class Clock {
  /** @param {{from_s: number, repeat_s: number|null, end_s: number}} span what the slider runs over */
  constructor(span) {
    this.span = span;
    this.end = span.end_s;
    this.time = 0;
    this.speed = 10;
    this.playing = false;
    /** @type {number|null} milliseconds of the wall clock at time 0; null: it is not followed */
    this.startsAt = null;
    /** Whether what is shown may jump back by a common period of all loops, which then changes nothing. */
    this.mayWrap = true;
    /** Whether time may stop once all robots hold. */
    this.mayStop = true;
  }

  /** When all has been seen once and the loops go on as for ever; 0 for robots that spread and hold. */
  static steady({ from_s: from, repeat_s: repeat, end_s: end }, firstCoverage) {
    if (repeat === 0) return 0;
    const seen = Math.max(from, firstCoverage ?? 0);
    return Math.min(seen, repeat ? end - repeat : end);
  }

  /** Moves on by so many seconds of the wall clock. Returns whether the time changed. */
  tick(elapsed) {
    const before = this.time;
    if (this.startsAt !== null) this._set(Math.max(0, (Date.now() - this.startsAt) / 1000));
    else if (this.playing) this._set(this.time + elapsed * this.speed);
    return this.time !== before;
  }

  /** Jumps to a time. */
  seek(time) {
    this.startsAt = null;
    this.time = Math.max(0, time);
    this.end = Math.max(this.end, this.time);
  }

  _set(time) {
    const { repeat_s: repeat, end_s: end } = this.span;
    if (time <= this.end) {
      this.time = time;
    } else if (repeat === 0 && this.mayStop) {
      // all robots hold: nothing changes any more
      this.time = this.startsAt === null ? this.end : time;
      if (this.startsAt === null) this.playing = false;
      else this.end = time;
    } else if (repeat && this.mayWrap) {
      this.time = time - Math.ceil((time - end) / repeat) * repeat;
    } else {
      this.time = time;
      this.end = time;
    }
  }
}
