/** Holds a state that is replaced, never changed, and tells who wants to know. */
export class Store<T extends object> {
  private readonly listeners: ((state: T, before: T) => void)[] = [];

  constructor(private state: T) {}

  get(): T {
    return this.state;
  }

  set(change: Partial<T>): void {
    const before = this.state;
    this.state = { ...before, ...change };
    for (const listener of this.listeners) listener(this.state, before);
  }

  listen(listener: (state: T, before: T) => void): void {
    this.listeners.push(listener);
  }
}
