/**
 * The messages of a scene's stream, version 1: docs/protocol.md says what each byte is, and
 * tests/server/vectors/messages.txt has one of each.
 */
import { ByteReader, ByteWriter } from './bytes';

export const PROTOCOL = 'isofront.v1';
const VERSION = 1;

export type Vector = readonly [number, number, number];

/** From where a surface is looked at, in world coordinates. */
export interface View {
  readonly width: number; // [px]
  readonly height: number; // [px]
  readonly eye: Vector;
  readonly forward: Vector;
  readonly up: Vector;
  readonly fieldOfView: number; // the whole vertical angle [rad]
  readonly pixelError: number; // [px]
}

/** Where more detail is wanted than the view needs. */
export interface Focus {
  readonly low: Vector;
  readonly high: Vector;
  readonly radius: number; // [world]
  readonly error: number; // [world]
  readonly falloff: number;
}

export interface HeldPayload {
  readonly hash: bigint;
  readonly bytes: number;
}

/** How the service counts space, and where a surface is best looked at. */
export interface Welcome {
  readonly type: 'welcome';
  readonly longestMessage: number;
  readonly origin: Vector;
  readonly edge: number;
  readonly worldFromField: readonly number[]; // three columns and a translation
  readonly isovalue: number;
  readonly low: Vector;
  readonly high: Vector;
  readonly eye: Vector;
  readonly target: Vector;
  readonly up: Vector;
}

export interface Payload {
  readonly hash: bigint;
  readonly bytes: Uint8Array;
}

export interface Cells {
  readonly type: 'cells';
  readonly payloads: Payload[];
}

export interface AddedCell {
  readonly cell: string;
  readonly hash: bigint;
}

export interface TransactionPart {
  readonly type: 'transaction';
  readonly isLast: boolean;
  readonly isSettled: boolean;
  readonly id: bigint;
  readonly isovalue: number;
  readonly pixelError: number;
  readonly milliseconds: number;
  readonly removed: string[];
  readonly added: AddedCell[];
  readonly forgotten: bigint[];
}

export interface StreamError {
  readonly type: 'error';
  readonly code: number;
  readonly text: string;
}

export type ServerMessage = Welcome | Cells | TransactionPart | StreamError;

// What the client says

export function encodeHello(cacheBytes: number, held: readonly HeldPayload[]): Uint8Array<ArrayBuffer> {
  const writer = new ByteWriter(16 + 12 * held.length);
  writer.u8(1, VERSION, 0, 0).u64(BigInt(cacheBytes)).u32(held.length);
  for (const payload of held) writer.u64(payload.hash).u32(payload.bytes);
  return writer.bytes;
}

export function encodeView(view: View): Uint8Array<ArrayBuffer> {
  return new ByteWriter(100)
    .u8(2, 0, 0, 0)
    .u32(view.width)
    .u32(view.height)
    .f64(...view.eye, ...view.forward, ...view.up, view.fieldOfView, view.pixelError).bytes;
}

export function encodeIsovalue(isovalue: number): Uint8Array<ArrayBuffer> {
  return new ByteWriter(16).u8(3).skip(7).f64(isovalue).bytes;
}

export function encodeFocus(focus: readonly Focus[]): Uint8Array<ArrayBuffer> {
  const writer = new ByteWriter(4 + 72 * focus.length).u8(4, focus.length, 0, 0);
  for (const one of focus)
    writer.f64(...one.low, ...one.high, one.radius, one.error, one.falloff);
  return writer.bytes;
}

export function encodeCredits(bytes: number): Uint8Array<ArrayBuffer> {
  return new ByteWriter(16).u8(5).skip(7).u64(BigInt(bytes)).bytes;
}

export function encodeAcknowledgement(transaction: bigint): Uint8Array<ArrayBuffer> {
  return new ByteWriter(16).u8(6).skip(7).u64(transaction).bytes;
}

// What the service says

const SERVER_TYPES = { welcome: 0x81, cells: 0x82, transaction: 0x83, error: 0xff };

/** Throws a RangeError if the bytes are no message of the protocol's. */
export function parseMessage(bytes: Uint8Array): ServerMessage {
  const reader = new ByteReader(bytes);
  const type = reader.u8();
  const message = parseBody(type, reader);
  if (reader.left !== 0) throw new RangeError(`a message of type ${type} is too long`);
  return message;
}

function parseBody(type: number, reader: ByteReader): ServerMessage {
  switch (type) {
    case SERVER_TYPES.welcome:
      return parseWelcome(reader);
    case SERVER_TYPES.cells:
      return parseCells(reader);
    case SERVER_TYPES.transaction:
      return parseTransaction(reader);
    case SERVER_TYPES.error:
      return parseError(reader);
    default:
      throw new RangeError(`there is no message of type ${type}`);
  }
}

function vector(reader: ByteReader): Vector {
  return [reader.f64(), reader.f64(), reader.f64()];
}

function parseWelcome(reader: ByteReader): Welcome {
  const version = reader.u8();
  if (version !== VERSION)
    throw new RangeError(`the service speaks version ${version}, this page ${VERSION}: reload it`);
  reader.u16();
  return {
    type: 'welcome',
    longestMessage: reader.u32(),
    origin: vector(reader),
    edge: reader.f64(),
    worldFromField: reader.f64s(12),
    isovalue: reader.f64(),
    low: vector(reader),
    high: vector(reader),
    eye: vector(reader),
    target: vector(reader),
    up: vector(reader),
  };
}

function parseCells(reader: ByteReader): Cells {
  reader.take(3);
  const count = reader.u32();
  const payloads: Payload[] = [];
  for (let i = 0; i < count; ++i) {
    const hash = reader.u64();
    payloads.push({ hash, bytes: reader.take(reader.u32()) });
  }
  return { type: 'cells', payloads };
}

/** A cell's name of 13 bytes, as a text that is quick to compare. */
function cellName(reader: ByteReader): string {
  return `${reader.u32()},${reader.u32()},${reader.u32()},${reader.u8()}`;
}

function parseTransaction(reader: ByteReader): TransactionPart {
  const flags = reader.u8();
  reader.u16();
  const removedCount = reader.u32();
  const addedCount = reader.u32();
  const forgottenCount = reader.u32();
  const id = reader.u64();
  const [isovalue, pixelError, milliseconds] = reader.f64s(3);
  const removed: string[] = [];
  for (let i = 0; i < removedCount; ++i) removed.push(cellName(reader));
  const added: AddedCell[] = [];
  for (let i = 0; i < addedCount; ++i) added.push({ cell: cellName(reader), hash: reader.u64() });
  const forgotten: bigint[] = [];
  for (let i = 0; i < forgottenCount; ++i) forgotten.push(reader.u64());
  return {
    type: 'transaction',
    isLast: (flags & 1) !== 0,
    isSettled: (flags & 2) !== 0,
    id,
    isovalue,
    pixelError,
    milliseconds,
    removed,
    added,
    forgotten,
  };
}

function parseError(reader: ByteReader): StreamError {
  const code = reader.u8();
  reader.u16();
  const text = new TextDecoder().decode(reader.take(reader.u32()));
  return { type: 'error', code, text };
}
