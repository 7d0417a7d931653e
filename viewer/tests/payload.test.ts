import assert from 'node:assert/strict';
import { test } from 'node:test';
import { decodePayload } from '../src/stream/payload';
import { anchorAt, fieldOf, placeVertices } from '../src/stream/placement';
import { toField, toWorld } from '../src/stream/transform';
import { type FakeCell, payloadOf, plainCodec } from './fake-cells';
import { random } from './random';

const cell: FakeCell = {
  low: [1, 2 ** 30, 3],
  exponent: 9,
  positions: [
    [0, 0, 0],
    [32768, 1, 2],
    [5, 32768, 65535],
  ],
  triangles: [
    [0, 1, 2],
    [2, 1, 0],
  ],
};

test('payloads are read', () => {
  const mesh = decodePayload(payloadOf(cell), plainCodec);
  assert.deepEqual([mesh.low, mesh.exponent, mesh.vertexCount], [[1, 2 ** 30, 3], 9, 3]);
  assert.deepEqual([...mesh.indices], [0, 1, 2, 2, 1, 0]);
  assert.equal(mesh.vertices.getUint16(8 * 2 + 4, true), 65535);
  assert.equal(mesh.vertices.getInt8(6), -5);
  assert.equal(mesh.colours, null);
});

test('payloads that are cut are refused', () => {
  const bytes = payloadOf(cell);
  for (let size = 0; size < bytes.length; ++size)
    assert.throws(() => decodePayload(bytes.subarray(0, size), plainCodec), RangeError, `${size}`);
});

test('triangles of vertices that are not there are refused', () => {
  const bad = { ...cell, triangles: [[0, 1, 3]] as [number, number, number][] };
  assert.throws(() => decodePayload(payloadOf(bad), plainCodec), /isn't there/);
});

test('headers that ask for endless memory are refused', () => {
  const bytes = payloadOf(cell);
  new DataView(bytes.buffer).setUint32(20, 2 ** 31, true);
  assert.throws(() => decodePayload(bytes, plainCodec), /makes no sense/);
});

test('cells of all sizes have the same floats for a vertex that they share', () => {
  const next = random(1);
  const grid = { origin: [-3, 0.1, 1e4] as const, edge: 12345.678 };
  for (let trial = 0; trial < 500; ++trial) {
    // a point of the grid, seen from a coarse cell and from a fine one
    const coarse = 8 + Math.floor(next() * 8);
    const fine = 1 + Math.floor(next() * (coarse - 1));
    const axis = () => {
      const low = Math.floor(next() * 2 ** 20) * 2 ** 10;
      const step = Math.floor(next() * 2 ** 5);
      // the low corner of the fine cell is nearer to the point, by whole lattice units
      const units = step * 2 ** coarse;
      const fineLow = low + Math.floor(units / 2 ** 15);
      return { low, step, fineLow, fineStep: (units % 2 ** 15) / 2 ** fine };
    };
    const axes = [axis(), axis(), axis()];
    const mesh = (lows: number[], steps: number[], exponent: number) =>
      decodePayload(
        payloadOf({
          low: lows as [number, number, number],
          exponent,
          positions: [steps as [number, number, number]],
          triangles: [[0, 0, 0]],
        }),
        plainCodec,
      );
    const anchor = anchorAt(grid, [next() * 1e4, next() * 1e4, next() * 1e4]);
    const placed = (cellMesh: ReturnType<typeof mesh>) => {
      const into = { positions: new Float32Array(3), shapes: new Int8Array(4) };
      placeVertices(cellMesh, grid, anchor, into, 0);
      return [...into.positions];
    };
    assert.deepEqual(
      placed(mesh(axes.map((one) => one.low), axes.map((one) => one.step), coarse)),
      placed(mesh(axes.map((one) => one.fineLow), axes.map((one) => one.fineStep), fine)),
    );
  }
});

test('positions are where they are in the field, and boxes hold them', () => {
  const grid = { origin: [10, 20, 30] as const, edge: 2 ** 46 };
  const anchor = anchorAt(grid, [11, 22, 33]);
  assert.deepEqual(fieldOf(grid, anchor), [11, 22, 33]);
  const mesh = decodePayload(
    payloadOf({ low: [1, 0, 2], exponent: 2, positions: [[1, 2, 3], [4, 0, 9]], triangles: [[0, 1, 0]] }),
    plainCodec,
  );
  const into = { positions: new Float32Array(6), shapes: new Int8Array(8) };
  const box = placeVertices(mesh, grid, anchor, into, 0);
  const expected = [32768 + 4 - 1, 8 - 2, 65536 + 12 - 3, 32768 + 16 - 1, -2, 65536 + 36 - 3];
  assert.deepEqual([...into.positions], expected);
  assert.deepEqual([...box], [32771, -2, 65545, 32783, 6, 65569]);
});

test('field and world lead to each other', () => {
  const m = [1, 0.5, 0, -0.25, 2, 0.125, 0, 1, -3, 100, 200, 300];
  const next = random(2);
  for (let trial = 0; trial < 100; ++trial) {
    const point = [next(), next() * 10, next() * 100] as const;
    toField(m, toWorld(m, point)).forEach((value, axis) =>
      assert.ok(Math.abs(value - point[axis]) < 1e-10),
    );
  }
});
