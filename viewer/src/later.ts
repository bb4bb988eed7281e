// The hierarchy made by another thread, so that pictures go on meanwhile.

import type { MeshBVH, SerializedBVH } from "three-mesh-bvh";
import { hierarchy, unpacked } from "./hierarchy";
import HierarchyWorker from "./hierarchy.worker?worker&inline";

/** Calls `done` with the hierarchy by and by. Where there can be no other thread it is made in this one. */
export function hierarchyLater(polygons: Float32Array, done: (tree: MeshBVH) => void): { cancel: () => void } {
  let worker: Worker | null = null;
  let timer: ReturnType<typeof setTimeout> | undefined;
  const cancel = () => {
    clearTimeout(timer);
    worker?.terminate();
    worker = null;
  };
  const here = () => {
    cancel();
    timer = setTimeout(() => done(hierarchy(polygons)));
  };
  try {
    worker = new HierarchyWorker();
    worker.onerror = here;
    worker.onmessage = ({ data }: MessageEvent<SerializedBVH>) => {
      cancel();
      done(unpacked(data, polygons));
    };
    worker.postMessage(polygons);
  } catch {
    here();
  }
  return { cancel };
}
