/** One conversation after another about the surface of a scene, without the transport. */
import { type Batch, BOX_FIELDS, CELL_FIELDS } from './batch';
import { type CellMesh, decodePayload, type MeshCodec } from './payload';
import { type Anchor, anchorAt, cellSize, fieldOf, placeVertices } from './placement';
import {
  encodeAcknowledgement,
  encodeCredits,
  encodeFocus,
  encodeHello,
  encodeIsovalue,
  encodeView,
  type Focus,
  parseMessage,
  type TransactionPart,
  type Vector,
  type View,
  type Welcome,
} from './protocol';
import { toField } from './transform';

/** Payloads kept beyond those on show, for what comes back into view [bytes]. */
const CACHE_BYTES = 32 << 20;
/** On their way at most [bytes]: what is sent while the first of it is being decoded. */
const CREDIT_BYTES = 4 << 20;
/** Taken before the service is told that there is room again [bytes]. */
const CREDIT_STEP = 128 << 10;
/** Finest cells to an anchor's distance: floats there have a 2^11th of such a cell. */
const ANCHOR_REACH = 2 ** 13;

/** The surface has changed: all of it is to be shown at once. */
export interface Change {
  readonly transaction: bigint;
  readonly batch: Batch;
  /** Where the positions count from [field]. */
  readonly anchor: Vector;
  readonly isovalue: number;
  readonly pixelError: number; // [px]
  readonly milliseconds: number; // since the last change of wishes, as the service sees it
  readonly isSettled: boolean;
}

export interface SessionOutput {
  send(bytes: Uint8Array<ArrayBuffer>): void;
  welcomed(welcome: Welcome): void;
  changed(change: Change): void;
  /** The service has refused to go on. */
  refused(why: string): void;
}

interface ShownCell {
  readonly number: number;
  readonly hash: bigint;
  readonly exponent: number;
}

export class Session {
  private view: View | null = null;
  private isovalue: number | null = null;
  private focus: readonly Focus[] = [];

  private isOpen = false;
  private isNew = true; // nothing has been shown of this conversation
  private welcome: Welcome | null = null;
  private anchor: Anchor = [0, 0, 0];
  private readonly payloads = new Map<bigint, Uint8Array>();
  private readonly shown = new Map<string, ShownCell>();
  private readonly exponents = new Uint32Array(33); // how many cells are shown of each
  private nextNumber = 0;
  private parts: TransactionPart[] = [];
  private taken = 0; // credits to be given anew [bytes]

  constructor(
    private readonly codec: MeshCodec,
    private readonly output: SessionOutput,
  ) {}

  /** Begins a conversation: the surface on show stays until the new one is there. */
  open(): void {
    this.isOpen = true;
    this.isNew = true;
    this.parts = [];
    this.taken = 0;
    const held = [...this.payloads].map(([hash, bytes]) => ({ hash, bytes: bytes.length }));
    this.output.send(encodeHello(CACHE_BYTES, held));
    this.output.send(encodeCredits(CREDIT_BYTES));
    if (this.isovalue !== null) this.output.send(encodeIsovalue(this.isovalue));
    if (this.focus.length > 0) this.output.send(encodeFocus(this.focus));
    if (this.view) this.output.send(encodeView(this.view));
  }

  /** The conversation has ended; there may be another. */
  close(): void {
    this.isOpen = false;
  }

  /** Has nothing any more that the service could count on. */
  forgetPayloads(): void {
    this.payloads.clear();
  }

  setView(view: View): void {
    this.view = view;
    if (this.isOpen) this.output.send(encodeView(view));
  }

  setIsovalue(isovalue: number): void {
    this.isovalue = isovalue;
    if (this.isOpen) this.output.send(encodeIsovalue(isovalue));
  }

  setFocus(focus: readonly Focus[]): void {
    this.focus = focus;
    if (this.isOpen) this.output.send(encodeFocus(focus));
  }

  /** The change of this transaction is on show. */
  acknowledge(transaction: bigint): void {
    if (this.isOpen) this.output.send(encodeAcknowledgement(transaction));
  }

  /** Takes a message of the service's. Throws if it makes no sense. */
  receive(bytes: Uint8Array): void {
    const message = parseMessage(bytes);
    switch (message.type) {
      case 'welcome':
        if (!this.welcome) this.anchor = anchorAt(message, middle(message));
        this.welcome = message;
        this.output.welcomed(message);
        return;
      case 'cells':
        // copied: a part would keep all of its message
        for (const payload of message.payloads) this.payloads.set(payload.hash, payload.bytes.slice());
        this.giveCredits(bytes.length);
        return;
      case 'transaction':
        this.parts.push(message);
        this.giveCredits(bytes.length);
        if (message.isLast) this.apply(message);
        return;
      case 'error':
        this.output.refused(message.text);
    }
  }

