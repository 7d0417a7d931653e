/** What there is to see, and ways to bring more. */
import { type SceneSummary, type Service, ServiceError } from '../service/service';
import { make, shownBytes } from './dom';

export interface ScenePickerHost {
  open(scene: string): void;
  /** A token is needed: whether there is another now. */
  askForToken(why: string): Promise<boolean>;
  /** Somebody has closed it, with or without a choice. */
  closed(): void;
}

/** Between two looks at scenes that are being prepared [ms]. */
const PATIENCE = 500;

export class ScenePicker {
  private readonly list = make('ul', { class: 'scenes' });
  private readonly message = make('p', { class: 'message', role: 'status' });
  private readonly more = make('div', { class: 'more' });
  private readonly file = make('input', {
    type: 'file',
    hidden: true,
    onchange: () => {
      const chosen = this.file.files?.[0];
      if (chosen) void this.attempt(`Sending ${chosen.name} …`, () => this.service.upload(chosen));
      this.file.value = '';
    },
  });
  readonly element = make(
    'dialog',
    { class: 'picker', 'aria-labelledby': 'picker-title' },
    make(
      'header',
      {},
      // gets the keyboard first, rather than what closes all this
      make('h1', { id: 'picker-title', tabindex: -1, autofocus: true }, 'Isofront'),
      make('button', { type: 'button', class: 'icon', 'aria-label': 'Close', onclick: () => this.element.close() }, '×'),
    ),
    make('p', {}, 'Isosurfaces at the detail that your view needs. Pick something to look at.'),
    this.message,
    this.list,
    this.more,
    this.file,
  );
  private timer = 0;

  constructor(
    private readonly service: Service,
    private readonly host: ScenePickerHost,
  ) {
    this.element.addEventListener('dragover', (event) => event.preventDefault());
    this.element.addEventListener('drop', (event) => {
      event.preventDefault();
      const dropped = event.dataTransfer?.files[0];
      if (dropped) void this.attempt(`Sending ${dropped.name} …`, () => this.service.upload(dropped));
    });
    this.element.addEventListener('close', () => {
      clearTimeout(this.timer);
      this.host.closed();
    });
  }

  async show(): Promise<void> {
    if (!this.element.open) this.element.showModal();
    await this.refresh();
    await this.offerMore();
  }

  private async refresh(): Promise<void> {
    clearTimeout(this.timer);
    try {
      const scenes = await this.service.scenes();
      this.message.textContent = scenes.length === 0 ? 'There is no scene yet: make one below.' : '';
      this.list.replaceChildren(...scenes.map((scene) => this.row(scene)));
      if (scenes.some((scene) => scene.state === 'preparing'))
        this.timer = window.setTimeout(() => void this.refresh(), PATIENCE);
    } catch (error) {
      const isRefused = error instanceof ServiceError && error.status === 401;
      if (isRefused && (await this.host.askForToken(error.message))) return this.refresh();
      this.message.textContent = messageOf(error);
      if (this.element.open && !isRefused)
        this.timer = window.setTimeout(() => void this.refresh(), 4 * PATIENCE);
    }
  }

  private row(scene: SceneSummary): HTMLElement {
    const remark =
      scene.state === 'ready'
        ? (scene.kind ?? '')
        : scene.state === 'failed'
          ? `failed: ${scene.failure ?? ''}`
          : 'being prepared …';
    return make(
      'li',
      {},
      make(
        'button',
        {
          type: 'button',
          disabled: scene.state !== 'ready',
          onclick: () => {
            this.host.open(scene.id);
            this.element.close();
          },
        },
        make('strong', {}, scene.name || scene.source),
        make('small', { class: scene.state === 'failed' ? 'failed' : '' }, remark),
      ),
    );
  }

  /** What scenes can be made of; nothing where the service doesn't say. */
  private async offerMore(): Promise<void> {
    const [files, formulas] = await Promise.all([
      this.service.files().catch(() => []),
      this.service.formulas().catch(() => []),
    ]);
    const parts: HTMLElement[] = [
      make('button', { type: 'button', onclick: () => this.file.click() }, 'Send a file …'),
    ];
    if (files.length > 0)
      parts.push(
        this.menu(
          "Of the service's files …",
          files.map((file) => [file.path, `${file.path} (${shownBytes(file.bytes)})`]),
          (path) => this.service.create({ name: nameOf(path), file: path }),
        ),
      );
    if (formulas.length > 0)
      parts.push(
        this.menu(
          'Of a formula …',
          formulas.map((formula) => [formula.name, `${formula.name}: ${formula.description}`]),
          (name) => this.service.create({ name, formula: `proc:${name}` }),
        ),
      );
    this.more.replaceChildren(...parts);
  }

  private menu(
    title: string,
    items: [string, string][],
    create: (item: string) => Promise<unknown>,
  ): HTMLSelectElement {
    const select = make(
      'select',
      {
        'aria-label': title,
        onchange: () => {
          const item = select.value;
          select.selectedIndex = 0;
          void this.attempt(`Making ${item} …`, () => create(item));
        },
      },
      make('option', { value: '' }, title),
      ...items.map(([value, text]) => make('option', { value }, text)),
    );
    return select;
  }

  private async attempt(what: string, make_: () => Promise<unknown>): Promise<void> {
    this.message.textContent = what;
    try {
      await make_();
      await this.refresh();
    } catch (error) {
      const isRefused =
        error instanceof ServiceError && (error.status === 401 || error.status === 403);
      if (isRefused && (await this.host.askForToken(error.message))) return this.attempt(what, make_);
      this.message.textContent = messageOf(error);
    }
  }
}

function nameOf(path: string): string {
  return path.slice(path.lastIndexOf('/') + 1);
}

export function messageOf(error: unknown): string {
  const text = error instanceof Error ? error.message : String(error);
  return text.charAt(0).toUpperCase() + text.slice(1);
}
