/** How the values of a scene are distributed, with the isovalues as handles on it. */
import type { SurfaceState } from '../state/view-state';
import { make, makeSvg, shownNumber } from './dom';

export interface HistogramHost {
  /** Moves a surface to another isovalue. */
  setIsovalue(key: number, isovalue: number): void;
  choose(key: number): void;
}

const HEIGHT = 100; // of the drawing; its width is the number of bins
/** A step of an arrow key, and with shift, of the range. */
const STEP = 1 / 512;
const LONG_STEP = 1 / 32;

export class Histogram {
  readonly element = make('div', { class: 'histogram' });
  private readonly handles = new Map<number, HTMLElement>();
  private low = 0;
  private high = 1;
  private surfaces: readonly SurfaceState[] = [];
  private chosen = 0;
  private dragged: number | null = null;

  constructor(private readonly host: HistogramHost) {
    this.element.addEventListener('pointerdown', (event) => this.press(event));
    this.element.addEventListener('pointermove', (event) => this.drag(event));
    for (const end of ['pointerup', 'pointercancel'] as const)
      this.element.addEventListener(end, () => (this.dragged = null));
  }

  /** Shows other values. Counts are shown by their logarithm: most of a scan is air. */
  setValues(low: number, high: number, counts: readonly number[]): void {
    this.low = low;
    this.high = high > low ? high : low + 1;
    this.handles.clear();
    const most = Math.log1p(Math.max(1, ...counts));
    let path = `M0 ${HEIGHT}`;
    counts.forEach((count, i) => {
      const y = HEIGHT - (Math.log1p(count) / most) * (HEIGHT - 4);
      path += `L${i} ${y.toFixed(1)}L${i + 1} ${y.toFixed(1)}`;
    });
    path += `L${counts.length} ${HEIGHT}Z`;
    const drawing = makeSvg(
      'svg',
      { viewBox: `0 0 ${counts.length} ${HEIGHT}`, preserveAspectRatio: 'none', 'aria-hidden': 'true' },
      makeSvg('path', { d: path }),
    );
    this.element.replaceChildren(drawing);
  }

  update(surfaces: readonly SurfaceState[], chosen: number): void {
    this.surfaces = surfaces;
    this.chosen = chosen;
    for (const [key, handle] of this.handles)
      if (surfaces.every((surface) => surface.key !== key)) {
        handle.remove();
        this.handles.delete(key);
      }
    surfaces.forEach((surface, i) => {
      let handle = this.handles.get(surface.key);
      if (!handle) {
        handle = this.makeHandle(surface.key);
        this.handles.set(surface.key, handle);
        this.element.append(handle);
      }
      const place = (surface.isovalue - this.low) / (this.high - this.low);
      handle.style.left = `${100 * Math.min(Math.max(place, 0), 1)}%`;
      handle.style.setProperty('--colour', surface.colour);
      handle.classList.toggle('chosen', surface.key === chosen);
      handle.classList.toggle('hidden', !surface.visible);
      handle.setAttribute('aria-valuemin', String(this.low));
      handle.setAttribute('aria-valuemax', String(this.high));
      handle.setAttribute('aria-valuenow', String(surface.isovalue));
      handle.setAttribute('aria-valuetext', shownNumber(surface.isovalue));
      handle.setAttribute('aria-label', surfaces.length > 1 ? `Isovalue ${i + 1}` : 'Isovalue');
    });
  }

  private makeHandle(key: number): HTMLElement {
    return make('div', {
      class: 'handle',
      role: 'slider',
      tabindex: 0,
      onkeydown: (event: KeyboardEvent) => this.pressKey(event, key),
      onfocus: () => this.host.choose(key),
    });
  }

  /** The handle under the hand moves, or if there is none, the chosen one comes to it. */
  private press(event: PointerEvent): void {
    if (event.button !== 0 || this.surfaces.length === 0) return;
    event.preventDefault();
    this.element.setPointerCapture(event.pointerId);
    const value = this.valueAt(event);
    const reach = (14 / this.element.clientWidth) * (this.high - this.low);
    const near = [...this.surfaces]
      .filter((surface) => Math.abs(surface.isovalue - value) < reach)
      .sort((a, b) => Math.abs(a.isovalue - value) - Math.abs(b.isovalue - value));
    const surface =
      near[0] ?? this.surfaces.find((one) => one.key === this.chosen) ?? this.surfaces[0];
    this.dragged = surface.key;
    this.host.choose(surface.key);
    this.handles.get(surface.key)?.focus({ preventScroll: true });
    if (!near[0]) this.host.setIsovalue(surface.key, value);
  }

  private drag(event: PointerEvent): void {
    if (this.dragged !== null) this.host.setIsovalue(this.dragged, this.valueAt(event));
  }

  private valueAt(event: PointerEvent): number {
    const box = this.element.getBoundingClientRect();
    const part = Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1);
    return this.low + part * (this.high - this.low);
  }

  private pressKey(event: KeyboardEvent, key: number): void {
    const surface = this.surfaces.find((one) => one.key === key);
    if (!surface || event.ctrlKey || event.metaKey || event.altKey) return;
    const range = this.high - this.low;
    const step = range * (event.shiftKey ? LONG_STEP : STEP);
    const moves: Record<string, number> = {
      ArrowLeft: surface.isovalue - step,
      ArrowDown: surface.isovalue - step,
      ArrowRight: surface.isovalue + step,
      ArrowUp: surface.isovalue + step,
      PageDown: surface.isovalue - range * LONG_STEP,
      PageUp: surface.isovalue + range * LONG_STEP,
      Home: this.low,
      End: this.high,
    };
    const value = moves[event.key];
    if (value === undefined) return;
    event.preventDefault();
    this.host.setIsovalue(key, Math.min(Math.max(value, this.low), this.high));
  }
}
