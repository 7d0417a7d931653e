/** Payloads whose streams are not coded, and what takes them for decoded. */
import { ByteWriter } from '../src/stream/bytes';
import type { MeshCodec } from '../src/stream/payload';

export const plainCodec: MeshCodec = {
  decodeVertexBuffer: copy,
  decodeIndexBuffer: copy,
};

function copy(target: Uint8Array, count: number, size: number, source: Uint8Array): void {
  if (source.length !== count * size) throw new RangeError('not as long as it must be');
  target.set(source);
}

export interface FakeCell {
  low: [number, number, number];
  exponent: number;
  positions: [number, number, number][];
  triangles: [number, number, number][];
}

export function payloadOf(cell: FakeCell): Uint8Array {
  const indices = new Uint16Array(cell.triangles.flat());
  const writer = new ByteWriter(24);
  writer.u32(cell.low[0]).u32(cell.low[1]).u32(cell.low[2]).u8(cell.exponent, 0);
  writer.u8(cell.positions.length & 255, cell.positions.length >> 8);
  writer.u32(2 * indices.length).u32(cell.triangles.length);
  const vertices = new DataView(new ArrayBuffer(8 * cell.positions.length));
  cell.positions.forEach((position, i) => {
    position.forEach((value, axis) => vertices.setUint16(8 * i + 2 * axis, value, true));
    vertices.setInt8(8 * i + 6, i - 5);
    vertices.setInt8(8 * i + 7, 7);
  });
  return Uint8Array.of(
    ...writer.bytes,
    ...new Uint8Array(indices.buffer),
    ...new Uint8Array(vertices.buffer),
  );
}
