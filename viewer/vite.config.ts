import { defineConfig } from 'vite';

// Where 'npm run dev' finds a service; the page that is built asks the one that it came from.
const service = process.env.ISOFRONT_SERVICE ?? 'http://127.0.0.1:8080';

export default defineConfig({
  base: './',
  build: {
    target: 'es2022',
    // Everything is a file of its own: the page's policy allows nothing inline.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 1024,
  },
  worker: { format: 'es' },
  server: { proxy: { '/v1': { target: service, ws: true, changeOrigin: true } } },
});
