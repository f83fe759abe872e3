/** Whether this page can show video: by WebCodecs, which browsers give to secure addresses alone. */

/** Profile 0, 8 bits; of a level above all sizes of pictures. */
export const VP9: VideoDecoderConfig = { codec: "vp09.00.41.08", optimizeForLatency: true };

/** Why this page shows no VP9, for people; "": it does. */
export async function vp9Problem(secure: boolean, decoder: typeof VideoDecoder | undefined): Promise<string> {
  if (!decoder) {
    return secure
      ? "this browser has no video decoder for pages (WebCodecs)"
      : "browsers decode video for pages on https and localhost alone";
  }
  try {
    const { supported } = await decoder.isConfigSupported(VP9);
    return supported ? "" : "this browser does not decode VP9";
  } catch (error) {
    return `this browser does not decode VP9 (${error instanceof Error ? error.message : error})`;
  }
}
