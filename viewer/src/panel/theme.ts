/** Light or dark: as the system has it, until somebody says otherwise. */
import { make } from './dom';

const KEY = 'isofront-theme';

export class ThemeButton {
  readonly element = make('button', { type: 'button', onclick: () => this.turn() });

  constructor() {
    const chosen = localStorage.getItem(KEY);
    if (chosen === 'light' || chosen === 'dark') document.documentElement.dataset.theme = chosen;
    this.update();
  }

  private isDark(): boolean {
    const chosen = document.documentElement.dataset.theme;
    return chosen ? chosen === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
  }

  private turn(): void {
    const theme = this.isDark() ? 'light' : 'dark';
    document.documentElement.dataset.theme = theme;
    localStorage.setItem(KEY, theme);
    this.update();
  }

  private update(): void {
    this.element.textContent = this.isDark() ? 'Light' : 'Dark';
  }
}
