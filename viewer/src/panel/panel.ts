/** All that lies beside and above the picture. */
import type { Scene, Service } from '../service/service';
import type { Store } from '../state/store';
import type { SurfaceState, ViewState } from '../state/view-state';
import { Detail, type Figures } from './detail';
import { make } from './dom';
import { Histogram } from './histogram';
import { Look } from './look';
import { ScenePicker } from './scene-picker';
import { SurfaceList } from './surface-list';
import { ThemeButton } from './theme';
import { TokenDialog } from './token-dialog';

export interface PanelHost {
  open(scene: string): void;
  brush(): { isOn: boolean; part: number };
  setBrush(isOn: boolean, part: number): void;
  resetView(): void;
  takePicture(): void;
  addSurface(): void;
}

export class Panel {
  private chosen = 0;
  private readonly title = make('button', {
    type: 'button',
    class: 'title',
    title: 'Choose another scene',
    onclick: () => void this.pickScene(),
  });
  private readonly flying = make('button', {
    type: 'button',
    title: 'Fly with W A S D, Q and E; look with the mouse',
    onclick: () => this.store.set({ flying: !this.store.get().flying }),
  });
  private readonly fold = make('button', {
    type: 'button',
    class: 'icon fold',
    'aria-expanded': 'true',
    'aria-controls': 'controls',
    'aria-label': 'Controls',
    onclick: () => this.toggle(),
  });
  private readonly histogram: Histogram;
  private readonly surfaces: SurfaceList;
  private readonly detail: Detail;
  private readonly look: Look;
  private readonly picker: ScenePicker;
  private readonly tokenDialog = new TokenDialog();
  private readonly status = make('div', { class: 'status', role: 'status', hidden: true });
  private readonly progress = make('div', { class: 'progress', 'aria-hidden': 'true' });
  private readonly element: HTMLElement;

  constructor(
    root: HTMLElement,
    private readonly service: Service,
    private readonly store: Store<ViewState>,
    host: PanelHost,
  ) {
    this.histogram = new Histogram({
      setIsovalue: (key, isovalue) => this.changeSurface(key, { isovalue }),
      choose: (key) => this.choose(key),
    });
    this.surfaces = new SurfaceList({
      change: (key, change) => this.changeSurface(key, change),
      add: () => host.addSurface(),
      remove: (key) =>
        store.set({ surfaces: store.get().surfaces.filter((surface) => surface.key !== key) }),
      choose: (key) => this.choose(key),
    });
    this.detail = new Detail((pixelError) => store.set({ pixelError }));
    this.look = new Look({
      set: (change) => store.set(change),
      setBrush: (isOn) => host.setBrush(isOn, host.brush().part),
      brushRadius: () => host.brush().part,
      setBrushRadius: (part) => host.setBrush(host.brush().isOn, part),
    });
    this.picker = new ScenePicker(service, {
      open: (scene) => host.open(scene),
      askForToken: (why) => this.askForToken(why),
      closed: () => {
        // of an address with a scene that isn't there, nothing is shown either
        if (this.store.get().scene === null || this.element.hidden)
          this.fail('Nothing is chosen yet.');
      },
    });
    const theme = new ThemeButton();
    this.element = make(
      'aside',
      { class: 'panel', 'aria-label': 'Controls', hidden: true },
      make('header', {}, this.title, this.fold),
      make(
        'div',
        { id: 'controls', class: 'controls' },
        make('section', {}, this.histogram.element, this.surfaces.element),
        this.detail.element,
        this.look.element,
        make(
          'section',
          { class: 'actions' },
          this.flying,
          make('button', { type: 'button', onclick: () => host.resetView() }, 'Reset view'),
          make('button', { type: 'button', onclick: () => host.takePicture() }, 'Picture'),
          make('button', { type: 'button', onclick: (event: MouseEvent) => void this.share(event) }, 'Copy link'),
          theme.element,
        ),
      ),
    );
    root.append(
      this.progress,
      this.status,
      this.element,
      this.picker.element,
      this.tokenDialog.element,
    );
  }

  pickScene(): Promise<void> {
    this.tell('');
    return this.picker.show();
  }

  setScene(scene: Scene | null): void {
    this.element.hidden = scene === null;
    if (!scene?.description) return;
    this.title.textContent = scene.name || scene.source;
    const { value_range, histogram } = scene.description;
    this.histogram.setValues(value_range[0], value_range[1], histogram);
  }

  update(isBrushing: boolean): void {
    const state = this.store.get();
    if (state.surfaces.every((surface) => surface.key !== this.chosen))
      this.chosen = state.surfaces[0]?.key ?? 0;
    this.histogram.update(state.surfaces, this.chosen);
    this.surfaces.update(state.surfaces, this.chosen);
    if (state.pixelError !== null) this.detail.update(state.pixelError);
    this.look.update(state, isBrushing);
    this.flying.textContent = state.flying ? 'Turn around' : 'Fly';
    this.flying.setAttribute('aria-pressed', String(state.flying));
  }

  choose(key: number): void {
    if (key === this.chosen) return;
    this.chosen = key;
    const { surfaces } = this.store.get();
    this.histogram.update(surfaces, key);
    this.surfaces.update(surfaces, key);
  }

  show(figures: Figures): void {
    this.detail.show(figures, this.store.get().pixelError ?? Infinity);
    this.progress.classList.toggle('busy', !figures.isSettled && !this.element.hidden);
  }

  /** Says something above the picture; nothing with an empty text. */
  tell(text: string, isBusy = false): void {
    this.status.hidden = text === '';
    this.status.classList.toggle('busy', isBusy);
    this.status.classList.remove('failed');
    this.status.replaceChildren(text);
  }

  /** Says what can't be helped, and what to do instead. */
  fail(text: string): void {
    this.tell(text);
    this.status.classList.add('failed');
    this.status.append(
      make('button', { type: 'button', class: 'main', onclick: () => void this.pickScene() }, 'Choose a scene'),
    );
  }

  async askForToken(why: string): Promise<boolean> {
    const token = await this.tokenDialog.ask(why);
    if (token) this.service.token = token;
    return token !== '';
  }

  private changeSurface(key: number, change: Partial<SurfaceState>): void {
    this.store.set({
      surfaces: this.store
        .get()
        .surfaces.map((surface) => (surface.key === key ? { ...surface, ...change } : surface)),
    });
  }

  private toggle(): void {
    const isFolded = this.element.classList.toggle('folded');
    this.fold.setAttribute('aria-expanded', String(!isFolded));
  }

  private async share(event: MouseEvent): Promise<void> {
    const button = event.currentTarget as HTMLButtonElement;
    try {
      await navigator.clipboard.writeText(location.href);
      button.textContent = 'Copied';
    } catch {
      button.textContent = 'See the address';
    }
    setTimeout(() => (button.textContent = 'Copy link'), 2000);
  }
}
