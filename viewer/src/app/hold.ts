/** Keeps back changes for a moment that would show less than what is there. */

export interface Clock {
  start(call: () => void, milliseconds: number): number;
  stop(timer: number): void;
}

const pageClock: Clock = {
  start: (call, milliseconds) => window.setTimeout(call, milliseconds),
  stop: (timer) => window.clearTimeout(timer),
};

/**
 * A surface of another isovalue comes in steps, coarse ones first. Where all of them are there within the
 * patience, the old surface stays until then; otherwise what has come is shown, to be refined in view.
 */
export class Hold<T> {
  private readonly held: T[] = [];
  private timer: number | null = null;

  constructor(
    private readonly patience: number, // [ms]
    private readonly show: (item: T) => void,
    private readonly clock: Clock = pageClock,
  ) {}

  /** Takes the next; shows it, after those held, at once or later. */
  take(item: T, mayWait: boolean): void {
    this.held.push(item);
    if (!mayWait) this.release();
    else this.timer ??= this.clock.start(() => this.release(), this.patience);
  }

  /** Shows nothing more. */
  stop(): void {
    this.held.length = 0;
    this.stopTimer();
  }

  private release(): void {
    this.stopTimer();
    for (const item of this.held.splice(0)) this.show(item);
  }

  private stopTimer(): void {
    if (this.timer !== null) this.clock.stop(this.timer);
    this.timer = null;
  }
}