  private giveCredits(bytes: number): void {
    this.taken += bytes;
    if (this.taken < CREDIT_STEP) return;
    this.output.send(encodeCredits(this.taken));
    this.taken = 0;
  }

  private apply(last: TransactionPart): void {
    const welcome = this.welcome;
    if (!welcome) throw new RangeError('a transaction came before the welcome');
    const parts = this.parts;
    this.parts = [];
    const startsOver = this.isNew;
    this.isNew = false;
    if (startsOver) {
      this.shown.clear();
      this.exponents.fill(0);
    }
    const removed: number[] = [];
    for (const part of parts)
      for (const cell of part.removed) {
        const was = this.shown.get(cell);
        if (!was) throw new RangeError("a transaction removes a cell that isn't shown");
        removed.push(was.number);
        --this.exponents[was.exponent];
        this.shown.delete(cell);
      }
    const added: [number, CellMesh][] = [];
    for (const part of parts)
      for (const { cell, hash } of part.added) {
        const mesh = this.decode(hash);
        const number = this.nextNumber++;
        this.shown.set(cell, { number, hash, exponent: mesh.exponent });
        ++this.exponents[mesh.exponent];
        added.push([number, mesh]);
      }
    const moved = this.moveAnchor(welcome);
    const batch = moved
      ? this.pack(this.allShown(), [], true)
      : this.pack(added, removed, startsOver);
    for (const part of parts) for (const hash of part.forgotten) this.payloads.delete(hash);
    this.output.changed({
      transaction: last.id,
      batch,
      anchor: fieldOf(welcome, this.anchor),
      isovalue: last.isovalue,
      pixelError: last.pixelError,
      milliseconds: last.milliseconds,
      isSettled: last.isSettled,
    });
  }

  private decode(hash: bigint): CellMesh {
    const bytes = this.payloads.get(hash);
    if (!bytes) throw new RangeError('a transaction shows a cell that was never sent');
    return decodePayload(bytes, this.codec);
  }

  private allShown(): [number, CellMesh][] {
    return [...this.shown.values()].map(({ number, hash }) => [number, this.decode(hash)]);
  }

  /** @returns whether floats count from another place now */
  private moveAnchor(welcome: Welcome): boolean {
    const finest = this.exponents.findIndex((count) => count > 0);
    if (!this.view || finest < 0) return false;
    const eye = toField(welcome.worldFromField, this.view.eye);
    const from = fieldOf(welcome, this.anchor);
    const distance = Math.hypot(eye[0] - from[0], eye[1] - from[1], eye[2] - from[2]);
    if (distance <= ANCHOR_REACH * cellSize(welcome, finest)) return false;
    const anchor = anchorAt(welcome, eye);
    // beyond the grid's numbers differences would not be exact
    if (anchor.some((units) => Math.abs(units) > 2 ** 52)) return false;
    this.anchor = anchor;
    return true;
  }

  private pack(cells: [number, CellMesh][], removed: number[], startsOver: boolean): Batch {
    const welcome = this.welcome as Welcome;
    let vertexCount = 0;
    let indexCount = 0;
    let hasColours = false;
    for (const [, mesh] of cells) {
      vertexCount += mesh.vertexCount;
      indexCount += mesh.indices.length;
      hasColours ||= mesh.colours !== null;
    }
    const batch = {
      startsOver,
      removed: new Uint32Array(removed),
      table: new Uint32Array(CELL_FIELDS * cells.length),
      boxes: new Float32Array(BOX_FIELDS * cells.length),
      positions: new Float32Array(3 * vertexCount),
      shapes: new Int8Array(4 * vertexCount),
      colours: hasColours ? new Uint32Array(vertexCount) : null,
      indices: new Uint16Array(indexCount),
    };
    let vertex = 0;
    let index = 0;
    cells.forEach(([number, mesh], i) => {
      batch.table.set([number, mesh.vertexCount, mesh.indices.length, mesh.exponent], CELL_FIELDS * i);
      batch.boxes.set(placeVertices(mesh, welcome, this.anchor, batch, vertex), BOX_FIELDS * i);
      if (mesh.colours) batch.colours?.set(mesh.colours, vertex);
      batch.indices.set(mesh.indices, index);
      vertex += mesh.vertexCount;
      index += mesh.indices.length;
    });
    return batch;
  }
}

function middle(welcome: Welcome): Vector {
  const at = (axis: 0 | 1 | 2) => (welcome.low[axis] + welcome.high[axis]) / 2;
  return toField(welcome.worldFromField, [at(0), at(1), at(2)]);
}
