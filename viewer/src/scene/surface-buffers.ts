/** The triangles of all cells on show, in a few large arrays that are drawn at once. */
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Sphere } from 'three';
import { type Batch, BOX_FIELDS, CELL_FIELDS } from '../stream/batch';
import { RangeAllocator } from './range-allocator';

const LEAST_CAPACITY = 1 << 14;
/** More parts than this are uploaded as one. */
const MOST_UPDATES = 64;

interface Cell {
  readonly vertex: number;
  readonly vertexCount: number;
  readonly index: number;
  readonly indexCount: number;
  /** Low and high [field, relative to the anchor]. */
  readonly box: Float32Array;
}

/**
 * Cells come and go in ranges of the arrays. What no cell has of the indices is zero: triangles
 * without area, which are never seen.
 */
export class SurfaceBuffers {
  readonly geometry = new BufferGeometry();
  private readonly cells = new Map<number, Cell>();
  private readonly vertices = new RangeAllocator();
  private readonly indices = new RangeAllocator();
  private positions = new Float32Array(0);
  private shapes = new Int8Array(0);
  private colours = new Uint32Array(0);
  private triangles = new Uint32Array(0);

  constructor() {
    // never culled as a whole, so nobody needs to look for its bounds
    this.geometry.boundingSphere = new Sphere(undefined, Infinity);
    this.makeAttributes(LEAST_CAPACITY, LEAST_CAPACITY);
  }

  get triangleCount(): number {
    return this.indices.used / 3;
  }

  get cellCount(): number {
    return this.cells.size;
  }

  apply(batch: Batch): void {
    if (batch.startsOver) this.clear();
    for (const number of batch.removed) this.remove(number);
    const added = batch.table.length / CELL_FIELDS;
    const places: Cell[] = [];
    for (let i = 0; i < added; ++i) {
      const [number, vertexCount, indexCount] = batch.table.subarray(CELL_FIELDS * i);
      const cell = {
        vertex: this.vertices.allocate(vertexCount),
        vertexCount,
        index: this.indices.allocate(indexCount),
        indexCount,
        box: batch.boxes.subarray(BOX_FIELDS * i, BOX_FIELDS * (i + 1)),
      };
      this.cells.set(number, cell);
      places.push(cell);
    }
    this.grow();
    let vertex = 0;
    let index = 0;
    for (const cell of places) {
      this.write(batch, cell, vertex, index);
      vertex += cell.vertexCount;
      index += cell.indexCount;
    }
    this.geometry.setDrawRange(0, this.indices.end);
  }

  dispose(): void {
    this.geometry.dispose();
  }

  /** All boxes of cells, for whom distances to the surface matter. */
  *boxes(): Iterable<Float32Array> {
    for (const cell of this.cells.values()) yield cell.box;
  }

  /**
   * Where a ray first meets a triangle.
   * @param from  [field, relative to the anchor], as is the direction, which may have any length
   * @returns how many times the direction it is away, or null
   */
  raycast(from: readonly number[], direction: readonly number[]): number | null {
    let nearest = Infinity;
    for (const cell of this.cells.values())
      if (entersBox(from, direction, cell.box, nearest))
        for (let i = cell.index; i < cell.index + cell.indexCount; i += 3)
          nearest = Math.min(nearest, this.meets(from, direction, i));
    return nearest === Infinity ? null : nearest;
  }

  private clear(): void {
    this.cells.clear();
    this.vertices.clear();
    this.triangles.fill(0, 0, this.indices.end);
    this.touch('index', 0, this.indices.end);
    this.indices.clear();
  }

  private remove(number: number): void {
    const cell = this.cells.get(number);
    if (!cell) return;
    this.cells.delete(number);
    this.vertices.free(cell.vertex, cell.vertexCount);
    this.indices.free(cell.index, cell.indexCount);
    this.triangles.fill(0, cell.index, cell.index + cell.indexCount);
    this.touch('index', cell.index, cell.indexCount);
  }

