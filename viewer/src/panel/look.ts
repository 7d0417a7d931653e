/** Ways of looking: shading, wireframe, a clipping plane, places of interest. */
import { SHADINGS, type Shading } from '../scene/surface-material';
import { AXES, type ClipState, type ViewState } from '../state/view-state';
import { make } from './dom';

export interface LookHost {
  set(change: Partial<ViewState>): void;
  setBrush(isOn: boolean): void;
  brushRadius(): number;
  setBrushRadius(part: number): void;
}

const SHADING_NAMES: Record<Shading, string> = {
  surface: 'Surface',
  levels: 'Levels',
  normals: 'Normals',
};

export class Look {
  private clip: ClipState | null = null;
  private readonly shadings = SHADINGS.map((shading) =>
    this.option(SHADING_NAMES[shading], () => this.host.set({ shading })),
  );
  private readonly wireframe = make('input', {
    type: 'checkbox',
    onchange: () => this.host.set({ wireframe: this.wireframe.checked }),
  });
  private readonly planes = [
    this.option('Off', () => this.host.set({ clip: null })),
    ...AXES.map((name, axis) =>
      this.option(name.toUpperCase(), () => this.setClip({ axis: axis as 0 | 1 | 2 })),
    ),
  ];
  private readonly place = make('input', {
    type: 'range',
    min: 0,
    max: 1,
    step: 0.002,
    'aria-label': 'Where the plane is',
    oninput: () => this.setClip({ at: Number(this.place.value) }),
  });
  private readonly flip = make(
    'button',
    {
      type: 'button',
      class: 'quiet',
      onclick: () => this.clip && this.setClip({ flipped: !this.clip.flipped }),
    },
    'Other side',
  );
  private readonly clipRow = make('div', { class: 'row', hidden: true }, this.place, this.flip);
  private readonly brush = make(
    'button',
    {
      type: 'button',
      'aria-pressed': 'false',
      title: 'Click or draw on the surface: it gets finer there',
      onclick: () => this.host.setBrush(this.brush.getAttribute('aria-pressed') !== 'true'),
    },
    'Brush',
  );
  private readonly radius = make('input', {
    type: 'range',
    min: 0.01,
    max: 0.3,
    step: 0.01,
    'aria-label': "The brush's size",
    oninput: () => this.host.setBrushRadius(Number(this.radius.value)),
  });
  private readonly clear = make(
    'button',
    { type: 'button', class: 'quiet', onclick: () => this.host.set({ spots: [] }) },
    'Clear',
  );
  readonly element = make(
    'section',
    {},
    group('Show', ...this.shadings),
    make('label', { class: 'check' }, this.wireframe, 'Triangles'),
    group('Cut', ...this.planes),
    this.clipRow,
    make('div', { class: 'row' }, make('span', { class: 'name' }, 'Finer here'), this.brush, this.radius, this.clear),
  );

  constructor(private readonly host: LookHost) {
    this.radius.value = String(host.brushRadius());
  }

  update(state: ViewState, isBrushing: boolean): void {
    this.clip = state.clip;
    this.shadings.forEach((button, i) => press(button, SHADINGS[i] === state.shading));
    this.wireframe.checked = state.wireframe;
    this.planes.forEach((button, i) => press(button, i === (state.clip ? state.clip.axis + 1 : 0)));
    this.clipRow.hidden = state.clip === null;
    if (state.clip) this.place.value = String(state.clip.at);
    press(this.brush, isBrushing);
    this.radius.hidden = !isBrushing;
    this.clear.hidden = state.spots.length === 0;
  }

  private setClip(change: Partial<ClipState>): void {
    const clip = this.clip ?? { axis: 0, at: 0.5, flipped: false };
    this.host.set({ clip: { ...clip, ...change } });
  }

  private option(name: string, choose: () => void): HTMLButtonElement {
    return make('button', { type: 'button', onclick: choose }, name);
  }
}

function press(button: HTMLElement, isPressed: boolean): void {
  button.setAttribute('aria-pressed', String(isPressed));
}

function group(name: string, ...buttons: HTMLButtonElement[]): HTMLElement {
  return make(
    'div',
    { class: 'row', role: 'group', 'aria-label': name },
    make('span', { class: 'name' }, name),
    make('div', { class: 'choice' }, ...buttons),
  );
}
