/** What a cell's payload holds: docs/protocol.md, "Payloads". */
import { ByteReader } from './bytes';

/** What decodes meshoptimizer's streams: the part of three's MeshoptDecoder that is needed. */
export interface MeshCodec {
  decodeVertexBuffer(target: Uint8Array, count: number, size: number, source: Uint8Array): void;
  decodeIndexBuffer(target: Uint8Array, count: number, size: number, source: Uint8Array): void;
}

/** The triangles of one cell, on the world's grid. */
export interface CellMesh {
  readonly low: readonly [number, number, number]; // [2^-31 of the domain's edge]
  readonly exponent: number; // positions are multiples of 2^exponent grid units
  readonly vertexCount: number;
  /** Eight bytes a vertex: three u16 of position, two i8 of octahedral normal. */
  readonly vertices: DataView;
  /** Colours, a word a vertex, if there are any. */
  readonly colours: Uint32Array | null;
  readonly indices: Uint16Array;
}

const VERTEX_BYTES = 8;
const HEADER_BYTES = 24;
/** The index codec takes at least a byte a triangle, so that no header asks for endless memory. */
const MOST_INDICES = 1 << 24;

/** Throws if the bytes are no payload. */
export function decodePayload(bytes: Uint8Array, codec: MeshCodec): CellMesh {
  if (bytes.length < HEADER_BYTES) throw new RangeError('a payload ends too early');
  const reader = new ByteReader(bytes);
  const low = [reader.u32(), reader.u32(), reader.u32()] as const;
  const exponent = reader.u8();
  const hasAttributes = reader.u8() === 1;
  const vertexCount = reader.u16();
  const indexBytes = reader.u32();
  const indexCount = 3 * reader.u32();
  if (indexCount > Math.min(3 * indexBytes, MOST_INDICES) || exponent < 1 || exponent > 32)
    throw new RangeError("a payload's header makes no sense");

  const indices = new Uint16Array(indexCount);
  codec.decodeIndexBuffer(bytesOf(indices), indexCount, 2, reader.take(indexBytes));
  for (const index of indices)
    if (index >= vertexCount) throw new RangeError("a triangle names a vertex that isn't there");

  const vertices = new Uint8Array(vertexCount * VERTEX_BYTES);
  const shapeBytes = hasAttributes ? reader.u32() : reader.left;
  codec.decodeVertexBuffer(vertices, vertexCount, VERTEX_BYTES, reader.take(shapeBytes));
  let colours: Uint32Array | null = null;
  if (hasAttributes) {
    colours = new Uint32Array(vertexCount);
    codec.decodeVertexBuffer(bytesOf(colours), vertexCount, 4, reader.take(reader.left));
  }
  return { low, exponent, vertexCount, vertices: new DataView(vertices.buffer), colours, indices };
}

function bytesOf(array: Uint16Array | Uint32Array): Uint8Array {
  return new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
}
