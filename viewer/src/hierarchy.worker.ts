// The other thread of hierarchy.ts.

import { packed } from "./hierarchy";

self.onmessage = ({ data }: MessageEvent<Float32Array>) => {
  const tree = packed(data);
  postMessage(tree, { transfer: [...tree.roots, ...(tree.indirectBuffer ? [tree.indirectBuffer.buffer] : [])] });
};
