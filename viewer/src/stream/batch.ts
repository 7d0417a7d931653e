/** What a transaction does to a mesh on show, packed so that it can be handed between threads. */

/** Numbers for each added cell in `table`. */
export const CELL_FIELDS = 4;
/** Numbers for each added cell in `boxes`: low and high. */
export const BOX_FIELDS = 6;

export interface Batch {
  /** Forget everything that was there: floats count from another anchor, or the stream began anew. */
  readonly startsOver: boolean;
  /** Cells to take away, by number. */
  readonly removed: Uint32Array<ArrayBuffer>;
  /** Of each cell to add: its number, vertices, indices, exponent. They lie behind each other below. */
  readonly table: Uint32Array<ArrayBuffer>;
  readonly boxes: Float32Array<ArrayBuffer>;
  readonly positions: Float32Array<ArrayBuffer>;
  readonly shapes: Int8Array<ArrayBuffer>;
  readonly colours: Uint32Array<ArrayBuffer> | null;
  /** Of vertices of the same cell. */
  readonly indices: Uint16Array<ArrayBuffer>;
}

/** All that may change hands rather than be copied. */
export function buffersOf(batch: Batch): ArrayBuffer[] {
  const buffers = [
    batch.removed.buffer,
    batch.table.buffer,
    batch.boxes.buffer,
    batch.positions.buffer,
    batch.shapes.buffer,
    batch.indices.buffer,
  ];
  if (batch.colours) buffers.push(batch.colours.buffer);
  return buffers;
}
