import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type Clock, Hold } from '../src/app/hold';

/** Time that passes when it is told to. */
class FakeClock implements Clock {
  now = 0;
  private readonly calls = new Map<number, [number, () => void]>();
  private next = 0;

  start(call: () => void, milliseconds: number): number {
    this.calls.set(++this.next, [this.now + milliseconds, call]);
    return this.next;
  }

  stop(timer: number): void {
    this.calls.delete(timer);
  }

  pass(milliseconds: number): void {
    this.now += milliseconds;
    for (const [timer, [due, call]] of [...this.calls])
      if (due <= this.now) {
        this.calls.delete(timer);
        call();
      }
  }
}

function held() {
  const clock = new FakeClock();
  const shown: number[] = [];
  return { clock, shown, hold: new Hold<number>(250, (item) => shown.push(item), clock) };
}

test('what is complete in time is shown at once, all in order', () => {
  const { clock, shown, hold } = held();
  hold.take(1, true);
  clock.pass(100);
  hold.take(2, true);
  clock.pass(100);
  assert.deepEqual(shown, []);
  hold.take(3, false);
  assert.deepEqual(shown, [1, 2, 3]);
  clock.pass(1000);
  assert.deepEqual(shown, [1, 2, 3]);
});

test('nobody waits for longer than the patience, however much comes', () => {
  const { clock, shown, hold } = held();
  for (let i = 0; i < 100; ++i) {
    hold.take(i, true);
    clock.pass(50);
    assert.ok(i + 1 - shown.length <= 5, `${i}: ${shown.length}`);
  }
});

test('what need not wait does not', () => {
  const { shown, hold } = held();
  hold.take(1, false);
  hold.take(2, false);
  assert.deepEqual(shown, [1, 2]);
});

test('after its end nothing is shown', () => {
  const { clock, shown, hold } = held();
  hold.take(1, true);
  hold.stop();
  clock.pass(1000);
  assert.deepEqual(shown, []);
});
