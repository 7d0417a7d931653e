import './style.css';
import { App } from './app/app';
import { make } from './panel/dom';

const root = document.getElementById('app') as HTMLElement;
try {
  new App(root).begin();
} catch (error) {
  console.error(error);
  root.replaceChildren(
    make(
      'div',
      { class: 'status failed' },
      'This browser has no WebGL 2, or it is switched off. Surfaces need it: try another browser, or allow the graphics card to be used.',
    ),
  );
}
