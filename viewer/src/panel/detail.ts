/** The knob of the pixel error, and beside it what it costs. */
import { LEAST_PIXEL_ERROR, MOST_PIXEL_ERROR } from '../state/view-state';
import { make, shownBytes, shownCount, shownNumber, shownTime } from './dom';

export interface Figures {
  readonly triangles: number;
  readonly bytes: number;
  /** From the last wish to all of it being there; null while it isn't. */
  readonly milliseconds: number | null;
  /** That the service's limits leave [px]. */
  readonly pixelError: number;
  readonly isSettled: boolean;
}

/** Errors grow by factors, so the knob does. */
const toKnob = (error: number) => Math.log2(error);
const fromKnob = (knob: number) => Number((2 ** knob).toPrecision(3));

export class Detail {
  private readonly knob = make('input', {
    type: 'range',
    id: 'pixel-error',
    min: toKnob(LEAST_PIXEL_ERROR),
    max: toKnob(MOST_PIXEL_ERROR),
    step: 0.25,
    oninput: () => this.choose(fromKnob(Number(this.knob.value))),
  });
  private readonly shownError = make('output', { for: 'pixel-error' });
  private readonly triangles = make('dd');
  private readonly bytes = make('dd');
  private readonly time = make('dd');
  private readonly remark = make('p', { class: 'remark', hidden: true });
  readonly element = make(
    'section',
    {},
    make('label', { for: 'pixel-error' }, 'Error on the screen ', this.shownError),
    this.knob,
    make(
      'dl',
      { class: 'figures' },
      make('div', {}, make('dt', {}, 'triangles'), this.triangles),
      make('div', {}, make('dt', {}, 'received'), this.bytes),
      make('div', {}, make('dt', {}, 'complete in'), this.time),
    ),
    this.remark,
  );

  constructor(private readonly choose: (pixelError: number) => void) {}

  update(pixelError: number): void {
    this.knob.value = String(toKnob(pixelError));
    this.shownError.textContent = `${shownNumber(pixelError)} px`;
    this.knob.setAttribute('aria-valuetext', `${shownNumber(pixelError)} pixels`);
  }

  show(figures: Figures, asked: number): void {
    this.triangles.textContent = shownCount(figures.triangles);
    this.bytes.textContent = shownBytes(figures.bytes);
    this.time.textContent = figures.milliseconds === null ? '…' : shownTime(figures.milliseconds);
    const isCoarser = figures.isSettled && figures.pixelError > 1.01 * asked;
    this.remark.hidden = !isCoarser;
    this.remark.textContent = `The service's limits leave ${shownNumber(figures.pixelError)} px.`;
  }
}
