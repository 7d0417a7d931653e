/** Puts the parts together: the state decides what is asked for, drawn and shown beside it. */
import { Navigator } from '../controls/navigator';
import {
  distanceOf,
  FIELD_OF_VIEW,
  forwardOf,
  length,
  normalized,
  type Pose,
  subtract,
  upOf,
} from '../controls/pose';
import { Panel } from '../panel/panel';
import { messageOf } from '../panel/scene-picker';
import { pixelSize, Stage } from '../scene/stage';
import { type Scene, type SceneDescription, Service, ServiceError } from '../service/service';
import { fromAddress, toAddress } from '../state/address';
import { Store } from '../state/store';
import {
  INITIAL_STATE,
  LAND_PIXEL_ERROR,
  MOST_SPOTS,
  newSurface,
  type SurfaceState,
  type ViewState,
  VOLUME_PIXEL_ERROR,
} from '../state/view-state';
import type { Focus, Vector, View } from '../stream/protocol';
import { SurfaceStream } from './surface-stream';
import { throttled } from './throttle';

/** Pixels of the device to one of the page's at most: more cost time and are hardly seen. */
const MOST_PIXEL_RATIO = 2;
/** Between two looks at a scene that isn't ready, or a service that is gone [ms]. */
const PATIENCE = 1000;
/** A brushed spot is as fine as this part of the error elsewhere. */
const SPOT_FINENESS = 1 / 4;
/** How fast the error grows outside of a spot: as it does for what is further away. */
const SPOT_FALLOFF = 0.01;

export class App {
  private readonly service = new Service();
  private readonly store = new Store<ViewState>(INITIAL_STATE);
  private readonly stage: Stage;
  private readonly panel: Panel;
  private readonly streams = new Map<number, SurfaceStream>();
  private scene: SceneDescription | null = null;
  private isBrushing = false;
  private brushPart = 0.06; // of the scene's size
  private opening = 0;

  private readonly saveAddress = throttled(250, () => {
    const address = toAddress(this.store.get());
    if (address !== location.hash.slice(1))
      history.replaceState(null, '', address ? `#${address}` : location.pathname);
  });

