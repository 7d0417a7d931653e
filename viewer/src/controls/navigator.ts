/** Moves a pose as somebody's hands say: mouse, touch and keyboard, around something or flying. */
import {
  add,
  distanceOf,
  FIELD_OF_VIEW,
  looked,
  moved,
  orbited,
  type Pose,
  rayThrough,
  scale,
  zoomed,
} from './pose';
import type { Vector } from '../stream/protocol';

/** For a drag across the height of the picture [rad]. */
const TURN = Math.PI;
/** For a second of a key [rad]. */
const KEY_TURN = 1.2;
/** How many times nearer in a second of a key, or of a notch of the wheel. */
const KEY_ZOOM = 3;
const WHEEL_ZOOM = 1.0015;
/** How far one flies in a second, in distances to the surface. */
const FLY_SPEED = 0.8;

export interface NavigatorHost {
  pose(): Pose;
  setPose(pose: Pose): void;
  isFlying(): boolean;
  /** Whether a press on the picture is somebody else's: a brush. */
  isTaken(event: PointerEvent): boolean;
  /** How far the nearest of the surface is from the eye [world]. */
  clearance(): number;
  /** Where the surface is at a point of the picture, x and y from -1 to 1. */
  pick(x: number, y: number): Vector | null;
}

interface Pointer {
  x: number;
  y: number;
  pans: boolean;
}

export class Navigator {
  private readonly pointers = new Map<number, Pointer>();
  private readonly keys = new Set<string>();
  private speed = 1;
  private frame = 0;
  private last = 0;

  constructor(
    private readonly picture: HTMLElement,
    private readonly host: NavigatorHost,
  ) {
    picture.addEventListener('pointerdown', (event) => this.press(event));
    picture.addEventListener('pointermove', (event) => this.drag(event));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture'] as const)
      picture.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    picture.addEventListener('wheel', (event) => this.turnWheel(event), { passive: false });
    picture.addEventListener('contextmenu', (event) => event.preventDefault());
    picture.addEventListener('dblclick', (event) => this.lookAt(event));
    picture.addEventListener('keydown', (event) => this.pressKey(event));
    picture.addEventListener('keyup', (event) => this.keys.delete(event.code));
    picture.addEventListener('blur', () => this.keys.clear());
  }

