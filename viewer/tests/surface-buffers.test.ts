import assert from 'node:assert/strict';
import { test } from 'node:test';
import { RangeAllocator } from '../src/scene/range-allocator';
import { SurfaceBuffers } from '../src/scene/surface-buffers';
import type { Batch } from '../src/stream/batch';
import { random } from './random';

test('ranges never overlap, and what is free is used again', () => {
  const next = random(3);
  const allocator = new RangeAllocator();
  const ranges: [number, number][] = [];
  for (let step = 0; step < 2000; ++step) {
    if (next() < 0.55 && ranges.length < 200) {
      const count = 1 + Math.floor(next() * 40);
      const begin = allocator.allocate(count);
      assert.ok(ranges.every(([other, size]) => begin + count <= other || other + size <= begin));
      ranges.push([begin, count]);
    } else if (ranges.length > 0) {
      const [range] = ranges.splice(Math.floor(next() * ranges.length), 1);
      allocator.free(...range);
    }
    const end = Math.max(0, ...ranges.map(([begin, count]) => begin + count));
    assert.equal(allocator.end, end);
    assert.equal(allocator.used, ranges.reduce((sum, [, count]) => sum + count, 0));
  }
  for (const range of ranges) allocator.free(...range);
  assert.equal(allocator.end, 0);
  assert.equal(allocator.allocate(5), 0);
});

type Triangle = number[];

/** Cells of one triangle to ten, of vertices of their own. */
function batchOf(next: () => number, numbers: number[], removed: number[], startsOver: boolean) {
  const triangles = new Map<number, Triangle[]>();
  const positions: number[] = [];
  const indices: number[] = [];
  const table: number[] = [];
  const boxes: number[] = [];
  for (const number of numbers) {
    const count = 1 + Math.floor(next() * 10);
    const mine = Array.from({ length: count }, () => Array.from({ length: 9 }, () => Math.fround(next())));
    triangles.set(number, mine);
    positions.push(...mine.flat());
    indices.push(...Array.from({ length: 3 * count }, (_, i) => i));
    table.push(number, 3 * count, 3 * count, 20);
    const axis = (a: number) => mine.flat().filter((_, i) => i % 3 === a);
    boxes.push(...[0, 1, 2].map((a) => Math.min(...axis(a))), ...[0, 1, 2].map((a) => Math.max(...axis(a))));
  }
  const batch: Batch = {
    startsOver,
    removed: new Uint32Array(removed),
    table: new Uint32Array(table),
    boxes: new Float32Array(boxes),
    positions: new Float32Array(positions),
    shapes: new Int8Array((positions.length / 3) * 4),
    colours: null,
    indices: new Uint16Array(indices),
  };
  return { batch, triangles };
}

/** What the device would draw, without triangles that have no area. */
function drawn(buffers: SurfaceBuffers): Triangle[] {
  const { geometry } = buffers;
  const positions = geometry.attributes.position.array;
  const index = geometry.index?.array as Uint32Array;
  const triangles: Triangle[] = [];
  for (let i = 0; i < geometry.drawRange.count; i += 3) {
    if (index[i] === index[i + 1]) continue;
    triangles.push([0, 1, 2].flatMap((corner) => [...positions.slice(3 * index[i + corner], 3 * index[i + corner] + 3)]));
  }
  return triangles;
}

const sorted = (triangles: Triangle[]) => triangles.map((one) => one.join()).sort().join(' ');

test('what is drawn is always just the cells on show', () => {
  const next = random(4);
  const buffers = new SurfaceBuffers();
  const shown = new Map<number, Triangle[]>();
  let number = 0;
  for (let step = 0; step < 40; ++step) {
    const startsOver = next() < 0.1;
    const removed = startsOver ? [] : [...shown.keys()].filter(() => next() < 0.3);
    const added = Array.from({ length: Math.floor(next() * 40) }, () => ++number);
    const { batch, triangles } = batchOf(next, added, removed, startsOver);
    if (startsOver) shown.clear();
    for (const one of removed) shown.delete(one);
    for (const [one, its] of triangles) shown.set(one, its);
    buffers.apply(batch);
    const expected = [...shown.values()].flat();
    assert.equal(buffers.triangleCount, expected.length);
    assert.ok(sorted(drawn(buffers)) === sorted(expected));
  }
});

test('what changed is uploaded', () => {
  const next = random(5);
  const buffers = new SurfaceBuffers();
  buffers.apply(batchOf(next, [1, 2, 3], [], false).batch);
  const index = () => buffers.geometry.index as NonNullable<typeof buffers.geometry.index>;
  index().clearUpdateRanges();
  const before = index().array.slice();
  const version = index().version;
  buffers.apply(batchOf(next, [4], [2], false).batch);
  assert.ok(index().version > version);
  index().array.forEach((value, i) => {
    const isUploaded = index().updateRanges.some((range) => i >= range.start && i < range.start + range.count);
    assert.ok(isUploaded || value === before[i]);
  });
});

test('a ray meets the nearest triangle, as if all were tried', () => {
  const next = random(6);
  const buffers = new SurfaceBuffers();
  const { batch, triangles } = batchOf(next, Array.from({ length: 60 }, (_, i) => i), [], false);
  buffers.apply(batch);
  let hits = 0;
  for (let trial = 0; trial < 100; ++trial) {
    const from = [next() * 4 - 2, next() * 4 - 2, next() * 4 - 2];
    const direction = from.map((value) => (next() - value) * 0.5);
    const nearest = Math.min(...[...triangles.values()].flat().map((one) => hit(from, direction, one)));
    const found = buffers.raycast(from, direction);
    assert.equal(found === null, nearest === Infinity);
    if (found === null) continue;
    ++hits;
    assert.ok(Math.abs(found - nearest) < 1e-9);
  }
  assert.ok(hits > 50);
  assert.equal(buffers.raycast([2, 2, 2], [1, 1, 1]), null);
});

/** By the plane, and then by the signs of areas: another way than what is tested. */
function hit(from: number[], direction: number[], t: Triangle): number {
  const [a, b, c] = [t.slice(0, 3), t.slice(3, 6), t.slice(6, 9)];
  const minus = (p: number[], q: number[]) => p.map((value, i) => value - q[i]);
  const cross = (p: number[], q: number[]) => [
    p[1] * q[2] - p[2] * q[1],
    p[2] * q[0] - p[0] * q[2],
    p[0] * q[1] - p[1] * q[0],
  ];
  const dot = (p: number[], q: number[]) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  const normal = cross(minus(b, a), minus(c, a));
  const along = dot(minus(a, from), normal) / dot(direction, normal);
  if (!(along > 0)) return Infinity;
  const at = from.map((value, i) => value + along * direction[i]);
  const isInside = [[a, b], [b, c], [c, a]].every(
    ([p, q]) => dot(cross(minus(q, p), minus(at, p)), normal) >= 0,
  );
  return isInside ? along : Infinity;
}
