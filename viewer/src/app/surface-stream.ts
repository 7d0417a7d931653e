/** One isosurface: its stream, what is shown of it, and how far it is. */
import { StagedSurface, type Stage } from '../scene/stage';
import { StreamClient } from '../stream/client';
import type { Connection } from '../stream/messages';
import type { Focus, View, Welcome } from '../stream/protocol';
import type { Change } from '../stream/session';
import { Hold } from './hold';
import { throttled } from './throttle';

/** Between two views, and two isovalues, that are sent [ms]. */
const VIEW_PERIOD = 80;
const ISOVALUE_PERIOD = 30;
/** How long the surface of an older isovalue stays, to be replaced by all of the new one [ms]. */
const PATIENCE = 250;

export interface SurfaceStreamHost {
  readonly stage: Stage;
  /** Something is other than it was: what is shown, or how far it is. */
  changed(stream: SurfaceStream): void;
  welcomed(welcome: Welcome): void;
  connection(stream: SurfaceStream, connection: Connection): void;
  refused(why: string): void;
}

export class SurfaceStream {
  readonly surface = new StagedSurface();
  connection: Connection = 'connecting';
  isSettled = false;
  receivedBytes = 0;
  pixelError = 0;
  /** From the last wish to all of it being on show [ms]. */
  milliseconds = 0;
  private readonly client: StreamClient;
  private wished = performance.now();
  private view: View | null = null;
  private isovalue: number | null = null;
  private isIsovalueSent = false;

  private readonly hold = new Hold<Change>(PATIENCE, (change) => this.show(change));
  private readonly sendView = throttled(VIEW_PERIOD, () => this.view && this.client.setView(this.view));
  private readonly sendIsovalue = throttled(ISOVALUE_PERIOD, () => {
    this.isIsovalueSent = true;
    if (this.isovalue !== null) this.client.setIsovalue(this.isovalue);
  });

  constructor(
    url: string,
    token: string,
    private readonly host: SurfaceStreamHost,
  ) {
    host.stage.add(this.surface);
    this.client = new StreamClient(url, token, {
      connection: (connection) => {
        this.connection = connection;
        if (connection !== 'open') this.isSettled = false;
        host.connection(this, connection);
      },
      welcome: (welcome) => {
        this.surface.welcome = welcome;
        host.welcomed(welcome);
      },
      change: (change, receivedBytes) => {
        this.receivedBytes = receivedBytes;
        const isOnTheWay = change.isovalue !== this.surface.isovalue && !this.isComplete(change);
        this.hold.take(change, isOnTheWay && this.surface.buffers.triangleCount > 0);
      },
      refused: (why) => host.refused(why),
    });
  }

  setView(view: View): void {
    this.view = view;
    this.wish();
    this.sendView();
  }

  setIsovalue(isovalue: number): void {
    if (this.isovalue === isovalue) return;
    this.isovalue = isovalue;
    this.isIsovalueSent = false;
    this.wish();
    this.sendIsovalue();
  }

  setFocus(focus: readonly Focus[]): void {
    this.wish();
    this.client.setFocus(focus);
  }

  close(): void {
    this.hold.stop();
    this.client.close();
    this.host.stage.remove(this.surface);
  }

  private show(change: Change): void {
    this.surface.apply(change);
    this.pixelError = change.pixelError;
    const isComplete = this.isComplete(change);
    if (isComplete && !this.isSettled) this.milliseconds = performance.now() - this.wished;
    this.isSettled = isComplete;
    this.host.stage.invalidate();
    this.host.changed(this);
  }

  private isComplete(change: Change): boolean {
    return change.isSettled && this.isOfLastWish(change.isovalue);
  }

  private wish(): void {
    this.wished = performance.now();
    this.isSettled = false;
  }

  /** The service counts isovalues as its field does, so the last digits may differ. */
  private isOfLastWish(isovalue: number): boolean {
    if (this.isovalue === null) return true;
    const slack = 1e-6 * Math.max(1, Math.abs(this.isovalue));
    return this.isIsovalueSent && Math.abs(isovalue - this.isovalue) <= slack;
  }
}