  private press(event: PointerEvent): void {
    if (this.host.isTaken(event)) return;
    this.picture.focus({ preventScroll: true });
    this.picture.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, {
      x: event.clientX,
      y: event.clientY,
      pans: event.button !== 0 || event.shiftKey || event.ctrlKey || event.metaKey,
    });
  }

  private drag(event: PointerEvent): void {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return;
    const before = this.hands();
    const pans = pointer.pans;
    pointer.x = event.clientX;
    pointer.y = event.clientY;
    const after = this.hands();
    const height = this.picture.clientHeight;
    const dx = (after.x - before.x) / height;
    const dy = (after.y - before.y) / height;
    let pose = this.host.pose();
    if (this.pointers.size > 1 || pans) {
      pose = this.panned(pose, dx, dy);
      if (after.spread > 0 && before.spread > 0)
        pose = this.host.isFlying()
          ? moved(pose, 0, 0, (after.spread / before.spread - 1) * this.stride())
          : zoomed(pose, before.spread / after.spread);
    } else if (this.host.isFlying()) {
      pose = looked(pose, dx * TURN * 0.5, dy * TURN * 0.5);
    } else {
      pose = orbited(pose, -dx * TURN, -dy * TURN);
    }
    this.host.setPose(pose);
  }

  /** Where the pointers are together, and how far they are from there. */
  private hands(): { x: number; y: number; spread: number } {
    const all = [...this.pointers.values()];
    const x = all.reduce((sum, pointer) => sum + pointer.x, 0) / all.length;
    const y = all.reduce((sum, pointer) => sum + pointer.y, 0) / all.length;
    const spread = all.reduce((sum, pointer) => sum + Math.hypot(pointer.x - x, pointer.y - y), 0);
    return { x, y, spread: all.length > 1 ? spread : 0 };
  }

  /** The surface goes with the hand. */
  private panned(pose: Pose, dx: number, dy: number): Pose {
    const away = this.host.isFlying() ? this.stride() : distanceOf(pose);
    const high = 2 * away * Math.tan(FIELD_OF_VIEW / 2);
    return moved(pose, -dx * high, dy * high, 0);
  }

  private turnWheel(event: WheelEvent): void {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1;
    const factor = WHEEL_ZOOM ** (Math.max(-400, Math.min(400, event.deltaY * lines)) || 0);
    if (this.host.isFlying()) {
      this.speed = Math.min(Math.max(this.speed / factor, 1 / 64), 64);
      return;
    }
    const pose = this.host.pose();
    const [x, y] = this.place(event);
    const ray = rayThrough(pose, x, y, this.aspect());
    const under = add(pose.eye, scale(ray, distanceOf(pose)));
    this.host.setPose(zoomed(pose, factor, under));
  }

  /** A double click makes what is under it the middle. */
  private lookAt(event: MouseEvent): void {
    const place = this.host.pick(...this.place(event));
    if (place) this.host.setPose({ ...this.host.pose(), target: place });
  }

  private place(event: MouseEvent): [number, number] {
    const box = this.picture.getBoundingClientRect();
    return [
      (2 * (event.clientX - box.left)) / box.width - 1,
      1 - (2 * (event.clientY - box.top)) / box.height,
    ];
  }

  private aspect(): number {
    return this.picture.clientWidth / this.picture.clientHeight;
  }

  private stride(): number {
    return this.host.clearance() * this.speed;
  }

  private pressKey(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || !KEYS.has(event.code)) return;
    event.preventDefault();
    this.keys.add(event.code);
    if (this.frame === 0) {
      this.last = performance.now();
      this.frame = requestAnimationFrame((now) => this.step(now));
    }
  }

  private step(now: number): void {
    this.frame = 0;
    if (this.keys.size === 0) return;
    const seconds = Math.min((now - this.last) / 1000, 0.1);
    this.last = now;
    this.host.setPose(
      this.host.isFlying() ? this.flown(seconds) : this.turned(seconds),
    );
    this.frame = requestAnimationFrame((next) => this.step(next));
  }

  private axis(negative: string[], positive: string[]): number {
    const held = (codes: string[]) => (codes.some((code) => this.keys.has(code)) ? 1 : 0);
    return held(positive) - held(negative);
  }

  private flown(seconds: number): Pose {
    const pose = this.host.pose();
    const fast = this.keys.has('ShiftLeft') || this.keys.has('ShiftRight') ? 4 : 1;
    const step = this.stride() * FLY_SPEED * seconds * fast;
    const going = moved(
      pose,
      step * this.axis(['KeyA'], ['KeyD']),
      step * this.axis(['KeyQ', 'PageDown'], ['KeyE', 'PageUp']),
      step * this.axis(['KeyS'], ['KeyW']),
    );
    const turn = KEY_TURN * seconds;
    return looked(
      going,
      turn * this.axis(['ArrowRight'], ['ArrowLeft']),
      turn * this.axis(['ArrowDown'], ['ArrowUp']),
    );
  }

  private turned(seconds: number): Pose {
    let pose = this.host.pose();
    const turn = KEY_TURN * seconds;
    const step = distanceOf(pose) * seconds * 0.6;
    const side = this.axis(['ArrowLeft'], ['ArrowRight']);
    const rise = this.axis(['ArrowDown'], ['ArrowUp']);
    const pans = this.keys.has('ShiftLeft') || this.keys.has('ShiftRight');
    pose = pans ? moved(pose, step * side, step * rise, 0) : orbited(pose, turn * side, -turn * rise);
    pose = moved(
      pose,
      step * this.axis(['KeyA'], ['KeyD']),
      step * this.axis(['KeyS'], ['KeyW']),
      0,
    );
    const zoom = this.axis(['Minus', 'KeyQ', 'PageDown'], ['Equal', 'KeyE', 'PageUp']);
    return zoomed(pose, KEY_ZOOM ** (-zoom * seconds));
  }
}

const KEYS = new Set([
  'ArrowLeft',
  'ArrowRight',
  'ArrowUp',
  'ArrowDown',
  'PageUp',
  'PageDown',
  'Minus',
  'Equal',
  'KeyW',
  'KeyA',
  'KeyS',
  'KeyD',
  'KeyQ',
  'KeyE',
  'ShiftLeft',
  'ShiftRight',
]);
