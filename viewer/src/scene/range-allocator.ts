/** Hands out ranges of an array, and takes them back: first fit, neighbours joined. */
export class RangeAllocator {
  /** Free ranges below `end`, by where they begin; none touches another. */
  private begins: number[] = [];
  private counts: number[] = [];
  private highest = 0;
  private inUse = 0;

  /** Behind the last element in use. */
  get end(): number {
    return this.highest;
  }

  get used(): number {
    return this.inUse;
  }

  /** @returns where the range begins; it may lie beyond what the array has by now. */
  allocate(count: number): number {
    this.inUse += count;
    for (let i = 0; i < this.counts.length; ++i) {
      if (this.counts[i] < count) continue;
      const begin = this.begins[i];
      this.begins[i] += count;
      this.counts[i] -= count;
      if (this.counts[i] === 0) this.drop(i);
      return begin;
    }
    const begin = this.highest;
    this.highest += count;
    return begin;
  }

  free(begin: number, count: number): void {
    if (count === 0) return;
    this.inUse -= count;
    let i = this.indexBehind(begin);
    this.begins.splice(i, 0, begin);
    this.counts.splice(i, 0, count);
    if (i > 0 && this.begins[i - 1] + this.counts[i - 1] === begin) {
      this.counts[i - 1] += count;
      this.drop(i);
      --i;
    }
    if (i + 1 < this.begins.length && this.begins[i] + this.counts[i] === this.begins[i + 1]) {
      this.counts[i] += this.counts[i + 1];
      this.drop(i + 1);
    }
    if (this.begins[i] + this.counts[i] === this.highest) {
      this.highest = this.begins[i];
      this.drop(i);
    }
  }

  clear(): void {
    this.begins = [];
    this.counts = [];
    this.highest = 0;
    this.inUse = 0;
  }

  private drop(i: number): void {
    this.begins.splice(i, 1);
    this.counts.splice(i, 1);
  }

  private indexBehind(begin: number): number {
    let low = 0;
    let high = this.begins.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.begins[middle] < begin) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