  /** Throws if the browser can't show any of this. */
  constructor(private readonly root: HTMLElement) {
    const canvas = document.createElement('canvas');
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'application');
    canvas.setAttribute('aria-label', 'The surface: drag to turn, wheel to come nearer, arrow keys');
    root.append(canvas);
    this.stage = new Stage(canvas);
    this.panel = new Panel(root, this.service, this.store, {
      open: (scene) => this.start({ ...INITIAL_STATE, scene }),
      brush: () => ({ isOn: this.isBrushing, part: this.brushPart }),
      setBrush: (isOn, part) => this.setBrush(isOn, part),
      resetView: () => this.scene && this.store.set({ pose: poseOf(this.scene) }),
      takePicture: () => void this.takePicture(),
      addSurface: () => this.addSurface(),
    });
    new Navigator(canvas, {
      pose: () => this.pose(),
      setPose: (pose) => this.store.set({ pose }),
      isFlying: () => this.store.get().flying,
      isTaken: (event) => this.isBrushing && event.button === 0 && event.isPrimary,
      clearance: () => this.stage.clearance(),
      pick: (x, y) => this.stage.pick(x, y),
    });
    canvas.addEventListener('pointerdown', (event) => this.paint(event));
    canvas.addEventListener('pointermove', (event) => event.buttons === 1 && this.paint(event));
    canvas.addEventListener('webglcontextlost', (event) => {
      event.preventDefault();
      this.panel.tell('The graphics device was lost; the picture comes back when it does.');
    });
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.store.listen((state, before) => this.follow(state, before));
    window.addEventListener('hashchange', () => {
      if (location.hash.slice(1) !== toAddress(this.store.get())) this.begin();
    });
  }

  /** Goes to what the address says. */
  begin(): void {
    void this.start(fromAddress(location.hash.slice(1)));
  }

  private async start(wanted: ViewState): Promise<void> {
    const opening = ++this.opening;
    this.closeStreams();
    this.scene = null;
    this.panel.setScene(null);
    this.store.set({ ...wanted });
    if (!wanted.scene) {
      await this.panel.pickScene();
      return;
    }
    this.panel.tell('Opening the scene …', true);
    const scene = await this.readyScene(wanted.scene, opening);
    if (!scene || opening !== this.opening) return;
    this.panel.tell('');
    const description = scene.description as SceneDescription;
    this.scene = description;
    this.panel.setScene(scene);
    document.title = `${scene.name || scene.source} – Isofront`;
    const pose = wanted.pose ? { ...wanted.pose, up: description.view.up } : poseOf(description);
    const surfaces =
      wanted.surfaces.length > 0 ? wanted.surfaces : [newSurface(description.isovalue, [])];
    const usual = description.terrain ? LAND_PIXEL_ERROR : VOLUME_PIXEL_ERROR;
    this.store.set({ pose, surfaces, pixelError: wanted.pixelError ?? usual });
  }

  /** Waits until a scene can be shown; nothing if somebody wants another meanwhile, or it can't be. */
  private async readyScene(id: string, opening: number): Promise<Scene | null> {
    while (opening === this.opening) {
      try {
        const scene = await this.service.scene(id);
        if (scene.state === 'ready') return scene;
        if (scene.state === 'failed') {
          this.panel.fail(`The scene can't be shown: ${scene.failure ?? 'it failed'}.`);
          return null;
        }
        this.panel.tell('The scene is being prepared …', true);
      } catch (error) {
        const status = error instanceof ServiceError ? error.status : -1;
        if (status === 401) {
          if (await this.panel.askForToken(messageOf(error))) continue;
          this.panel.fail('The scene needs a token.');
          return null;
        }
        if (status !== 0 && status !== 503) {
          this.panel.fail(`${messageOf(error)}.`);
          return null;
        }
        this.panel.tell(`${messageOf(error)} Trying again …`, true);
      }
      await new Promise((done) => setTimeout(done, PATIENCE));
    }
    return null;
  }

  private pose(): Pose {
    return this.store.get().pose ?? { eye: [3, 3, 3], target: [0, 0, 0], up: [0, 0, 1] };
  }

  private pixelError(): number {
    return this.store.get().pixelError ?? VOLUME_PIXEL_ERROR;
  }

  private follow(state: ViewState, before: ViewState): void {
    if (this.scene) {
      this.followSurfaces(state, before);
      const isViewNew = state.pose !== before.pose || state.pixelError !== before.pixelError;
      if (isViewNew) this.sendViews();
      if (state.spots !== before.spots)
        for (const stream of this.streams.values()) stream.setFocus(this.focus());
      this.saveAddress();
    }
    if (state.pose && state.pose !== before.pose) this.stage.setPose(state.pose);
    this.stage.setLook({
      shading: state.shading,
      wireframe: state.wireframe,
      isLand: this.scene?.terrain ?? false,
      clip: this.clip(state),
      spots: this.isBrushing ? state.spots : [],
    });
    this.panel.update(this.isBrushing);
    this.report();
  }

  private followSurfaces(state: ViewState, before: ViewState): void {
    for (const [key, stream] of this.streams)
      if (state.surfaces.every((surface) => surface.key !== key)) {
        stream.close();
        this.streams.delete(key);
      }
    for (const surface of state.surfaces) {
      const stream = this.streams.get(surface.key) ?? this.openStream(state, surface.key);
      const appears = surface.visible && !stream.surface.look.visible;
      stream.surface.look = surface;
      if (appears) stream.setView(this.view());
      stream.setIsovalue(surface.isovalue);
    }
    if (state.surfaces !== before.surfaces) this.stage.invalidate();
  }

  private openStream(state: ViewState, key: number): SurfaceStream {
    const stream = new SurfaceStream(this.service.streamUrl(state.scene as string), this.service.token, {
      stage: this.stage,
      changed: () => this.report(),
      welcomed: () => this.stage.invalidate(),
      connection: (_, connection) => {
        if (connection === 'lost') void this.explainLoss();
        else if (connection === 'open') this.panel.tell('');
        this.report();
      },
      refused: (why) => this.panel.tell(`${messageOf(new Error(why))}.`),
    });
    this.streams.set(key, stream);
    if (state.spots.length > 0) stream.setFocus(this.focus());
    stream.setView(this.view());
    return stream;
  }

  /** A browser doesn't say why a connection can't be made; the service does. */
  private async explainLoss(): Promise<void> {
    const id = this.store.get().scene;
    if (!id) return;
    try {
      const scene = await this.service.scene(id);
      if (scene.state === 'ready') this.panel.tell('The connection was lost; trying again …', true);
      else this.panel.tell('The scene is being prepared …', true);
    } catch (error) {
      const status = error instanceof ServiceError ? error.status : 0;
      if (status === 404) this.panel.fail('The scene has been deleted.');
      else if (status === 401) {
        this.closeStreams();
        if (await this.panel.askForToken(messageOf(error))) this.begin();
      } else
        this.panel.tell(
          status === 0
            ? 'The service is not there; what you see is kept. Trying again …'
            : `${messageOf(error)}. Trying again …`,
          true,
        );
    }
  }

  private closeStreams(): void {
    for (const stream of this.streams.values()) stream.close();
    this.streams.clear();
  }

  private view(): View {
    const pose = this.pose();
    const { width, height } = this.stage.canvas;
    return {
      width: Math.max(width, 1),
      height: Math.max(height, 1),
      eye: pose.eye,
      forward: forwardOf(pose),
      up: upOf(pose),
      fieldOfView: FIELD_OF_VIEW,
      pixelError: this.pixelError(),
    };
  }

  private sendViews(): void {
    const view = this.view();
    // what isn't seen need not follow
    for (const stream of this.streams.values())
      if (stream.surface.look.visible) stream.setView(view);
  }

  private focus(): Focus[] {
    return this.store.get().spots.map((spot) => ({
      low: spot.centre,
      high: spot.centre,
      radius: spot.radius,
      error: spot.error,
      falloff: SPOT_FALLOFF,
    }));
  }

  private clip(state: ViewState): { normal: Vector; offset: number } | null {
    if (!state.clip || !this.scene) return null;
    const { axis, at, flipped } = state.clip;
    const [low, high] = this.scene.bounds;
    const offset = low[axis] + at * (high[axis] - low[axis]);
    const sign = flipped ? -1 : 1;
    const normal: [number, number, number] = [0, 0, 0];
    normal[axis] = sign;
    return { normal, offset: sign * offset };
  }

  private addSurface(): void {
    const { surfaces } = this.store.get();
    if (!this.scene) return;
    // somewhere else than those that are there
    const [low, high] = this.scene.value_range;
    const taken = [low, ...surfaces.map((one) => one.isovalue).sort((a, b) => a - b), high];
    let widest = 1;
    for (let i = 1; i < taken.length; ++i)
      if (taken[i] - taken[i - 1] > taken[widest] - taken[widest - 1]) widest = i;
    const surface: SurfaceState = newSurface((taken[widest - 1] + taken[widest]) / 2, surfaces);
    // what is around must let it be seen
    const others = surfaces.map((one) => (one.opacity === 1 ? { ...one, opacity: 0.5 } : one));
    this.store.set({ surfaces: [...others, surface] });
    this.panel.choose(surface.key);
  }

  private setBrush(isOn: boolean, part: number): void {
    this.isBrushing = isOn;
    this.brushPart = part;
    this.stage.canvas.classList.toggle('brushing', isOn);
    this.store.set({}); // all that shows it
  }

  private paint(event: PointerEvent): void {
    if (!this.isBrushing || event.button > 0 || !this.scene) return;
    const box = this.stage.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1;
    const y = 1 - (2 * (event.clientY - box.top)) / box.height;
    const centre = this.stage.pick(x, y);
    if (!centre) return;
    const state = this.store.get();
    const radius = this.brushPart * length(subtract(this.scene.bounds[1], this.scene.bounds[0]));
    const isThere = state.spots.some(
      (spot) => length(subtract(spot.centre, centre)) < 0.5 * Math.min(spot.radius, radius),
    );
    if (isThere || state.spots.length >= MOST_SPOTS) return;
    const error =
      SPOT_FINENESS * this.pixelError() * pixelSize(this.pose(), centre, this.stage.canvas.height);
    this.store.set({ spots: [...state.spots, { centre, radius, error }] });
  }

  private async takePicture(): Promise<void> {
    try {
      const background = getComputedStyle(document.documentElement).getPropertyValue('--sky');
      const url = URL.createObjectURL(await this.stage.picture(background.trim()));
      const link = document.createElement('a');
      link.href = url;
      link.download = `isofront-${new Date().toISOString().slice(0, 19).replaceAll(':', '')}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(url), 10_000);
    } catch (error) {
      this.panel.tell(messageOf(error));
    }
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.stage.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.stage.resize(clientWidth, clientHeight, Math.min(devicePixelRatio, MOST_PIXEL_RATIO));
    this.sendViews();
  }

  /** Tells how far all that is shown is: people in the panel, programs by attributes of the page. */
  private report(): void {
    const streams = [...this.streams.values()];
    const isSettled = streams.length > 0 && streams.every((stream) => stream.isSettled);
    const sum = (of: (stream: SurfaceStream) => number) =>
      streams.reduce((total, stream) => total + of(stream), 0);
    const triangles = sum((stream) => stream.surface.buffers.triangleCount);
    const wasSettled = this.root.dataset.settled === 'true';
    this.root.dataset.settled = String(isSettled);
    this.root.dataset.triangles = String(triangles);
    if (isSettled && !wasSettled) performance.mark('isofront:settled');
    this.panel.show({
      triangles,
      bytes: sum((stream) => stream.receivedBytes),
      milliseconds: isSettled ? Math.max(...streams.map((stream) => stream.milliseconds)) : null,
      pixelError: Math.max(0, ...streams.map((stream) => stream.pixelError)),
      isSettled,
    });
  }
}

/** Where a scene is best looked at: far enough away to see all of it. */
function poseOf(scene: SceneDescription): Pose {
  const { eye, target, up } = scene.view;
  const pose = { eye, target, up: normalized(up) };
  return distanceOf(pose) > 0 ? pose : { ...pose, eye: [target[0] + 1, target[1], target[2]] };
}
