import {defineConfig} from "vite";

// Relative paths, since a proxy may put the page below a folder; nothing inline, since the gateway's
// content policy forbids it.
export default defineConfig({
  base: "./",
  build: {
    outDir: process.env.LSS_PAGE_OUT || "dist",
    emptyOutDir: true,
    target: "es2021",
    assetsInlineLimit: 0,
    modulePreload: false,
    chunkSizeWarningLimit: 1000,
  },
});
