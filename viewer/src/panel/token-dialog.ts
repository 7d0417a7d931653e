/** Asks for a bearer token. */
import { make } from './dom';

export class TokenDialog {
  private readonly why = make('p');
  private readonly field = make('input', {
    type: 'password',
    autocomplete: 'off',
    'aria-label': 'Token',
    required: true,
  });
  readonly element = make(
    'dialog',
    { class: 'token' },
    make(
      'form',
      { method: 'dialog' },
      make('h2', {}, 'A token is needed'),
      this.why,
      this.field,
      make('button', { type: 'submit', class: 'main' }, 'Use it'),
    ),
  );

  ask(why: string): Promise<string> {
    this.why.textContent = `The service says: ${why}. It is kept until this tab is closed.`;
    this.field.value = '';
    this.element.showModal();
    return new Promise((answer) => {
      this.element.addEventListener('close', () => answer(this.field.value.trim()), { once: true });
    });
  }
}
