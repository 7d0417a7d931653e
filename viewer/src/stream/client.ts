/** One stream, as the page sees it: a worker that does the work. */
import type { Connection, FromWorker, ToWorker } from './messages';
import type { Focus, View, Welcome } from './protocol';
import type { Change } from './session';

export interface StreamEvents {
  connection(connection: Connection): void;
  welcome(welcome: Welcome): void;
  /** Puts the change on show, at once or soon; it is acknowledged on return. */
  change(change: Change, receivedBytes: number): void;
  refused(why: string): void;
}

export class StreamClient {
  private readonly worker = new Worker(new URL('./worker.ts', import.meta.url), { type: 'module' });

  constructor(url: string, token: string, events: StreamEvents) {
    this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      switch (data.type) {
        case 'connection':
          events.connection(data.connection);
          return;
        case 'welcome':
          events.welcome(data.welcome);
          return;
        case 'change':
          events.change(data.change, data.receivedBytes);
          this.tell({ type: 'shown', transaction: data.change.transaction });
          return;
        case 'refused':
          events.refused(data.why);
      }
    };
    this.worker.onerror = (event) =>
      events.refused(event.message || "the part of this page that decodes surfaces can't be loaded");
    this.tell({ type: 'open', url, token });
  }

  setView(view: View): void {
    this.tell({ type: 'view', view });
  }

  setIsovalue(isovalue: number): void {
    this.tell({ type: 'isovalue', isovalue });
  }

  setFocus(focus: readonly Focus[]): void {
    this.tell({ type: 'focus', focus });
  }

  close(): void {
    this.worker.terminate();
  }

  private tell(message: ToWorker): void {
    this.worker.postMessage(message);
  }
}
