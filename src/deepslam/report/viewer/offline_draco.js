// Draco's decoder out of the bundle itself: pages opened from disk may fetch nothing.
import {DRACOLoader} from 'three/addons/loaders/DRACOLoader.js';
import decoderWasm from 'draco-decoder-wasm';
import decoderWrapper from 'draco-decoder-wrapper';

export class OfflineDracoLoader extends DRACOLoader {
  _loadLibrary(url, responseType) {
    return Promise.resolve(responseType === 'text' ? decoderWrapper : decoderWasm.slice().buffer);
  }
}

export function toBytes(base64) {
  const text = atob(base64.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}
