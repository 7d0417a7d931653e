/** Turns positions on the world's grid of 46 bits into floats, so that neighbours still agree. */
import type { CellMesh } from './payload';
import type { Vector, Welcome } from './protocol';

/** Vertices of the grid are `low * 2^15 + position * 2^exponent` of these to the domain's edge. */
const GRID_PER_EDGE = 2 ** 46;
const GRID_PER_LATTICE = 2 ** 15;

/** What of the welcome says where cells lie. */
export type Grid = Pick<Welcome, 'origin' | 'edge'>;

/**
 * Where floats begin to count: they are differences to this point of the grid. A vertex that two
 * cells share is the same number in both, is subtracted exactly and rounded once, and so is the
 * same float in both: no crack opens. Far from the anchor floats are coarse, so it follows the eye.
 */
export type Anchor = readonly [number, number, number]; // [grid units]

export function anchorAt(grid: Grid, field: Vector): Anchor {
  const units = (axis: 0 | 1 | 2) =>
    Math.round((field[axis] - grid.origin[axis]) * (GRID_PER_EDGE / grid.edge));
  return [units(0), units(1), units(2)];
}

export function fieldOf(grid: Grid, anchor: Anchor): Vector {
  const at = (axis: 0 | 1 | 2) => grid.origin[axis] + anchor[axis] * (grid.edge / GRID_PER_EDGE);
  return [at(0), at(1), at(2)];
}

/** How wide a cell is at most [field]: of 2^16 steps of its grid. */
export function cellSize(grid: Grid, exponent: number): number {
  return grid.edge * 2 ** (exponent + 15 - 46);
}

/** Floats that a mesh's vertices are written to, three a vertex, and two small numbers for looks. */
export interface PlacedVertices {
  readonly positions: Float32Array; // relative to the anchor [field]
  /** Four a vertex: octahedral normal (127 is 1), the cell's exponent, 0. */
  readonly shapes: Int8Array;
}

/**
 * Writes a cell's vertices from the one named `at` on.
 * @returns the box that they take: low and high of x, y and z [field, relative to the anchor]
 */
export function placeVertices(
  mesh: CellMesh,
  grid: Grid,
  anchor: Anchor,
  into: PlacedVertices,
  at: number,
): Float32Array {
  const { positions, shapes } = into;
  const step = 2 ** mesh.exponent;
  const unit = grid.edge / GRID_PER_EDGE;
  // all of these are whole numbers below 2^53, so exact
  const x = mesh.low[0] * GRID_PER_LATTICE - anchor[0];
  const y = mesh.low[1] * GRID_PER_LATTICE - anchor[1];
  const z = mesh.low[2] * GRID_PER_LATTICE - anchor[2];
  const box = new Float32Array([Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity]);
  for (let i = 0; i < mesh.vertexCount; ++i) {
    const from = 8 * i;
    const to = 3 * (at + i);
    positions[to] = (x + mesh.vertices.getUint16(from, true) * step) * unit;
    positions[to + 1] = (y + mesh.vertices.getUint16(from + 2, true) * step) * unit;
    positions[to + 2] = (z + mesh.vertices.getUint16(from + 4, true) * step) * unit;
    for (let axis = 0; axis < 3; ++axis) {
      const value = positions[to + axis];
      if (value < box[axis]) box[axis] = value;
      if (value > box[axis + 3]) box[axis + 3] = value;
    }
    shapes[4 * (at + i)] = mesh.vertices.getInt8(from + 6);
    shapes[4 * (at + i) + 1] = mesh.vertices.getInt8(from + 7);
    shapes[4 * (at + i) + 2] = mesh.exponent;
  }
  return box;
}
