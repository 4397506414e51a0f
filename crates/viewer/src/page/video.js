// Moving frames as H.264: the server sends them where the line is too slow for JPEGs, if this page can decode them.

/** Constrained baseline of level 5.2: what the server encodes has no more. */
const CODEC = { codec: "avc1.42e034", optimizeForLatency: true };

/** Whether this browser decodes them. `VideoDecoder` is there where the page is a secure context, as on 127.0.0.1. */
export async function canDecode() {
  if (!("VideoDecoder" in window)) return false;
  try {
    return (await VideoDecoder.isConfigSupported(CODEC)).supported === true;
  } catch {
    return false;
  }
}

/** Decodes the frames of a connection, in the order in which they come. */
export class FrameDecoder {
  #decoder = null;
  /** Who waits for which frame. */
  #waiting = new Map();

  /** The bitmap of a frame. Rejects where it cannot be decoded, and then for each frame before the next key frame. */
  decode({ frame, key }, bytes) {
    return new Promise((resolve, reject) => {
      if (key) this.#restart();
      if (this.#decoder?.state !== "configured") return reject(new Error("no key frame has come"));
      this.#waiting.set(frame, { resolve, reject });
      this.#decoder.decode(new EncodedVideoChunk({ type: key ? "key" : "delta", timestamp: frame, data: bytes }));
    });
  }

  close() {
    if (this.#decoder && this.#decoder.state !== "closed") this.#decoder.close();
    this.#decoder = null;
    this.#fail(new Error("the decoder was closed"));
  }

  #restart() {
    // What was handed in before comes out first.
    const before = this.#decoder;
    before?.flush().catch(() => {}).finally(() => { if (before.state !== "closed") before.close(); });
    const decoder = new VideoDecoder({
      output: async (video) => {
        const waiting = this.#waiting.get(video.timestamp);
        this.#waiting.delete(video.timestamp);
        try {
          waiting?.resolve(await createImageBitmap(video));
        } catch (error) {
          waiting?.reject(error);
        }
        video.close();
      },
      error: (error) => this.#fail(error),
    });
    decoder.configure(CODEC);
    this.#decoder = decoder;
  }

  #fail(error) {
    for (const { reject } of this.#waiting.values()) reject(error);
    this.#waiting.clear();
  }
}
