/** The isosurfaces: their values, colours and opacities. */
import { MOST_SURFACES, type SurfaceState } from '../state/view-state';
import { make, shownNumber } from './dom';

export interface SurfaceListHost {
  change(key: number, change: Partial<SurfaceState>): void;
  add(): void;
  remove(key: number): void;
  choose(key: number): void;
}

interface Row {
  readonly element: HTMLElement;
  readonly value: HTMLInputElement;
  readonly colour: HTMLInputElement;
  readonly opacity: HTMLInputElement;
  readonly visible: HTMLInputElement;
  readonly remove: HTMLButtonElement;
}

export class SurfaceList {
  private readonly rows = new Map<number, Row>();
  private readonly list = make('ul', { class: 'surfaces' });
  private readonly addButton = make(
    'button',
    { type: 'button', class: 'quiet', onclick: () => this.host.add() },
    'Add a surface',
  );
  readonly element = make('div', {}, this.list, this.addButton);

  constructor(private readonly host: SurfaceListHost) {}

  update(surfaces: readonly SurfaceState[], chosen: number): void {
    for (const [key, row] of this.rows)
      if (surfaces.every((surface) => surface.key !== key)) {
        row.element.remove();
        this.rows.delete(key);
      }
    for (const surface of surfaces) {
      let row = this.rows.get(surface.key);
      if (!row) {
        row = this.makeRow(surface.key);
        this.rows.set(surface.key, row);
        this.list.append(row.element);
      }
      row.element.classList.toggle('chosen', surfaces.length > 1 && surface.key === chosen);
      // what somebody is typing is theirs
      if (document.activeElement !== row.value) row.value.value = shownNumber(surface.isovalue);
      row.colour.value = surface.colour;
      row.opacity.value = String(surface.opacity);
      row.visible.checked = surface.visible;
      row.remove.hidden = surfaces.length === 1;
    }
    this.addButton.hidden = surfaces.length === 0 || surfaces.length >= MOST_SURFACES;
  }

  private makeRow(key: number): Row {
    const change = (part: Partial<SurfaceState>) => this.host.change(key, part);
    const value = make('input', {
      type: 'text',
      inputmode: 'decimal',
      class: 'value',
      'aria-label': 'Isovalue',
      onfocus: () => this.host.choose(key),
      onchange: () => {
        const number = Number(value.value.replace(',', '.'));
        if (value.value.trim() !== '' && Number.isFinite(number)) change({ isovalue: number });
      },
      onkeydown: (event: KeyboardEvent) => {
        if (event.key === 'Enter') value.blur();
      },
    });
    const colour = make('input', {
      type: 'color',
      'aria-label': 'Colour',
      oninput: () => change({ colour: colour.value }),
    });
    const opacity = make('input', {
      type: 'range',
      min: 0.05,
      max: 1,
      step: 0.05,
      'aria-label': 'Opacity',
      title: 'Opacity',
      oninput: () => change({ opacity: Number(opacity.value) }),
    });
    const visible = make('input', {
      type: 'checkbox',
      'aria-label': 'Visible',
      title: 'Visible',
      onchange: () => change({ visible: visible.checked }),
    });
    const remove = make(
      'button',
      {
        type: 'button',
        class: 'icon',
        title: 'Remove this surface',
        'aria-label': 'Remove this surface',
        onclick: () => this.host.remove(key),
      },
      '×',
    );
    const element = make('li', {}, visible, colour, value, opacity, remove);
    return { element, value, colour, opacity, visible, remove };
  }
}
