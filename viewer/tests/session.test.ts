import assert from 'node:assert/strict';
import { test } from 'node:test';
import { CELL_FIELDS } from '../src/stream/batch';
import { ByteWriter } from '../src/stream/bytes';
import { type Change, Session } from '../src/stream/session';
import { type FakeCell, payloadOf, plainCodec } from './fake-cells';
import { vectors } from './vectors';

const welcome = vectors().get('welcome') as Uint8Array; // the domain's edge is 64

function fakeCell(x: number, exponent = 20): FakeCell {
  return {
    low: [x, 0, 0],
    exponent,
    positions: [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
    triangles: [[0, 1, 2]],
  };
}

function cellsMessage(payloads: [bigint, Uint8Array][]): Uint8Array {
  const parts: number[] = [...new ByteWriter(8).u8(0x82, 0, 0, 0).u32(payloads.length).bytes];
  for (const [hash, bytes] of payloads)
    parts.push(...new ByteWriter(12).u64(hash).u32(bytes.length).bytes, ...bytes);
  return Uint8Array.from(parts);
}

interface Part {
  id: number;
  isLast?: boolean;
  removed?: number[];
  added?: [number, bigint][];
  forgotten?: bigint[];
}

function transactionMessage(part: Part): Uint8Array {
  const { removed = [], added = [], forgotten = [], isLast = true } = part;
  const writer = new ByteWriter(48 + 13 * removed.length + 21 * added.length + 8 * forgotten.length);
  writer.u8(0x83, isLast ? 1 : 0, 0, 0);
  writer.u32(removed.length).u32(added.length).u32(forgotten.length);
  writer.u64(BigInt(part.id)).f64(1, 2, 3);
  for (const cell of removed) writer.u32(cell).u32(0).u32(0).u8(0);
  for (const [cell, hash] of added) writer.u32(cell).u32(0).u32(0).u8(0).u64(hash);
  for (const hash of forgotten) writer.u64(hash);
  return writer.bytes;
}

class Peer {
  readonly sent: Uint8Array[] = [];
  readonly changes: Change[] = [];
  readonly session = new Session(plainCodec, {
    send: (bytes) => this.sent.push(bytes),
    welcomed: () => {},
    changed: (change) => this.changes.push(change),
    refused: () => {},
  });

  constructor() {
    this.session.open();
    this.session.receive(welcome);
  }

  last(): Change {
    return this.changes[this.changes.length - 1];
  }

  /** Numbers of the cells that a page shows after all changes. */
  shown(): Set<number> {
    const shown = new Set<number>();
    for (const { batch } of this.changes) {
      if (batch.startsOver) shown.clear();
      for (const number of batch.removed) assert.ok(shown.delete(number));
      for (let i = 0; i < batch.table.length; i += CELL_FIELDS) shown.add(batch.table[i]);
    }
    return shown;
  }
}

test('nothing changes before the last part of a transaction, and then all of it', () => {
  const peer = new Peer();
  peer.session.receive(cellsMessage([[1n, payloadOf(fakeCell(0))], [2n, payloadOf(fakeCell(9))]]));
  peer.session.receive(transactionMessage({ id: 1, isLast: false, added: [[7, 1n]] }));
  assert.equal(peer.changes.length, 0);
  peer.session.receive(transactionMessage({ id: 1, added: [[8, 2n]] }));
  assert.equal(peer.changes.length, 1);
  assert.equal(peer.last().transaction, 1n);
  assert.equal(peer.shown().size, 2);
  assert.equal(peer.last().batch.positions.length, 3 * 6);
  // a cell may be in both lists: it is another from now on
  peer.session.receive(transactionMessage({ id: 2, removed: [7, 8], added: [[7, 2n]] }));
  assert.equal(peer.shown().size, 1);
  peer.session.receive(transactionMessage({ id: 3, removed: [7] }));
  assert.equal(peer.shown().size, 0);
});

test('credits are given back for all that was taken', () => {
  const peer = new Peer();
  const credits = () =>
    peer.sent
      .filter((bytes) => bytes[0] === 5)
      .reduce((sum, bytes) => sum + new DataView(bytes.buffer).getUint32(8, true), 0);
  const first = credits();
  assert.ok(first >= 256 << 10);
  let taken = 0;
  for (let i = 0; i < 3000; ++i) {
    const message = cellsMessage([[BigInt(i), payloadOf(fakeCell(i))]]);
    peer.session.receive(message);
    taken += message.length;
  }
  assert.ok(taken > 200_000);
  assert.ok(credits() - first <= taken && credits() - first > taken - (128 << 10));
});

test('who comes back says what it holds, keeps its surface, and then starts over', () => {
  const peer = new Peer();
  const payload = payloadOf(fakeCell(0));
  peer.session.receive(cellsMessage([[1n, payload], [2n, payloadOf(fakeCell(9))]]));
  peer.session.receive(transactionMessage({ id: 1, added: [[7, 1n], [8, 2n]], forgotten: [] }));
  peer.session.receive(transactionMessage({ id: 2, removed: [8], forgotten: [2n] }));
  peer.session.close();
  peer.sent.length = 0;
  peer.session.open();
  const hello = new DataView(peer.sent[0].buffer);
  assert.equal(hello.getUint32(12, true), 1);
  assert.equal(hello.getBigUint64(16, true), 1n);
  assert.equal(hello.getUint32(24, true), payload.length);
  peer.session.receive(welcome);
  assert.equal(peer.shown().size, 1);
  peer.session.receive(transactionMessage({ id: 1, added: [[5, 1n], [6, 1n]] }));
  assert.ok(peer.last().batch.startsOver);
  assert.equal(peer.shown().size, 2);
});

test('wishes are said again to a service that was away', () => {
  const peer = new Peer();
  peer.session.setIsovalue(3);
  peer.session.close();
  peer.session.setFocus([{ low: [0, 0, 0], high: [0, 0, 0], radius: 1, error: 1, falloff: 1 }]);
  peer.sent.length = 0;
  peer.session.open();
  assert.deepEqual(peer.sent.map((bytes) => bytes[0]), [1, 5, 3, 4]);
});

test('floats count from the eye once fine cells are far from where they counted', () => {
  const peer = new Peer();
  const far = { width: 9, height: 9, forward: [0, 0, 1], up: [0, 1, 0], fieldOfView: 1, pixelError: 1 } as const;
  peer.session.setView({ ...far, eye: [5, 8, 15] });
  peer.session.receive(cellsMessage([[1n, payloadOf(fakeCell(0))], [2n, payloadOf(fakeCell(3, 1))]]));
  peer.session.receive(transactionMessage({ id: 1, added: [[7, 1n]] }));
  const before = peer.last().anchor;
  peer.session.receive(transactionMessage({ id: 2, added: [[8, 2n]] }));
  const { anchor, batch } = peer.last();
  assert.notDeepEqual(anchor, before);
  assert.ok(batch.startsOver);
  assert.equal(batch.table.length, 2 * CELL_FIELDS);
  assert.equal(peer.shown().size, 2);
});

test('transactions that make no sense are refused', () => {
  assert.throws(() => new Peer().session.receive(transactionMessage({ id: 1, removed: [7] })), RangeError);
  assert.throws(() => new Peer().session.receive(transactionMessage({ id: 1, added: [[7, 1n]] })), RangeError);
});
