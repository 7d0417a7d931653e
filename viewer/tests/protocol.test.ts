import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  encodeAcknowledgement,
  encodeCredits,
  encodeFocus,
  encodeHello,
  encodeIsovalue,
  encodeView,
  parseMessage,
} from '../src/stream/protocol';
import { vectors } from './vectors';

const all = vectors();
const bytesOf = (name: string) => all.get(name) as Uint8Array;
const hex = (bytes: Uint8Array) => Buffer.from(bytes).toString('hex');

test('what the client says is as in the vectors', () => {
  const hello = encodeHello(1_000_000, [
    { hash: 0x0123456789abcdefn, bytes: 300 },
    { hash: 7n, bytes: 41 },
  ]);
  assert.equal(hex(hello), hex(bytesOf('hello')));
  const view = encodeView({
    width: 1280,
    height: 720,
    eye: [1, 2, 3],
    forward: [0, 1, 0],
    up: [0, 0, 1],
    fieldOfView: 1,
    pixelError: 2.5,
  });
  assert.equal(hex(view), hex(bytesOf('view')));
  assert.equal(hex(encodeIsovalue(300.25)), hex(bytesOf('isovalue')));
  const focus = encodeFocus([
    { low: [0, 0, 0], high: [1, 2, 3], radius: 4, error: 0.5, falloff: 0.125 },
  ]);
  assert.equal(hex(focus), hex(bytesOf('focus')));
  assert.equal(hex(encodeCredits(1 << 20)), hex(bytesOf('credits')));
  assert.equal(hex(encodeAcknowledgement(9n)), hex(bytesOf('acknowledge')));
});

test('what the service says is read as in the vectors', () => {
  assert.deepEqual(parseMessage(bytesOf('welcome')), {
    type: 'welcome',
    longestMessage: 65536,
    origin: [1, 2, 3],
    edge: 64,
    worldFromField: [1, 0, 0, 0, 2, 0, 0, 0, 3, 4, 5, 6],
    isovalue: 300.25,
    low: [0, 0, 0],
    high: [10, 20, 30],
    eye: [7, 8, 9],
    target: [5, 5, 5],
    up: [0, 0, 1],
  });
  assert.deepEqual(parseMessage(bytesOf('transaction')), {
    type: 'transaction',
    isLast: true,
    isSettled: true,
    id: 5n,
    isovalue: 300.25,
    pixelError: 2.5,
    milliseconds: 12,
    removed: ['1073741824,1073741824,3,4'],
    added: [{ cell: '5,6,7,1', hash: 0x0123456789abcdefn }],
    forgotten: [11n],
  });
  assert.deepEqual(parseMessage(bytesOf('error')), { type: 'error', code: 3, text: 'why?' });
});

test('messages that are cut or go on are refused', () => {
  for (const name of ['welcome', 'transaction', 'error']) {
    const bytes = bytesOf(name);
    for (let size = 0; size < bytes.length; ++size)
      assert.throws(() => parseMessage(bytes.subarray(0, size)), RangeError, `${name} ${size}`);
    assert.throws(() => parseMessage(Uint8Array.of(...bytes, 0)), RangeError, name);
  }
});

test('another version and unknown messages are refused', () => {
  const other = bytesOf('welcome').slice();
  other[1] = 2;
  assert.throws(() => parseMessage(other), /version 2/);
  for (const type of [0, 1, 0x80, 0x84, 0xfe])
    assert.throws(() => parseMessage(Uint8Array.of(type, 0, 0, 0)), RangeError);
});