  private write(batch: Batch, cell: Cell, vertex: number, index: number): void {
    const end = vertex + cell.vertexCount;
    this.positions.set(batch.positions.subarray(3 * vertex, 3 * end), 3 * cell.vertex);
    this.shapes.set(batch.shapes.subarray(4 * vertex, 4 * end), 4 * cell.vertex);
    if (batch.colours) this.colours.set(batch.colours.subarray(vertex, end), cell.vertex);
    else this.colours.fill(0, cell.vertex, cell.vertex + cell.vertexCount);
    for (let i = 0; i < cell.indexCount; ++i)
      this.triangles[cell.index + i] = batch.indices[index + i] + cell.vertex;
    this.touch('position', 3 * cell.vertex, 3 * cell.vertexCount);
    this.touch('shape', 4 * cell.vertex, 4 * cell.vertexCount);
    this.touch('colour', 4 * cell.vertex, 4 * cell.vertexCount);
    this.touch('index', cell.index, cell.indexCount);
  }

  private grow(): void {
    const vertices = this.positions.length / 3;
    if (this.vertices.end <= vertices && this.indices.end <= this.triangles.length) return;
    this.makeAttributes(
      roomFor(this.vertices.end, vertices),
      roomFor(this.indices.end, this.triangles.length),
    );
  }

  private makeAttributes(vertices: number, indices: number): void {
    this.geometry.dispose(); // what the device has of the old ones
    this.positions = enlarged(this.positions, new Float32Array(3 * vertices));
    this.shapes = enlarged(this.shapes, new Int8Array(4 * vertices));
    this.colours = enlarged(this.colours, new Uint32Array(vertices));
    this.triangles = enlarged(this.triangles, new Uint32Array(indices));
    const put = (name: string, array: Float32Array | Int8Array | Uint8Array, size: number) =>
      this.geometry.setAttribute(
        name,
        new BufferAttribute(array, size, name === 'colour').setUsage(DynamicDrawUsage),
      );
    put('position', this.positions, 3);
    put('shape', this.shapes, 4);
    put('colour', new Uint8Array(this.colours.buffer), 4);
    this.geometry.setIndex(new BufferAttribute(this.triangles, 1).setUsage(DynamicDrawUsage));
  }

  /** To be uploaded before it is next drawn. */
  private touch(name: string, begin: number, count: number): void {
    const attribute = (
      name === 'index' ? this.geometry.index : this.geometry.attributes[name]
    ) as BufferAttribute;
    attribute.addUpdateRange(begin, count);
    if (attribute.updateRanges.length > MOST_UPDATES) {
      const low = Math.min(...attribute.updateRanges.map((range) => range.start));
      const high = Math.max(...attribute.updateRanges.map((range) => range.start + range.count));
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(low, high - low);
    }
    attribute.needsUpdate = true;
  }

  /** How far along the ray a triangle is, or infinity (Möller and Trumbore, both sides count). */
  private meets(from: readonly number[], direction: readonly number[], index: number): number {
    const p = this.positions;
    const a = 3 * this.triangles[index];
    const b = 3 * this.triangles[index + 1];
    const c = 3 * this.triangles[index + 2];
    const e = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]];
    const f = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
    const t = [from[0] - p[a], from[1] - p[a + 1], from[2] - p[a + 2]];
    const h = cross(direction, f);
    const volume = dot(e, h);
    if (volume === 0) return Infinity;
    const u = dot(t, h) / volume;
    const q = cross(t, e);
    const v = dot(direction, q) / volume;
    const distance = dot(f, q) / volume;
    return u >= 0 && v >= 0 && u + v <= 1 && distance > 0 ? distance : Infinity;
  }
}

/** A third more than needed, so that growing is rare. */
function roomFor(needed: number, present: number): number {
  return needed <= present ? present : Math.ceil((needed * 4) / 3);
}

function enlarged<T extends Float32Array | Int8Array | Uint32Array>(old: T, array: T): T {
  array.set(old);
  return array;
}

function entersBox(
  from: readonly number[],
  direction: readonly number[],
  box: Float32Array,
  nearest: number,
): boolean {
  let enter = 0;
  let leave = nearest;
  for (let axis = 0; axis < 3; ++axis) {
    const one = (box[axis] - from[axis]) / direction[axis];
    const other = (box[axis + 3] - from[axis]) / direction[axis];
    // a ray within a face gives NaN, which Math.min would spread
    if (Number.isNaN(one) || Number.isNaN(other)) continue;
    enter = Math.max(enter, Math.min(one, other));
    leave = Math.min(leave, Math.max(one, other));
  }
  return enter <= leave;
}

function cross(a: readonly number[], b: readonly number[]): number[] {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function dot(a: readonly number[], b: readonly number[]): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
