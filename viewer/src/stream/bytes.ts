/** Reads little-endian numbers that lie behind each other; throws where they end too early. */
export class ByteReader {
  private readonly view: DataView;
  private at = 0;

  constructor(private readonly bytes: Uint8Array) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  get left(): number {
    return this.bytes.length - this.at;
  }

  u8(): number {
    return this.view.getUint8(this.advance(1));
  }

  u16(): number {
    return this.view.getUint16(this.advance(2), true);
  }

  u32(): number {
    return this.view.getUint32(this.advance(4), true);
  }

  u64(): bigint {
    return this.view.getBigUint64(this.advance(8), true);
  }

  f64(): number {
    return this.view.getFloat64(this.advance(8), true);
  }

  f64s(count: number): number[] {
    return Array.from({ length: count }, () => this.f64());
  }

  /** Not copied. */
  take(count: number): Uint8Array {
    const begin = this.advance(count);
    return this.bytes.subarray(begin, begin + count);
  }

  private advance(count: number): number {
    if (count > this.left) throw new RangeError('a message ends too early');
    const begin = this.at;
    this.at += count;
    return begin;
  }
}

/** Writes little-endian numbers behind each other. */
export class ByteWriter {
  private readonly view: DataView;
  private at = 0;

  constructor(bytes: number) {
    this.view = new DataView(new ArrayBuffer(bytes));
  }

  u8(...values: number[]): this {
    for (const value of values) this.view.setUint8(this.at++, value);
    return this;
  }

  u32(value: number): this {
    this.view.setUint32(this.at, value, true);
    this.at += 4;
    return this;
  }

  u64(value: bigint): this {
    this.view.setBigUint64(this.at, value, true);
    this.at += 8;
    return this;
  }

  f64(...values: number[]): this {
    for (const value of values) {
      this.view.setFloat64(this.at, value, true);
      this.at += 8;
    }
    return this;
  }

  skip(count: number): this {
    this.at += count;
    return this;
  }

  get bytes(): Uint8Array<ArrayBuffer> {
    return new Uint8Array(this.view.buffer as ArrayBuffer, 0, this.at);
  }
}
